/*
 * The ports of a schema: its typed inputs and outputs, declared as members of a structure that derives from jde::Ports.
 * The host reads a constant of this structure, so a port's constructor is evaluated by the compiler.
 */
#ifndef JDE_PORTS_HPP
#define JDE_PORTS_HPP

#include "context.hpp"

namespace jde {

class Child;

namespace detail {

class Port;

/* No constant can call these: the compiler refuses a description that does, and shows the name. */
inline void the_default_of_a_modulation_is_outside_its_limits() noexcept {}
inline void the_least_value_of_a_modulation_exceeds_its_greatest() noexcept {}
inline void a_command_is_in_force_for_at_least_one_nanosecond() noexcept {}
inline void children_of_any_number_are_the_last_children() noexcept {}

/** What a schema says about its ports, for the tables. */
struct Access;

} // namespace detail

/** The ports and children of a schema: derive from it, and declare them as members. */
class Ports {
public:
    constexpr Ports() noexcept = default;
    Ports(const Ports &) = delete;
    Ports &operator=(const Ports &) = delete;

private:
    friend class detail::Port;
    friend class Child;
    friend struct detail::Access;

    /** Throws unless the schema of these ports is called. The same number would mean another port of another schema. */
    void check_called(const Context &cx, const char *name, const char *what) const
    {
        if (table_ != cx.ports()) {
            throw std::logic_error(std::string("`") + name + "` is a " + what +
                                   " of another schema than the one that is called; use it in calls of its own");
        }
    }

    const detail::Port *last_port_ = nullptr;
    const Child *last_child_ = nullptr;
    std::uint32_t port_count_ = 0;
    std::uint32_t child_count_ = 0;
    /** The table of the type of schema, once an instance exists. */
    const jde_port *table_ = nullptr;
};

/** A new value of the import re-evaluates the precondition, or a new command lets the driver iterate, at once (R12). */
inline constexpr struct Trigger {
} trigger;
/** The application may leave it unbound. */
inline constexpr struct Optional {
} optional;
/** The modulation states where the sensor is on the base. */
inline constexpr struct SensorMount {
} mount;
/** The modulation is a distance that the schema keeps from obstacles, or a zone around the base. */
inline constexpr struct Margin {
} margin;
/** The modulation is the greatest speed, turn rate, or change of one, that the schema asks of the base. */
inline constexpr struct Limit {
} limit;
/** The modulation is read when the schema awakes, and kept until it sleeps (R8). */
inline constexpr struct Fixed {
} fixed;
/** The values of the export are valid until they are replaced or retracted (R19): a map, a mission. */
inline constexpr struct Lasting {
} lasting;
/** How long a value of the export is valid without a newer one (R19); without it, three periods of the schema. */
struct validity {
    std::uint64_t nanoseconds;
    constexpr explicit validity(Nanoseconds time) noexcept : nanoseconds(static_cast<std::uint64_t>(time.count())) {}
};
/** The unit of a plain number: "m", "rad/s". */
struct unit {
    const char *symbol;
    constexpr explicit unit(const char *symbol) noexcept : symbol(symbol) {}
};
/** The name that a modulation had in the version before, which files and options may still use. */
struct was {
    const char *name;
    constexpr explicit was(const char *name) noexcept : name(name) {}
};
/** The least allowed number of a modulation. */
struct min {
    double value;
    constexpr explicit min(double value) noexcept : value(value) {}
};
/** The greatest allowed number of a modulation. */
struct max {
    double value;
    constexpr explicit max(double value) noexcept : value(value) {}
};

namespace detail {

/** Whether every pattern of bits is a value of `T`, so that ports may carry it. */
template <typename T>
inline constexpr bool is_carried = !std::is_same_v<T, bool> && !is_choice<T>;
#define JDE_CARRIED(T) \
    static_assert(detail::is_carried<T>, "only a modulation is a bool or a choice: other ports carry a jde::Flag or a std::uint8_t")

template <typename Option, typename... Allowed>
inline constexpr bool is_one_of = (std::is_same_v<Option, Allowed> || ...);

/** A port of any kind. */
class Port {
public:
    Port(const Port &) = delete;
    Port &operator=(const Port &) = delete;

protected:
    constexpr Port(Ports &owner, std::uint32_t kind, const char *name, const char *doc, const jde_type &type) noexcept
        : owner_(owner), previous_(owner.last_port_), number_(owner.port_count_),
          table_{sizeof(jde_port), kind, name, doc, "", &type, nullptr, nan, nan, 0, 0, 0, nullptr, 0, 0, nullptr}
    {
        owner.last_port_ = this;
        owner.port_count_++;
    }

