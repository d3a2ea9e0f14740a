/*
 * The classes from which a schema derives: its kind, and the abilities that it has beyond its iterations.
 *
 * The host makes one call of an instance at a time, on any thread. A call that throws or does not return makes the schema
 * Faulted, with the text of the exception as the reason: std::logic_error and what is no std::exception count as a panic, and
 * any other std::exception as an error that the schema reports.
 */
#ifndef JDE_SCHEMA_HPP
#define JDE_SCHEMA_HPP

#include "children.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace jde {

/** What a schema is, beside its ports. */
struct About {
    /** Name of the type: lower-case letters, digits, `-`, `_`. */
    const char *name;
    /** What it does. The first line is a complete sentence. */
    const char *doc;
    /** Default period of its iterations. */
    Nanoseconds period;
    /** The longest that an iteration may take; 0 means the period. */
    Nanoseconds budget = Nanoseconds(0);
};

/** The result of a check. */
struct Precondition {
    bool ready;
    /** The urgency with which the schema competes, for policies that use it. It must be finite. */
    double urgency;

    Precondition(bool ready, double urgency = 0.0) noexcept : ready(ready), urgency(urgency) {}
};

/**
 * A task that runs by iterations. Derive from Motor, Perceptive or Driver, and define
 * `static constexpr jde::About about()`.
 */
class Schema {
public:
    /** The schema leaves SLEPT. */
    virtual void awake(Context &) {}
    /** One iteration, as WINNER. One that exceeds the budget is an overrun. */
    virtual void iterate(Context &cx) = 0;
    /** The schema enters SLEPT. A driver stops its actuators here. */
    virtual void sleep(Context &) {}

protected:
    /* So the destructor of a schema may throw: the boundary catches it. Otherwise it would end the application. */
    ~Schema() noexcept(false) {}
};

/** A schema that has a precondition, competes and commands. `P` has its ports and children. */
template <typename P = Ports>
class Motor : public P, public Schema {
public:
    using Declared = P;
    static constexpr std::uint32_t kind() noexcept { return JDE_MOTOR; }
    /** Returns whether the precondition holds now. A value that has not arrived yet is no failure. */
    virtual Precondition check(Context &) { return true; }
};

/** A schema that turns data into better data. */
template <typename P = Ports>
class Perceptive : public P, public Schema {
public:
    using Declared = P;
    static constexpr std::uint32_t kind() noexcept { return JDE_PERCEPTIVE; }
};

/** A schema that exports sensors and takes commands. */
template <typename P = Ports>
class Driver : public P, public Schema {
public:
    using Declared = P;
    static constexpr std::uint32_t kind() noexcept { return JDE_DRIVER; }
};

/** The ability of a father to arbitrate by itself (R4), in a group whose policy is "father". */
class Arbitrate {
public:
    /** Chooses among the awake children of a group, on a collision or an absence. If it fails, the order of priority decides. */
    virtual Verdict arbitrate(Context &cx, const Level &level) = 0;

protected:
    ~Arbitrate() = default;
};

namespace detail {

template <typename T>
std::string one()
{
    return std::string("a ") + type_of<T>().name;
}
template <typename T>
std::string several()
{
    return std::string("a row of ") + type_of<T>().name;
}

} // namespace detail

/** The memory that a schema saves. The form is that of schemas in Rust: a build in one language restores that of the other. */
class Saving {
public:
    template <typename T>
    void put(const T &value) { entry(detail::one<T>(), &value, sizeof value); }
    template <typename T>
    void put_all(Span<const T> values) { entry(detail::several<T>(), values.data(), values.size() * sizeof(T)); }
    void put_text(std::string_view text) { entry("a text", text.data(), text.size()); }
    const std::string &bytes() const noexcept { return bytes_; }

private:
    void entry(std::string_view what, const void *data, std::size_t length)
    {
        part(what.data(), what.size());
        part(data, length);
    }
    void part(const void *data, std::uint64_t length)
    {
        bytes_.append(reinterpret_cast<const char *>(&length), sizeof length);
        bytes_.append(static_cast<const char *>(data), static_cast<std::size_t>(length));
    }
    std::string bytes_;
};

