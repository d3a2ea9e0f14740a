/*
 * The simulated application around a schema on the bench: values, children, time and authority, behind the functions of a
 * host. It selects nothing.
 */
#ifndef JDE_BENCH_STATE_HPP
#define JDE_BENCH_STATE_HPP

#include "plugin.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

namespace jde {

namespace detail {

struct BenchPort {
    jde_port table;
    bool bound = true;
    /** The newest value; none before the first one and after a retraction. */
    bool has_value = false;
    bool loaned = false;
    Nanoseconds time{0};
    std::uint64_t sequence = 0;
    /* Words are aligned as strictly as any value. */
    std::vector<std::max_align_t> newest, room;

    explicit BenchPort(const jde_port &port) : table(port), newest(words()), room(words()) {}
    std::size_t bytes() const noexcept { return static_cast<std::size_t>(table.value_type->bytes); }

private:
    std::size_t words() const noexcept { return bytes() / sizeof(std::max_align_t) + 1; }
};

struct BenchChild {
    jde_child table;
    State state = State::slept;
    Precondition precondition = false;
    bool faulted = false;
    std::optional<Policy> policy;
};

/** Whether every float of a value is finite. Elements beyond the length of a sequence are not checked. */
inline bool finite(const jde_type &type, const char *value)
{
    for (std::uint32_t index = 0; index < type.field_count; index++) {
        const jde_field &field = type.fields[index];
        std::uint32_t count = field.capacity;
        if (field.form == JDE_SEQUENCE || field.form == JDE_TEXT) {
            std::memcpy(&count, value + field.length_offset, sizeof count);
            count = count < field.capacity ? count : field.capacity;
        }
        for (std::uint32_t element = 0; element < count; element++) {
            const char *const at = value + field.offset;
            if (field.kind == JDE_STRUCT && !finite(*field.value_type, at + element * field.value_type->bytes)) {
                return false;
            }
            float single = 0.0f;
            double number = 0.0;
            if (field.kind == JDE_F32) {
                std::memcpy(&single, at + element * sizeof single, sizeof single);
            } else if (field.kind == JDE_F64) {
                std::memcpy(&number, at + element * sizeof number, sizeof number);
            }
            if (!std::isfinite(single) || !std::isfinite(number)) {
                return false;
            }
        }
    }
    return true;
}

/** The state of a bench, and the host's functions on it. A jde_context of the bench points to it. */
struct BenchState {
    std::deque<BenchPort> ports;
    std::deque<BenchChild> children;
    /** The names and groups of the children in the place of a role for any number of them. */
    std::vector<std::pair<std::string, std::string>> names;
    Nanoseconds now{0};
    bool authority = true;
    bool real_time = true;
    std::vector<std::pair<std::uint32_t, std::string>> log;
    std::optional<std::string> reason;
    /** Whether the present call must change nothing, and what it tried to change. */
    bool read_only = false;
    std::string attempt;

    explicit BenchState(const jde_schema &table)
    {
        for (std::uint32_t port = 0; port < table.port_count; port++) {
            ports.emplace_back(table.ports[port]);
        }
        for (std::uint32_t child = 0; child < table.child_count; child++) {
            children.push_back({table.children[child], State::slept, false, false, std::nullopt});
        }
    }

    /** Puts these children, each with its group, in the place of the role for any number of them. All are then asleep. */
    void name_children(const std::vector<std::pair<std::string, std::string>> &named)
    {
        names = named;
        const auto many = std::find_if(children.begin(), children.end(), [](const BenchChild &child) { return (child.table.flags & JDE_MANY) != 0; });
        if (many != children.end()) {
            jde_child role = many->table;
            children.erase(many, children.end());
            for (const auto &[name, group] : names) {
                role.name = name.c_str();
                role.group = group.c_str();
                children.push_back({role, State::slept, false, false, std::nullopt});
            }
        }
        for (BenchChild &child : children) {
            child = {child.table, State::slept, false, false, std::nullopt};
        }
    }

    jde_context *context() noexcept { return reinterpret_cast<jde_context *>(this); }
    static BenchState &of(jde_context *context) noexcept { return *reinterpret_cast<BenchState *>(context); }

    static const jde_host &host() noexcept
    {
        static const jde_host table = {sizeof(jde_host), JDE_ABI_MAJOR, JDE_ABI_MINOR, 0, read, loan, publish, wake, sleep, child, set_policy,
                                       time, seed, seed, name, say, fail, extension, retract, is_real_time};
        return table;
    }

    bool refuses(const char *what)
    {
        if (read_only && attempt.empty()) {
            attempt = what;
        }
        return read_only;
    }
    BenchPort *port(std::uint32_t number) noexcept { return number < ports.size() ? &ports[number] : nullptr; }

    static std::int32_t read(jde_context *context, std::uint32_t number, jde_sample *out)
    {
        BenchState &state = of(context);
        const BenchPort *const port = state.port(number);
        if (port == nullptr || out == nullptr || (port->table.kind != JDE_IMPORT && port->table.kind != JDE_MODULATION && port->table.kind != JDE_COMMAND)) {
            return JDE_BAD_ARGUMENT;
        }
        if (!port->bound) {
            return JDE_UNBOUND;
        }
        const bool ended = port->table.kind == JDE_COMMAND &&
                           state.now > port->time + Nanoseconds(static_cast<std::int64_t>(port->table.validity_ns));
        if (port->has_value && !ended) {
            *out = {port->newest.data(), port->bytes(), static_cast<std::uint64_t>(port->time.count()), port->sequence, 0, 0};
            return JDE_OK;
        }
        const std::uint32_t flags = port->table.kind == JDE_COMMAND ? JDE_SAMPLE_NEUTRAL : JDE_SAMPLE_DEFAULT;
        *out = {port->table.initial, port->bytes(), 0, port->sequence, 0, flags};
        return port->table.initial != nullptr ? JDE_OK : JDE_NO_VALUE;
    }