    constexpr void set(Trigger) noexcept { table_.flags |= JDE_TRIGGER; }
    constexpr void set(Optional) noexcept { table_.flags |= JDE_OPTIONAL; }
    constexpr void set(Lasting) noexcept { table_.validity_ns = JDE_LASTING; }
    constexpr void set(validity validity) noexcept { table_.validity_ns = validity.nanoseconds; }
    constexpr void set(SensorMount) noexcept { table_.flags |= JDE_MOUNT; }
    constexpr void set(Margin) noexcept { table_.flags |= JDE_MARGIN; }
    constexpr void set(Limit) noexcept { table_.flags |= JDE_LIMIT; }
    constexpr void set(Fixed) noexcept { table_.flags |= JDE_FIXED; }
    constexpr void set(was former) noexcept { table_.former_name = former.name; }
    constexpr void set(unit unit) noexcept { table_.unit = unit.symbol; }
    constexpr void set(min least) noexcept { table_.min = least.value; }
    constexpr void set(max greatest) noexcept { table_.max = greatest.value; }

    const char *name() const noexcept { return table_.name; }

    /** The number of the port in the schema that is called. */
    std::uint32_t number(const Context &cx) const
    {
        owner_.check_called(cx, name(), "port");
        return number_;
    }

    /** Reads the newest value: its code is JDE_OK, JDE_NO_VALUE or JDE_UNBOUND. */
    std::int32_t read(const Context &cx, jde_sample &sample, std::size_t bytes, std::size_t alignment) const
    {
        const std::int32_t code = cx.host().read(cx.raw(), number(cx), &sample);
        if (code == JDE_NO_VALUE || code == JDE_UNBOUND) {
            return code;
        }
        if (code != JDE_OK) {
            broken(name(), "read", code);
        }
        if (sample.bytes != bytes || sample.data == nullptr || reinterpret_cast<std::uintptr_t>(sample.data) % alignment != 0) {
            throw std::logic_error(format("the host gave `%s` %llu bytes at %p, and its type has %zu bytes aligned to %zu", name(),
                                          static_cast<unsigned long long>(sample.bytes), sample.data, bytes, alignment));
        }
        return code;
    }

    /** Returns room for the next value; null if the port is unbound. */
    void *loan(const Context &cx) const
    {
        void *room = nullptr;
        const std::int32_t code = cx.host().loan(cx.raw(), number(cx), &room);
        if (code == JDE_UNBOUND) {
            return nullptr;
        }
        if (code != JDE_OK || room == nullptr) {
            broken(name(), "loan", code);
        }
        return room;
    }

    /** Publishes the loaned value as measured at `time`; 0 means now. */
    Outcome publish(const Context &cx, std::uint64_t time) const
    {
        return outcome(name(), "publish", cx.host().publish(cx.raw(), number_, time));
    }

    /** Writes a value. */
    template <typename T>
    Outcome put(const Context &cx, const T &value) const
    {
        void *const room = loan(cx);
        if (room == nullptr) {
            return Outcome::unbound;
        }
        std::memcpy(room, &value, sizeof value);
        return publish(cx, 0);
    }

    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

    const Ports &owner_;
    const Port *previous_;
    std::uint32_t number_;
    jde_port table_;

    friend struct Access;
};

/** What a value of a choice or a bool is on the wire. */
template <typename T>
constexpr Wire<T> wire(const T &value) noexcept
{
    if constexpr (std::is_same_v<Wire<T>, T>) {
        return value;
    } else {
        return static_cast<std::uint8_t>(value);
    }
}

namespace {

/** The names of a choice. */
template <typename T>
struct Names {
    static constexpr auto value = Choice<T>::names();
};

} // namespace

} // namespace detail

/** A value of an input, in place. It does not change until the present call returns. */
template <typename T>
class Sample {
public:
    constexpr Sample() noexcept = default;
    explicit Sample(const jde_sample &raw) noexcept : raw_(raw) {}