/** The memory that another instance saved. Take it in the order of saving. Throws jde::Failure if something else comes. */
class Saved {
public:
    Saved(std::uint32_t version, std::string_view bytes) noexcept : version_(version), rest_(bytes) {}
    /** The version that saved it. */
    std::uint32_t version() const noexcept { return version_; }
    template <typename T>
    T take()
    {
        const std::string expected = detail::one<T>();
        const std::string_view bytes = entry(expected);
        T value;
        if (bytes.size() != sizeof value) {
            throw Failure(expected + " was to come, and one of another size was saved");
        }
        std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    template <typename T>
    std::vector<T> take_all()
    {
        const std::string expected = detail::several<T>();
        const std::string_view bytes = entry(expected);
        if (bytes.size() % sizeof(T) != 0) {
            throw Failure(expected + " was to come, and one of another size was saved");
        }
        std::vector<T> values(bytes.size() / sizeof(T));
        std::memcpy(values.data(), bytes.data(), bytes.size());
        return values;
    }
    std::string_view take_text() { return entry("a text"); }

private:
    std::string_view entry(const std::string &expected)
    {
        std::string_view what, bytes;
        if (!part(what) || !part(bytes)) {
            throw Failure(expected + " was to come, and nothing more was saved");
        }
        if (what != expected) {
            throw Failure(expected + " was to come, and " + std::string(what) + " was saved in version " + std::to_string(version_));
        }
        return bytes;
    }
    bool part(std::string_view &out) noexcept
    {
        std::uint64_t length = 0;
        if (rest_.size() < sizeof length) {
            return false;
        }
        std::memcpy(&length, rest_.data(), sizeof length);
        rest_.remove_prefix(sizeof length);
        if (rest_.size() < length) {
            return false;
        }
        out = rest_.substr(0, static_cast<std::size_t>(length));
        rest_.remove_prefix(out.size());
        return true;
    }
    std::uint32_t version_;
    std::string_view rest_;
};

/** The ability to keep memory through a reload. A class may define `static constexpr std::uint32_t version()`; it is 1 by default. */
class Memory {
public:
    static constexpr std::uint32_t version() noexcept { return 1; }
    /** Saves what the next build needs. It changes nothing. */
    virtual void save(Context &cx, Saving &saving) const = 0;
    /** Restores what another instance saved. If it fails, the other instance continues. */
    virtual void restore(Context &cx, Saved &saved) = 0;

protected:
    ~Memory() = default;
};

/** The problems of what the modulations name. */
class Problems {
public:
    explicit Problems(const jde_problems &raw) noexcept : raw_(raw) {}
    /** The schema would fail when it awakes, until a user changes the modulation. */
    template <typename T>
    void wrong(const Context &cx, const Modulation<T> &modulation, std::string_view text) { add(JDE_PROBLEM_WRONG, modulation.number(cx), text); }
    /** Something is missing at present; the schema would wait for it. */
    template <typename T>
    void unavailable(const Context &cx, const Modulation<T> &modulation, std::string_view text)
    {
        add(JDE_PROBLEM_UNAVAILABLE, modulation.number(cx), text);
    }

private:
    void add(std::uint32_t kind, std::uint32_t port, std::string_view text) { raw_.add(raw_.found, kind, port, text.data(), text.size()); }
    const jde_problems &raw_;
};

/** The ability to inspect what the modulations name, before the application starts. */
class Inspect {
public:
    /** Only reads, in an instance that never awakes. Only modulations have values. */
    virtual void inspect(Context &cx, Problems &problems) = 0;

protected:
    ~Inspect() = default;
};

/** The judgement of a command: jde::accept or jde::refuse. */
struct Judgement {
    bool accepted;
    std::string reason;
};
inline Judgement accept() noexcept { return {true, {}}; }
/** Refuses the command for a reason in the format of printf. */
JDE_FORMAT(1, 2) inline Judgement refuse(const char *format, ...)
{
    std::va_list arguments;
    va_start(arguments, format);
    Judgement judgement = {false, vformat(format, arguments)};
    va_end(arguments);
    return judgement;
}

/**
 * The ability of a perceptive schema to judge the commands of others before they take effect (R18). The class defines
 *
 *     static constexpr auto state() { return &SlowPorts::nearest; }     // the export by whose newest value it judges
 *     static jde::Judgement judge(const double &state, jde::Nanoseconds age, const jde::Twist &command);
 *
 * and may define
 *
 *     // a lesser command that may take effect instead of a refused one, if `judge` accepts it
 *     static std::optional<jde::Twist> limit(const double &state, jde::Nanoseconds age, const jde::Twist &command);
 *
 * The host calls them in the thread that commands, and in the guard's for a command that is in force, any number of times at
 * once: their result depends on their arguments alone, and they wait for nothing.
 */
class Guard {};

/** Separate thresholds to enter and to leave, so that a precondition near its limit does not chatter (R4). */
class Hysteresis {
public:
    /** Whether the value is low: at most `enter`, or at most `leave` if it was low before. */
    bool below(double value, double enter, double leave) noexcept
    {
        return holds_ = value <= (holds_ ? std::fmax(leave, enter) : enter);
    }
    /** Whether the value is high: at least `enter`, or at least `leave` if it was high before. */
    bool above(double value, double enter, double leave) noexcept
    {
        return holds_ = value >= (holds_ ? std::fmin(leave, enter) : enter);
    }
    bool holds() const noexcept { return holds_; }
    void reset() noexcept { holds_ = false; }

private:
    bool holds_ = false;
};

} // namespace jde

#endif
