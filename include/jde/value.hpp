/*
 * Values: the types of data that ports carry. A value is plain data of fixed size without gaps, whose fields are
 * described by a jde_type.
 */
#ifndef JDE_VALUE_HPP
#define JDE_VALUE_HPP

#if __cplusplus < 201703L
#error "the headers of jde for C++ need C++17: compile with -std=c++17"
#endif

#include "../jde_types.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace jde {

/** Elements in a row that belong to somebody else. It copies nothing, and is valid as long as they are. */
template <typename T>
class Span {
public:
    constexpr Span() noexcept = default;
    constexpr Span(T *first, std::size_t count) noexcept : first_(first), count_(count) {}
    /** The elements of an array, a std::vector or anything else with data() and size(). */
    template <typename All, typename = decltype(static_cast<T *>(std::data(std::declval<All &>())))>
    constexpr Span(All &all) noexcept : Span(std::data(all), std::size(all)) {}

    constexpr T *begin() const noexcept { return first_; }
    constexpr T *end() const noexcept { return first_ + count_; }
    constexpr T *data() const noexcept { return first_; }
    constexpr std::size_t size() const noexcept { return count_; }
    constexpr bool empty() const noexcept { return count_ == 0; }
    constexpr T &operator[](std::size_t index) const noexcept { return first_[index]; }

private:
    T *first_ = nullptr;
    std::size_t count_ = 0;
};

/** A UTF-8 text of up to `N` bytes in a value. */
template <std::size_t N>
struct Text {
    static_assert(N > 0 && N % 4 == 0, "the capacity of a jde::Text is a multiple of 4, so that no gap follows it");
    std::uint32_t length;
    char bytes[N];
};

/** Up to `N` elements in a value. */
template <typename T, std::size_t N>
struct Seq {
    static_assert(alignof(T) <= 8, "the elements of a jde::Seq are aligned to 8 bytes at most");
    std::uint32_t length;
    std::uint32_t spare;
    T items[N];
};

/** A truth value in a value: every pattern of bits is valid, which a bool does not permit. */
struct Flag {
    std::uint8_t byte;
    constexpr operator bool() const noexcept { return byte != 0; }
    constexpr Flag &operator=(bool value) noexcept { return byte = value ? 1 : 0, *this; }
};

/** Unused bytes of a value, where the compiler would leave a gap. */
template <std::size_t N>
struct Padding {
    std::uint8_t bytes[N];
};

/** Whether a type is a sequence of a value: jde::Seq, or a sequence of the standard types. */
template <typename S, typename = void>
inline constexpr bool is_sequence = false;
template <typename S>
inline constexpr bool is_sequence<S, std::void_t<decltype(std::declval<S &>().length), decltype(std::declval<S &>().items)>> = true;
/** Whether a type is a text of a value: jde::Text, or a text of the standard types. */
template <typename S, typename = void>
inline constexpr bool is_text = false;
template <typename S>
inline constexpr bool is_text<S, std::void_t<decltype(std::declval<S &>().length), decltype(std::declval<S &>().bytes)>> = true;

/** Returns the elements of a sequence, in place. A length beyond the capacity counts as the capacity. */
template <typename S, typename = std::enable_if_t<is_sequence<std::remove_const_t<S>>>>
constexpr auto elements(S &sequence) noexcept -> Span<std::remove_reference_t<decltype(sequence.items[0])>>
{
    const std::size_t length = sequence.length;
    return {sequence.items, length < std::size(sequence.items) ? length : std::size(sequence.items)};
}

/** Returns a text of a value, in place. */
template <typename S, typename = std::enable_if_t<is_text<S>>>
constexpr std::string_view text(const S &text) noexcept
{
    const std::size_t length = text.length;
    return {text.bytes, length < std::size(text.bytes) ? length : std::size(text.bytes)};
}

/** Sets the number of elements and returns them. New ones are not written. Throws std::length_error beyond the capacity. */
template <typename S, typename = std::enable_if_t<is_sequence<S>>>
constexpr auto resize(S &sequence, std::size_t count)
{
    if (count > std::size(sequence.items)) {
        throw std::length_error("a sequence for " + std::to_string(std::size(sequence.items)) + " elements cannot have " +
                                std::to_string(count));
    }
    sequence.length = static_cast<std::uint32_t>(count);
    return elements(sequence);
}

/** Appends an element. Throws std::length_error beyond the capacity. */
template <typename S, typename T, typename = std::enable_if_t<is_sequence<S>>>
constexpr void push(S &sequence, const T &element)
{
    const std::size_t count = elements(sequence).size();
    resize(sequence, count + 1)[count] = element;
}