    /** Whether there is a value. */
    explicit operator bool() const noexcept { return raw_.data != nullptr; }
    const T &operator*() const noexcept { return *static_cast<const T *>(raw_.data); }
    const T *operator->() const noexcept { return static_cast<const T *>(raw_.data); }
    /** When it was measured or written, since the application's start. */
    Nanoseconds time() const noexcept { return Nanoseconds(static_cast<std::int64_t>(raw_.time_ns)); }
    /** How long ago that was. */
    Nanoseconds age(const Context &cx) const noexcept { return cx.now() > time() ? cx.now() - time() : Nanoseconds(0); }
    /** The sequence number of the value, from 1. */
    std::uint64_t sequence() const noexcept { return raw_.sequence; }
    /** The number of the instance that wrote it. */
    std::uint32_t writer() const noexcept { return raw_.writer; }
    /** Whether a command is in force; otherwise the value is the neutral one. */
    bool in_force() const noexcept { return (raw_.flags & JDE_SAMPLE_NEUTRAL) == 0; }
    /** Whether the modulation was never written; then the value is its default. */
    bool is_default() const noexcept { return (raw_.flags & JDE_SAMPLE_DEFAULT) != 0; }

private:
    jde_sample raw_ = {};
};

/** A variable of another schema that this one reads. */
template <typename T>
class Import : detail::Port {
    JDE_CARRIED(T);

public:
    template <typename... Options>
    constexpr Import(Ports &owner, const char *name, const char *doc, Options... options) noexcept
        : Port(owner, JDE_IMPORT, name, doc, detail::type_of<T>())
    {
        static_assert((detail::is_one_of<Options, Trigger, Optional, unit> && ...),
                      "an import takes jde::trigger, jde::optional and jde::unit");
        (set(options), ...);
    }

    /** The newest value, or an empty sample. */
    Sample<T> get(const Context &cx) const
    {
        jde_sample sample = {};
        return read(cx, sample, sizeof(T), alignof(T)) == JDE_OK ? Sample<T>(sample) : Sample<T>();
    }

    /** The newest value. Throws jde::NoValue if there is none, and jde::Failure if the application did not bind it. */
    Sample<T> require(const Context &cx) const
    {
        jde_sample sample = {};
        switch (read(cx, sample, sizeof(T), alignof(T))) {
        case JDE_OK: return Sample<T>(sample);
        case JDE_NO_VALUE: throw NoValue(std::string("import `") + name() + "` has no value");
        default: throw Failure(std::string("import `") + name() + "` is not bound; the application gives it under `imports`");
        }
    }

    /** Whether the application binds it. */
    bool is_bound(const Context &cx) const
    {
        jde_sample sample = {};
        return read(cx, sample, sizeof(T), alignof(T)) != JDE_UNBOUND;
    }
};

/** An input that the father or an operator writes while the schema runs. `T` is a value, bool, or a JDE_CHOICE. */
template <typename T>
class Modulation : detail::Port {
public:
    using Type = detail::Wire<T>;

    template <typename... Options>
    constexpr Modulation(Ports &owner, const char *name, const char *doc, T initial, Options... options) noexcept
        : Port(owner, JDE_MODULATION, name, doc, detail::type_of<T>()), initial_(detail::wire(initial))
    {
        static_assert((detail::is_one_of<Options, unit, min, max, SensorMount, Margin, Limit, Fixed, was> && ...),
                      "a modulation takes jde::unit, jde::min, jde::max, jde::mount, jde::margin, jde::limit, jde::fixed and jde::was");
        static_assert(std::is_arithmetic_v<T> || !(detail::is_one_of<Options, min, max> || ...),
                      "only a number has limits: jde::min and jde::max");
        table_.initial = &initial_;
        (set(options), ...);
        if constexpr (detail::is_choice<T>) {
            table_.choices = detail::Names<T>::value.data();
            table_.choice_count = static_cast<std::uint32_t>(detail::Names<T>::value.size());
            set(min(0.0));
            set(max(static_cast<double>(table_.choice_count) - 1.0));
        }
        if constexpr (std::is_arithmetic_v<Type>) {
            if (table_.min > table_.max) {
                detail::the_least_value_of_a_modulation_exceeds_its_greatest();
            }
            const double number = static_cast<double>(initial_);
            if (number < table_.min || number > table_.max) {
                detail::the_default_of_a_modulation_is_outside_its_limits();
            }
        }
    }

    /** The value. */
    T get(const Context &cx) const
    {
        const Type value = *sample(cx);
        if constexpr (detail::is_choice<T>) {
            if (value >= detail::Names<T>::value.size()) {
                throw std::logic_error(format("`%s` is none of its %zu choices", name(), detail::Names<T>::value.size()));
            }
            return static_cast<T>(value);
        } else if constexpr (std::is_same_v<T, bool>) {
            return value != 0;
        } else {
            return value;
        }
    }

    /** The value in place, with its time. */
    Sample<Type> sample(const Context &cx) const
    {
        jde_sample sample = {};
        const std::int32_t code = read(cx, sample, sizeof(Type), alignof(Type));
        if (code != JDE_OK) {
            detail::broken(name(), "read", code);
        }
        return Sample<Type>(sample);
    }

private:
    Type initial_;
    friend class Problems;
};

/** An input of a driver that reaches an actuator. */
template <typename T>
class Command : detail::Port {
    JDE_CARRIED(T);

public:
    /** `neutral` stops the actuator; a command is in force for `validity` without being repeated. */
    template <typename... Options>
    constexpr Command(Ports &owner, const char *name, const char *doc, T neutral, Nanoseconds validity, Options... options) noexcept
        : Port(owner, JDE_COMMAND, name, doc, detail::type_of<T>()), neutral_(neutral)
    {
        static_assert((detail::is_one_of<Options, Trigger, unit> && ...), "a command takes jde::trigger and jde::unit");
        if (validity.count() < 1) {
            detail::a_command_is_in_force_for_at_least_one_nanosecond();
        }
        table_.initial = &neutral_;
        table_.validity_ns = static_cast<std::uint64_t>(validity.count());
        (set(options), ...);
    }

