/*
 * The children of a father: how it wakes, observes, modulates and arbitrates them.
 */
#ifndef JDE_CHILDREN_HPP
#define JDE_CHILDREN_HPP

#include "ports.hpp"

namespace jde {

/** The state of a schema. */
enum class State : std::uint32_t { slept = JDE_SLEPT, checking = JDE_CHECKING, ready = JDE_READY, winner = JDE_WINNER };

/** The state of a child, and whether it is Faulted. */
struct Status {
    State state;
    bool faulted;
};

/** The policy of a group. */
struct Policy {
    std::uint32_t code;
    Nanoseconds time;
    double number;

    /** The order in which the father names its children. */
    static constexpr Policy priority() noexcept { return {JDE_POLICY_PRIORITY, Nanoseconds(0), 0.0}; }
    /** The highest urgency. */
    static constexpr Policy urgency() noexcept { return {JDE_POLICY_URGENCY, Nanoseconds(0), 0.0}; }
    /** The winner stays for `dwell`, and until a rival is `hysteresis` more urgent. */
    static constexpr Policy sticky(Nanoseconds dwell, double hysteresis) noexcept { return {JDE_POLICY_STICKY, dwell, hysteresis}; }
    /** Each READY child in turn, for `turn` each. */
    static constexpr Policy round_robin(Nanoseconds turn) noexcept { return {JDE_POLICY_ROUND_ROBIN, turn, 0.0}; }
    /** The father's own arbitration. */
    static constexpr Policy father() noexcept { return {JDE_POLICY_FATHER, Nanoseconds(0), 0.0}; }
};

/** The group in which a motor child competes. */
struct group {
    const char *name;
    constexpr explicit group(const char *name) noexcept : name(name) {}
};
/** The child is a perceptive schema. */
inline constexpr struct PerceptiveChild {
} perceptive;

/** A role that a schema has for a child. */
class Child {
public:
    template <typename... Options>
    constexpr Child(Ports &owner, const char *name, const char *doc, Options... options) noexcept : Child(owner, name, doc, 0u)
    {
        static_assert((detail::is_one_of<Options, group, PerceptiveChild, Optional> && ...),
                      "a child takes jde::group, jde::perceptive and jde::optional");
        static_assert((detail::is_one_of<Options, group, PerceptiveChild> + ... + 0) == 1,
                      "a child has either a jde::group, if it is a motor schema, or jde::perceptive");
        (set(options), ...);
    }
    Child(const Child &) = delete;
    Child &operator=(const Child &) = delete;

    /** Wakes it. Has no effect on a child that is awake. */
    Outcome wake(const Context &cx) const { return detail::outcome(name(), "wake", cx.host().wake(cx.raw(), number(cx))); }
    /** Puts it and its subtree to sleep. */
    Outcome sleep(const Context &cx) const { return detail::outcome(name(), "sleep", cx.host().sleep(cx.raw(), number(cx))); }
    /** Its state. An unbound child sleeps. */
    Status status(const Context &cx) const
    {
        jde_child_status status = {sizeof(jde_child_status), JDE_SLEPT, 0, 0};
        const std::int32_t code = cx.host().child(cx.raw(), number(cx), &status);
        if (code != JDE_OK && code != JDE_UNBOUND) {
            detail::broken(name(), "child", code);
        }
        return {static_cast<State>(status.state), status.faulted != 0};
    }
    State state(const Context &cx) const { return status(cx).state; }
    /** Changes the policy of its group. */
    Outcome set_policy(const Context &cx, Policy policy) const
    {
        const auto time = static_cast<std::uint64_t>(policy.time.count());
        return detail::outcome(name(), "set_policy", cx.host().set_policy(cx.raw(), number(cx), policy.code, time, policy.number));
    }
    const char *name() const noexcept { return table_.name; }
    /** Its index among the children of its father. */
    constexpr std::uint32_t number() const noexcept { return number_; }

protected:
    /** Its number in the schema that is called. */
    std::uint32_t number(const Context &cx) const
    {
        owner_.check_called(cx, name(), "child");
        return number_;
    }
    constexpr Child(Ports &owner, const char *name, const char *doc, std::uint32_t flags) noexcept
        : owner_(owner), previous_(owner.last_child_), number_(owner.child_count_), table_{sizeof(jde_child), JDE_MOTOR, name, "", doc, flags, 0}
    {
        if (number_ > 0 && (previous_->table_.flags & JDE_MANY) != 0) {
            detail::children_of_any_number_are_the_last_children();
        }
        owner.last_child_ = this;
        owner.child_count_++;
    }
    constexpr void set(group group) noexcept { table_.group = group.name; }
    constexpr void set(PerceptiveChild) noexcept { table_.kind = JDE_PERCEPTIVE; }
    constexpr void set(Optional) noexcept { table_.flags |= JDE_OPTIONAL; }