/** Writes a text into a value. Throws std::length_error beyond the capacity. */
template <typename S, typename = std::enable_if_t<is_text<S>>>
void assign(S &text, std::string_view words)
{
    if (words.size() > std::size(text.bytes)) {
        throw std::length_error("a text for " + std::to_string(std::size(text.bytes)) + " bytes cannot have " +
                                std::to_string(words.size()));
    }
    text.length = static_cast<std::uint32_t>(words.size());
    std::memcpy(text.bytes, words.data(), words.size());
}

/** The description of a type of value: `static constexpr const jde_type &type()`. JDE_VALUE defines one. */
template <typename T>
struct Value;

/** Makes a structure with a jde_type in C's form a value. Use it outside all namespaces. */
#define JDE_DESCRIBED(structure, description)                                       \
    template <>                                                                     \
    struct jde::Value<structure> {                                                  \
        static constexpr const jde_type &type() noexcept { return description; }    \
    }

/**
 * Makes a structure a value: its name in the notation of ROS 2, what it means, and its fields in the order of their
 * places. Use it outside all namespaces.
 *
 *     JDE_VALUE(Doors, "my_msgs/msg/Doors", "Where the doors are.",
 *               JDE_MEMBER(places, "In the frame of the base."),
 *               JDE_MEMBER(narrowest, "Width of the narrowest.", "m"));
 */
#define JDE_VALUE(structure, ros_name, doc, ...)                                                            \
    template <>                                                                                             \
    struct jde::Value<structure> {                                                                          \
        using Self = structure;                                                                             \
        static constexpr const char *name() noexcept { return ros_name; }                                   \
        static constexpr const char *about() noexcept { return doc; }                                       \
        static constexpr auto fields() noexcept { return jde::detail::list(__VA_ARGS__); }                  \
        static constexpr const jde_type &type() noexcept { return jde::detail::Own<structure>::type; }      \
    }
/** A field of a JDE_VALUE: its name, what it means, and its unit if it is a number with one. */
#define JDE_MEMBER(...) JDE_MEMBER_OF(__VA_ARGS__, "", "", "")
#define JDE_MEMBER_OF(name, doc, unit, ...) jde::detail::field<decltype(Self::name)>(#name, offsetof(Self, name), doc, unit)

/** Whether a type is a value. */
template <typename T, typename = void>
inline constexpr bool is_value = false;
template <typename T>
inline constexpr bool is_value<T, std::void_t<decltype(Value<T>::type())>> = true;