    /** The command in force, or the neutral value. */
    Sample<T> get(const Context &cx) const
    {
        jde_sample sample = {};
        const std::int32_t code = read(cx, sample, sizeof(T), alignof(T));
        if (code != JDE_OK) {
            detail::broken(name(), "read", code);
        }
        return Sample<T>(sample);
    }

private:
    T neutral_;
};

template <typename T>
class Export;

/** Room for the next value of an export. Fill it completely; its bytes are arbitrary. Unpublished, it is dropped. */
template <typename T>
class Loan {
public:
    Loan(Loan &&other) noexcept = default;
    T &operator*() const noexcept { return *room_; }
    T *operator->() const noexcept { return room_; }
    /** Publishes the value as of now. Use the room no more. */
    void publish() && { port_.finish(cx_, 0); }
    /** Publishes the value as measured at this time since the application's start. */
    void publish_at(Nanoseconds time) && { port_.finish(cx_, Export<T>::stamp(time)); }

private:
    friend class Export<T>;
    Loan(const Export<T> &port, const Context &cx, T *room) noexcept : port_(port), cx_(cx), room_(room) {}
    const Export<T> &port_;
    const Context &cx_;
    T *room_;
};

/** A variable that this schema writes and any may read. */
template <typename T>
class Export : detail::Port {
    JDE_CARRIED(T);

public:
    template <typename... Options>
    constexpr Export(Ports &owner, const char *name, const char *doc, Options... options) noexcept
        : Port(owner, JDE_EXPORT, name, doc, detail::type_of<T>())
    {
        static_assert((detail::is_one_of<Options, Lasting, validity, unit> && ...),
                      "an export takes jde::lasting, jde::validity and jde::unit");
        (set(options), ...);
    }

    /** Writes a value. */
    void write(const Context &cx, const T &value) { *loan(cx) = value, finish(cx, 0); }
    /** Writes a value that was measured at this time since the application's start. */
    void write_at(const Context &cx, const T &value, Nanoseconds time) { *loan(cx) = value, finish(cx, stamp(time)); }
    /** Returns room for the next value, to fill a large one in place. */
    Loan<T> loan(const Context &cx)
    {
        void *const room = Port::loan(cx);
        if (room == nullptr) {
            detail::broken(name(), "loan", JDE_UNBOUND);
        }
        return Loan<T>(*this, cx, static_cast<T *>(room));
    }
    /** Retracts the newest value because it is no longer valid: readers have none until the next one. */
    void retract(const Context &cx)
    {
        if (!JDE_HOST_HAS(&cx.host(), retract)) {
            throw std::logic_error(std::string("`") + name() + "` cannot be retracted by this host; use a newer one");
        }
        const std::int32_t code = cx.host().retract(cx.raw(), number(cx));
        if (code != JDE_OK) {
            detail::broken(name(), "retract", code);
        }
    }

private:
    friend class Loan<T>;
    friend struct detail::Access;

    /* In the ABI 0 means now, so a time of 0 becomes 1 ns. */
    static std::uint64_t stamp(Nanoseconds time) noexcept { return time.count() > 0 ? static_cast<std::uint64_t>(time.count()) : 1; }
    void finish(const Context &cx, std::uint64_t time) const
    {
        const std::int32_t code = cx.host().publish(cx.raw(), number(cx), time);
        if (code != JDE_OK) {
            detail::broken(name(), "publish", code);
        }
    }
};

/** A driver's command that this motor schema writes. */
template <typename T>
class Actuator : detail::Port {
    JDE_CARRIED(T);

public:
    template <typename... Options>
    constexpr Actuator(Ports &owner, const char *name, const char *doc, Options... options) noexcept
        : Port(owner, JDE_ACTUATOR, name, doc, detail::type_of<T>())
    {
        static_assert((detail::is_one_of<Options, Optional, unit> && ...), "an actuator takes jde::optional and jde::unit");
        (set(options), ...);
    }

    /** Gives a command. */
    Outcome command(const Context &cx, const T &value) { return put(cx, value); }
};

#undef JDE_CARRIED

} // namespace jde

#endif