    static std::int32_t loan(jde_context *context, std::uint32_t number, void **out)
    {
        BenchState &state = of(context);
        BenchPort *const port = state.port(number);
        if (state.refuses("write")) {
            return JDE_REFUSED;
        }
        if (port == nullptr || out == nullptr || (port->table.kind != JDE_EXPORT && port->table.kind != JDE_ACTUATOR && port->table.kind != JDE_CHILD_MODULATION)) {
            return JDE_BAD_ARGUMENT;
        }
        if (!port->bound) {
            return JDE_UNBOUND;
        }
        port->loaned = true;
        *out = port->room.data();
        return JDE_OK;
    }

    static std::int32_t publish(jde_context *context, std::uint32_t number, std::uint64_t time_ns)
    {
        BenchState &state = of(context);
        BenchPort *const port = state.port(number);
        if (state.refuses("write")) {
            return JDE_REFUSED;
        }
        if (port == nullptr || !port->loaned) {
            return JDE_BAD_ARGUMENT;
        }
        port->loaned = false;
        if (port->table.kind != JDE_EXPORT && !state.authority) {
            return JDE_REFUSED;
        }
        if (port->table.kind != JDE_EXPORT && !finite(*port->table.value_type, reinterpret_cast<const char *>(port->room.data()))) {
            return JDE_NOT_FINITE;
        }
        port->newest = port->room;
        port->has_value = true;
        port->time = time_ns == 0 ? state.now : Nanoseconds(static_cast<std::int64_t>(time_ns));
        port->sequence++;
        return JDE_OK;
    }

    static std::int32_t wake(jde_context *context, std::uint32_t number)
    {
        return with_child(context, number, "wake a child", [](BenchChild &child) {
            if (child.state == State::slept) {
                child.state = child.table.kind == JDE_MOTOR ? State::checking : State::winner;
            }
        });
    }

    static std::int32_t sleep(jde_context *context, std::uint32_t number)
    {
        return with_child(context, number, "put a child to sleep", [](BenchChild &child) {
            child.state = State::slept;
            child.precondition = false;
        });
    }

    static std::int32_t child(jde_context *context, std::uint32_t number, jde_child_status *out)
    {
        const BenchState &state = of(context);
        if (number >= state.children.size() || out == nullptr) {
            return JDE_BAD_ARGUMENT;
        }
        const BenchChild &child = state.children[number];
        *out = {sizeof *out, static_cast<std::uint32_t>(child.state), child.faulted ? 1u : 0u, 0};
        return JDE_OK;
    }

    static std::int32_t set_policy(jde_context *context, std::uint32_t number, std::uint32_t policy, std::uint64_t time, double value)
    {
        BenchState &state = of(context);
        if (state.refuses("change a policy")) {
            return JDE_REFUSED;
        }
        const bool competes = number < state.children.size() && state.children[number].table.kind == JDE_MOTOR;
        const bool has_parameters = (policy != JDE_POLICY_ROUND_ROBIN || time > 0) &&
                                    (policy != JDE_POLICY_STICKY || (std::isfinite(value) && value >= 0.0));
        if (!competes || policy > JDE_POLICY_FATHER || !has_parameters) {
            return JDE_BAD_ARGUMENT;
        }
        return with_child(context, number, "", [&](BenchChild &child) {
            child.policy = Policy{policy, Nanoseconds(static_cast<std::int64_t>(time)), value};
        });
    }

    template <typename Request>
    static std::int32_t with_child(jde_context *context, std::uint32_t number, const char *what, Request request)
    {
        BenchState &state = of(context);
        if (state.refuses(what)) {
            return JDE_REFUSED;
        }
        if (number >= state.children.size()) {
            return JDE_BAD_ARGUMENT;
        }
        if (!state.authority) {
            return JDE_REFUSED;
        }
        request(state.children[number]);
        return JDE_OK;
    }

    static std::uint64_t time(jde_context *context) { return static_cast<std::uint64_t>(of(context).now.count()); }
    static std::uint64_t seed(jde_context *) { return 1; }
    static const char *name(jde_context *) { return "bench"; }
    static void say(jde_context *context, std::uint32_t level, const char *text, std::uint64_t length)
    {
        of(context).log.emplace_back(level, std::string(text, static_cast<std::size_t>(length)));
    }
    static void fail(jde_context *context, const char *text, std::uint64_t length)
    {
        of(context).reason = std::string(text, static_cast<std::size_t>(length));
    }
    static const void *extension(jde_context *, const char *) { return nullptr; }
    static std::int32_t retract(jde_context *context, std::uint32_t number)
    {
        BenchPort *const port = of(context).port(number);
        if (of(context).refuses("take a value back")) {
            return JDE_REFUSED;
        }
        if (port == nullptr || port->table.kind != JDE_EXPORT) {
            return JDE_BAD_ARGUMENT;
        }
        port->has_value = false;
        return JDE_OK;
    }
    static std::uint32_t is_real_time(jde_context *context) { return of(context).real_time ? 1 : 0; }
};

} // namespace detail
} // namespace jde

#endif