namespace detail {

template <typename T>
inline constexpr bool never = false;

/** The number of a scalar's kind. */
template <typename T>
constexpr std::uint32_t scalar() noexcept
{
    if constexpr (std::is_same_v<T, Flag>) {
        return JDE_BOOL;
    } else if constexpr (std::is_same_v<T, float>) {
        return JDE_F32;
    } else if constexpr (std::is_same_v<T, double>) {
        return JDE_F64;
    } else {
        static_assert(std::is_integral_v<T> && !std::is_same_v<T, bool>,
                      "a field is a number, a jde::Flag (not a bool), a jde::Text, a jde::Seq, a jde::Padding, an array of one of "
                      "these, or a value of its own (JDE_VALUE)");
        constexpr std::uint32_t first = std::is_signed_v<T> ? JDE_I8 : JDE_U8;
        return first + (sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3);
    }
}

/** Completes a field with its element's kind or type. */
template <typename T>
constexpr jde_field of_element(jde_field field) noexcept
{
    if constexpr (is_value<T> && std::is_class_v<T>) {
        field.kind = JDE_STRUCT;
        field.value_type = &Value<T>::type();
    } else {
        field.kind = scalar<T>();
    }
    return field;
}

template <typename T>
inline constexpr std::size_t padding_of = 0;
template <std::size_t N>
inline constexpr std::size_t padding_of<Padding<N>> = N;

/** A field, and the bytes that it covers. */
struct Member {
    jde_field field;
    std::size_t from;
    std::size_t bytes;
};

template <typename F>
constexpr Member field(const char *name, std::size_t at, const char *doc, const char *unit) noexcept
{
    jde_field field = {sizeof(jde_field), JDE_U8, JDE_ONE, 1, name, doc, unit, at, 0, nullptr, 0, 0};
    if constexpr (padding_of<F> > 0) {
        field = {sizeof(jde_field), JDE_U8, JDE_PADDING, padding_of<F>, "_", "", "", at, 0, nullptr, 0, 0};
    } else if constexpr (is_sequence<F>) {
        using Element = std::remove_reference_t<decltype(std::declval<F &>().items[0])>;
        field.form = JDE_SEQUENCE;
        field.capacity = sizeof(F::items) / sizeof(Element);
        field.offset = at + offsetof(F, items);
        field.length_offset = at;
        field = of_element<Element>(field);
    } else if constexpr (is_text<F>) {
        field.form = JDE_TEXT;
        field.capacity = sizeof(F::bytes);
        field.offset = at + offsetof(F, bytes);
        field.length_offset = at;
    } else if constexpr (std::is_array_v<F>) {
        field.form = JDE_ARRAY;
        field.capacity = std::extent_v<F>;
        field = of_element<std::remove_extent_t<F>>(field);
    } else {
        field = of_element<F>(field);
    }
    return {field, at, sizeof(F)};
}

template <typename... Members>
constexpr std::array<Member, sizeof...(Members)> list(const Members &...members) noexcept
{
    return {{members...}};
}

template <typename T>
constexpr bool has_no_gap() noexcept
{
    std::size_t reached = 0;
    for (const Member &member : Value<T>::fields()) {
        if (member.from != reached) {
            return false;
        }
        reached += member.bytes;
    }
    return reached == sizeof(T);
}

template <typename T>
constexpr auto fields_of() noexcept
{
    std::array<jde_field, Value<T>::fields().size()> fields{};
    for (std::size_t index = 0; index < fields.size(); index++) {
        fields[index] = Value<T>::fields()[index].field;
    }
    return fields;
}

/* Tables have internal linkage: the system's loader would make one of the variables of all libraries and their builds that have the same name. */
namespace {

/** The tables of a value of JDE_VALUE. */
template <typename T>
struct Own {
    static_assert(std::is_trivially_copyable_v<T> && std::is_standard_layout_v<T>,
                  "a value is plain data: no pointers, no virtual functions, no containers of the standard library");
    static_assert(has_no_gap<T>(),
                  "JDE_VALUE names every field in the order of their places, and a jde::Padding wherever the compiler would leave a gap");
    static constexpr auto fields = fields_of<T>();
    static constexpr jde_type type = {sizeof(jde_type), static_cast<std::uint32_t>(fields.size()), Value<T>::name(), Value<T>::about(),
                                      sizeof(T), alignof(T), fields.data()};
};

} // namespace

} // namespace detail

/** A choice among names, for modulations: an enumeration over std::uint8_t that JDE_CHOICE makes one. */
template <typename T>
struct Choice;

/** Makes an enumeration over std::uint8_t a choice. The names are those of its numbers from 0 on. Use it outside all namespaces. */
#define JDE_CHOICE(enumeration, ...)                                             \
    template <>                                                                  \
    struct jde::Choice<enumeration> {                                            \
        static constexpr auto names() noexcept { return jde::detail::texts(__VA_ARGS__); } \
    }

namespace detail {

template <typename... Texts>
constexpr std::array<const char *, sizeof...(Texts)> texts(const Texts &...texts) noexcept
{
    return {{texts...}};
}

template <typename T, typename = void>
inline constexpr bool is_choice = false;
template <typename T>
inline constexpr bool is_choice<T, std::void_t<decltype(Choice<T>::names())>> = true;

/** What a port of type `T` carries: a choice and a bool are a byte. */
template <typename T>
using Wire = std::conditional_t<is_choice<T> || std::is_same_v<T, bool>, std::uint8_t, T>;

/** The description of the values of a port of type `T`. */
template <typename T>
constexpr const jde_type &type_of() noexcept
{
    if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, Flag>) {
        return jde_bool_type;
    } else if constexpr (std::is_same_v<T, float>) {
        return jde_float32_type;
    } else if constexpr (std::is_same_v<T, double>) {
        return jde_float64_type;
    } else if constexpr (is_value<T>) {
        return Value<T>::type();
    } else if constexpr (is_choice<T>) {
        static_assert(std::is_same_v<std::underlying_type_t<T>, std::uint8_t>, "a choice is an enumeration over std::uint8_t");
        return jde_uint8_type;
    } else if constexpr (std::is_integral_v<T>) {
        constexpr const jde_type *types[] = {&jde_uint8_type, &jde_uint16_type, &jde_uint32_type, &jde_uint64_type,
                                             &jde_int8_type,  &jde_int16_type,  &jde_int32_type,  &jde_int64_type};
        return *types[scalar<T>() - JDE_U8];
    } else {
        static_assert(never<T>, "this type cannot be the type of a port: use a number, a standard type of jde/types.hpp, or a "
                                "structure with JDE_VALUE");
    }
}

} // namespace detail

} // namespace jde

#endif