    const Ports &owner_;
    const Child *previous_;
    std::uint32_t number_;
    jde_child table_;

    friend struct detail::Access;
};

/** Any number of motor children, which the application names and groups. The last of the children. */
class Children : Child {
public:
    constexpr Children(Ports &owner, const char *name, const char *doc, group of) noexcept : Child(owner, name, doc, JDE_MANY | JDE_OPTIONAL)
    {
        set(of);
    }

    /** Wakes all. Returns an outcome other than accepted if a child has one. */
    Outcome wake(const Context &cx) const { return each(cx, "wake", cx.host().wake); }
    /** Puts all to sleep. */
    Outcome sleep(const Context &cx) const { return each(cx, "sleep", cx.host().sleep); }

private:
    Outcome each(const Context &cx, const char *call, std::int32_t (*request)(jde_context *, std::uint32_t)) const
    {
        Outcome missed = Outcome::accepted;
        jde_child_status status = {sizeof(jde_child_status), JDE_SLEPT, 0, 0};
        /* It also ends in a call that the host has given up, because all its requests are refused. */
        for (std::uint32_t child = number(cx); cx.host().child(cx.raw(), child, &status) == JDE_OK; child++) {
            const Outcome outcome = detail::outcome(name(), call, request(cx.raw(), child));
            missed = outcome == Outcome::accepted ? missed : outcome;
        }
        return missed;
    }
};

/** A modulation of a child that this schema writes. */
template <typename T>
class Modulates : detail::Port {
public:
    /** `name` is that of the child's modulation. */
    template <typename... Options>
    constexpr Modulates(Ports &owner, const Child &child, const char *name, const char *doc, Options... options) noexcept
        : Port(owner, JDE_CHILD_MODULATION, name, doc, detail::type_of<T>())
    {
        static_assert((detail::is_one_of<Options, Optional, unit> && ...), "a child's modulation takes jde::optional and jde::unit");
        table_.child = child.number();
        (set(options), ...);
    }

    /** Writes it. */
    Outcome set(const Context &cx, const T &value) { return put(cx, detail::wire(value)); }

private:
    using Port::set;
};

/** A child that competes. */
struct Candidate {
    std::uint32_t child;
    State state;
    bool ready;
    double urgency;
};

/** The snapshot of a group for the father's own arbitration. It is valid until the call returns. */
class Level {
public:
    explicit Level(const jde_level &raw) noexcept : raw_(raw) {}
    /** Name of the group. */
    const char *group() const noexcept { return raw_.group; }
    /** Whether several children are READY; otherwise none is. */
    bool is_collision() const noexcept { return raw_.case_ == JDE_COLLISION; }
    /** The number of awake children. */
    std::size_t size() const noexcept { return raw_.candidate_count; }
    /** An awake child, in the father's order. */
    Candidate operator[](std::size_t index) const noexcept
    {
        /* The size of the first is the distance between two. */
        const char *const first = reinterpret_cast<const char *>(raw_.candidates);
        jde_candidate raw;
        std::memcpy(&raw, first + index * raw_.candidates->size, sizeof raw);
        return {raw.child, static_cast<State>(raw.state), raw.ready != 0, raw.urgency};
    }
    /** Whether the child is awake and READY. */
    bool is_ready(const Child &child) const noexcept
    {
        for (std::size_t index = 0; index < size(); index++) {
            if ((*this)[index].child == child.number()) {
                return (*this)[index].ready;
            }
        }
        return false;
    }
    /** Whether the child is WINNER now. */
    bool is_winner(const Child &child) const noexcept { return raw_.winner == static_cast<std::int32_t>(child.number()); }

private:
    const jde_level &raw_;
};

/** The father's choice. */
struct Verdict {
    std::int32_t child;
    std::string reason;

    static Verdict choose(const Child &child, std::string why) { return {static_cast<std::int32_t>(child.number()), std::move(why)}; }
    static Verdict nobody(std::string why) { return {-1, std::move(why)}; }
};

} // namespace jde

#endif
