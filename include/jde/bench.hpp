/*
 * A bench for tests of schemas in C++ and C. It uses the same tables as the host, without plugins, threads or a clock of its own.
 * It selects nothing: the test decides whether a motor schema is WINNER and what its children do. Unknown names, and values of
 * another type, throw std::invalid_argument, because they are mistakes of the test.
 */
#ifndef JDE_BENCH_HPP
#define JDE_BENCH_HPP

#include "bench_panel.hpp"
#include "bench_state.hpp"

namespace jde {

/** The failure of a call of a schema. */
class CallFailed : public Failure {
public:
    CallFailed(std::int32_t code, const std::string &reason) : Failure(reason), code_(code) {}
    /** Whether it threw std::logic_error or what is no std::exception; otherwise it reported an error. */
    bool panicked() const noexcept { return code_ == JDE_PANICKED; }
    /** Whether it only said that an import has no value, which is no fault (R19). */
    bool lacks_value() const noexcept { return code_ == JDE_NO_VALUE; }

private:
    std::int32_t code_;
};

/** The choice of a father's own arbitration. The child is empty if it chose none. */
struct Decision {
    std::string child;
    std::string reason;
};

/** A panel as it was drawn. */
class DrawnPanel {
public:
    explicit DrawnPanel(std::deque<DrawnWidget> widgets) : widgets_(std::move(widgets)) {}
    const std::deque<DrawnWidget> &widgets() const noexcept { return widgets_; }
    /** The widget with this id. */
    const DrawnWidget &widget(std::string_view id) const
    {
        for (const DrawnWidget &widget : widgets_) {
            if (widget.id == id) {
                return widget;
            }
        }
        throw std::invalid_argument("the panel has no widget `" + std::string(id) + "`");
    }
    /** The number that is shown with this label. */
    double value(std::string_view label) const
    {
        for (const DrawnWidget &widget : widgets_) {
            if (widget.kind == JDE_WIDGET_VALUE && widget.label == label) {
                return widget.raw.value;
            }
        }
        throw std::invalid_argument("the panel shows no value `" + std::string(label) + "`");
    }

private:
    std::deque<DrawnWidget> widgets_;
};

/** What a schema saved. */
struct Remembered {
    std::uint32_t version;
    std::string bytes;
};

/** A schema under test, in any language. At first it is asleep, at time 0, with authority over its actuators and children. */
class TableBench {
public:
    /** Creates an instance: `jde::TableBench bench(jde_plugin.schemas[0])`. Throws CallFailed if that fails. */
    explicit TableBench(const jde_schema &table) : table_(table), state_(table_)
    {
        instance_ = table_.create(&table_, &state_.host(), state_.context());
        if (instance_ == nullptr) {
            throw CallFailed(JDE_FAILED, state_.reason.value_or("`create` returned no instance, and gave no reason"));
        }
    }
    ~TableBench()
    {
        if (table_.destroy != nullptr) {
            table_.destroy(instance_);
        }
    }
    TableBench(const TableBench &) = delete;
    TableBench &operator=(const TableBench &) = delete;

    /* The calls that the host makes. They throw CallFailed if the schema throws. */
    void awake()
    {
        if (table_.awake != nullptr) {
            call([&](jde_context *cx) { return table_.awake(instance_, cx); });
        }
    }
    /** A schema other than a motor schema has no precondition. One that finds an import without a value is false. */
    Precondition check()
    {
        jde_precondition result = {sizeof result, 1, 0.0};
        try {
            if (table_.check != nullptr) {
                call([&](jde_context *cx) { return table_.check(instance_, cx, &result); });
            }
        } catch (const CallFailed &failure) {
            if (!failure.lacks_value()) {
                throw;
            }
            result.ready = 0;
        }
        return {result.ready != 0, result.urgency};
    }
    /** Forgets earlier commands first. */
    void iterate()
    {
        for (detail::BenchPort &port : state_.ports) {
            port.has_value = port.has_value && port.table.kind != JDE_ACTUATOR;
        }
        call([&](jde_context *cx) { return table_.iterate(instance_, cx); });
    }
    void sleep()
    {
        if (table_.sleep != nullptr) {
            call([&](jde_context *cx) { return table_.sleep(instance_, cx), JDE_OK; });
        }
    }
    /** The father's own arbitration of a group, of which two or more children are READY, or none. */
    Decision arbitrate(const char *group)
    {
        if (table_.arbitrate == nullptr) {
            throw std::invalid_argument("the schema has no arbitration");
        }
        std::vector<jde_candidate> candidates;
        std::size_t ready = 0;
        jde_level level = {sizeof level, JDE_ABSENCE, group, nullptr, 0, -1};
        for (std::uint32_t number = 0; number < state_.children.size(); number++) {
            const detail::BenchChild &child = state_.children[number];
            if (child.table.kind != JDE_MOTOR || std::string_view(child.table.group) != group || child.state == State::slept) {
                continue;
            }
            const bool holds = child.precondition.ready;
            candidates.push_back({sizeof(jde_candidate), number, static_cast<std::uint32_t>(child.state), holds ? 1u : 0u, child.precondition.urgency});
            ready += holds ? 1 : 0;
            level.winner = child.state == State::winner ? static_cast<std::int32_t>(number) : level.winner;
        }
        if (ready == 1) {
            throw std::invalid_argument(std::string("exactly one child of `") + group + "` is ready, so the host does not arbitrate");
        }
        level.case_ = ready > 0 ? JDE_COLLISION : JDE_ABSENCE;
        level.candidates = candidates.data();
        level.candidate_count = static_cast<std::uint32_t>(candidates.size());
        jde_verdict verdict = {sizeof verdict, -1, {}};
        call([&](jde_context *cx) { return table_.arbitrate(instance_, cx, &level, &verdict); });
        if (verdict.child >= 0 && std::none_of(candidates.begin(), candidates.end(), [&](const jde_candidate &candidate) {
                return candidate.child == static_cast<std::uint32_t>(verdict.child);
            })) {
            throw std::logic_error("it chose child " + std::to_string(verdict.child) + ", which is not a candidate of `" + group + "`");
        }
        return {verdict.child < 0 ? "" : state_.children[static_cast<std::size_t>(verdict.child)].table.name, verdict.reason};
    }
    /** Draws the panel, as if a viewer showed it. Throws CallFailed if a viewer would show the reason in its place. */
    DrawnPanel draw()
    {
        detail::BenchDrawing drawing;
        const jde_pen pen = drawing.pen();
        read_only("while its panel was drawn", [&](jde_context *cx) { return ability<jde_panel>(JDE_ABILITY_PANEL).draw(instance_, cx, &pen); });
        drawing.finish();
        if (!drawing.broken.empty()) {
            throw CallFailed(JDE_REFUSED, drawing.broken);
        }
        return DrawnPanel(std::move(drawing.widgets));
    }
    /** Performs a gesture of a kind, JDE_TOUCH_PRESSED to JDE_TOUCH_CHOSE, as the operator "ana@laptop". */
    void touch(std::uint32_t kind, const char *widget, double value = 0.0)
    {
        jde_gesture gesture = {sizeof gesture, kind, widget, "ana@laptop", nullptr, {}, {}, value, static_cast<std::uint32_t>(value), 0, 0, 0};
        touch(gesture);
    }
    /** Clicks at a place of a canvas, a scene or an image. */
    void click(const char *widget, double x, double y, double z = 0.0)
    {
        touch({sizeof(jde_gesture), JDE_TOUCH_CLICKED, widget, "ana@laptop", nullptr, {}, {x, y, z}, 0.0, 0, JDE_BUTTON_PRIMARY, 0, 0});
    }
    void touch(const jde_gesture &gesture)
    {
        call([&](jde_context *cx) { return ability<jde_panel>(JDE_ABILITY_PANEL).touch(instance_, cx, &gesture); });
    }
    /** Saves the memory, as for a reload. */
    Remembered save()
    {
        const auto &state = ability<jde_state>(JDE_ABILITY_STATE);
        Remembered remembered = {state.version, {}};
        const jde_saver saver = {sizeof saver, 0, reinterpret_cast<jde_saving *>(&remembered.bytes), append};
        read_only("in save, which changes nothing", [&](jde_context *cx) { return state.save(instance_, cx, &saver); });
        return remembered;
    }
    void restore(const Remembered &saved)
    {
        const auto &state = ability<jde_state>(JDE_ABILITY_STATE);
        read_only("in restore, which changes nothing", [&](jde_context *cx) { return state.restore(instance_, cx, saved.version, saved.bytes.data(), saved.bytes.size()); });
    }

    /* The inputs. */
    /** Publishes a value of an import, measured now. */
    template <typename T>
    void import(std::string_view name, const T &value) { put(port<T>(JDE_IMPORT, name), value); }
    /** Retracts the value of an import. */
    void retract(std::string_view name) { find(JDE_IMPORT, name).has_value = false; }
    /** Sets a modulation. It is finite and within its limits. */
    template <typename T>
    void set(std::string_view name, const T &value)
    {
        detail::BenchPort &port = this->port<T>(JDE_MODULATION, name);
        const detail::Wire<T> wire = detail::wire(value);
        std::memcpy(port.room.data(), &wire, sizeof wire);
        bool allowed = detail::finite(*port.table.value_type, reinterpret_cast<const char *>(port.room.data()));
        if constexpr (std::is_arithmetic_v<detail::Wire<T>>) {
            allowed = allowed && !(static_cast<double>(wire) < port.table.min) && !(static_cast<double>(wire) > port.table.max);
        }
        if (!allowed) {
            throw std::invalid_argument("the value of `" + std::string(name) + "` is outside its limits");
        }
        put(port, wire);
    }
    /** Gives a driver a command, now. */
    template <typename T>
    void command(std::string_view name, const T &value) { put(port<T>(JDE_COMMAND, name), value); }
    /** Leaves an optional import or actuator unbound. */
    void unbind(std::string_view name)
    {
        for (detail::BenchPort &port : state_.ports) {
            if (name == port.table.name && (port.table.flags & JDE_OPTIONAL) != 0) {
                port.bound = false;
                return;
            }
        }
        throw std::invalid_argument("there is no optional port `" + std::string(name) + "`");
    }

    /* The situation. */
    void set_now(Nanoseconds now) noexcept { state_.now = now; }
    void set_real_time(bool real_time) noexcept { state_.real_time = real_time; }
    /** Whether the schema is WINNER, and so are its fathers. */
    void set_authority(bool authority) noexcept { state_.authority = authority; }
    /** Names the children of a role that any number of them may have, each with its group. All children are then asleep. */
    void name_children(const std::vector<std::pair<std::string, std::string>> &named) { state_.name_children(named); }
    /** Sets the state of a child. One that is READY or WINNER has a precondition that holds. */
    void set_child(std::string_view role, State state)
    {
        child(role).state = state;
        child(role).precondition.ready = state == State::ready || state == State::winner;
    }
    void set_precondition(std::string_view role, Precondition precondition) { child(role).precondition = precondition; }
    void set_faulted(std::string_view role, bool faulted) { child(role).faulted = faulted; }

    /* The results. */
    /** The command of the last iteration. */
    template <typename T>
    std::optional<T> commanded(std::string_view name) { return written<T>(port<T>(JDE_ACTUATOR, name)); }
    /** The newest value of an export. */
    template <typename T>
    std::optional<T> exported(std::string_view name) { return written<T>(port<T>(JDE_EXPORT, name)); }
    /** The same, in place; null if there is none. */
    template <typename T>
    const T *exported_in_place(std::string_view name)
    {
        const detail::BenchPort &port = this->port<T>(JDE_EXPORT, name);
        return port.has_value ? reinterpret_cast<const T *>(port.newest.data()) : nullptr;
    }
    /** The time of the newest value of an export. */
    std::optional<Nanoseconds> exported_at(std::string_view name)
    {
        const detail::BenchPort &port = find(JDE_EXPORT, name);
        return port.has_value ? std::optional<Nanoseconds>(port.time) : std::nullopt;
    }
    /** What the schema wrote to a modulation of a child. */
    template <typename T>
    std::optional<T> modulated(std::string_view role, std::string_view name)
    {
        const auto number = static_cast<std::uint32_t>(index_of_child(role));
        for (detail::BenchPort &port : state_.ports) {
            if (port.table.kind == JDE_CHILD_MODULATION && port.table.child == number && name == port.table.name) {
                return written<T>(typed<T>(port));
            }
        }
        throw std::invalid_argument("it writes no modulation `" + std::string(name) + "` of `" + std::string(role) + "`");
    }
    /** The children that are awake, in the order of their roles. */
    std::vector<std::string> awake_children() const
    {
        std::vector<std::string> awake;
        for (const detail::BenchChild &child : state_.children) {
            if (child.state != State::slept) {
                awake.emplace_back(child.table.name);
            }
        }
        return awake;
    }
    State child_state(std::string_view role) { return child(role).state; }
    std::optional<Policy> policy(std::string_view role) { return child(role).policy; }
    /** The log: levels and texts. */
    const std::vector<std::pair<std::uint32_t, std::string>> &log() const noexcept { return state_.log; }

protected:
    const void *instance() const noexcept { return instance_; }

private:
    template <typename Call>
    void call(Call body)
    {
        state_.reason.reset();
        const std::int32_t code = body(state_.context());
        for (detail::BenchPort &port : state_.ports) {
            port.loaned = false;
        }
        if (code != JDE_OK || state_.reason) {
            throw CallFailed(code, state_.reason.value_or("it returned " + std::to_string(code)));
        }
    }
    template <typename Call>
    void read_only(const char *when, Call body)
    {
        state_.read_only = true;
        state_.attempt.clear();
        try {
            call(body);
        } catch (const CallFailed &) {
            state_.read_only = false;
            if (state_.attempt.empty()) {
                throw;
            }
        }
        state_.read_only = false;
        if (!state_.attempt.empty()) {
            throw CallFailed(JDE_REFUSED, "it tried to " + state_.attempt + " " + when);
        }
    }
    template <typename Table>
    const Table &ability(const char *id) const
    {
        const void *const table = table_.ability != nullptr ? table_.ability(id) : nullptr;
        if (table == nullptr) {
            throw std::invalid_argument(std::string("the schema does not have the ability `") + id + "`");
        }
        return *static_cast<const Table *>(table);
    }
    static std::int32_t append(jde_saving *saving, const void *bytes, std::uint64_t length)
    {
        reinterpret_cast<std::string *>(saving)->append(static_cast<const char *>(bytes), static_cast<std::size_t>(length));
        return JDE_OK;
    }
    detail::BenchPort &find(std::uint32_t kind, std::string_view name)
    {
        std::string others;
        for (detail::BenchPort &port : state_.ports) {
            if (port.table.kind == kind && name == port.table.name) {
                return port;
            }
            others += port.table.kind == kind ? std::string(" ") + port.table.name : "";
        }
        throw std::invalid_argument("there is no port `" + std::string(name) + "` of this kind, but" + (others.empty() ? " none" : others));
    }
    template <typename T>
    detail::BenchPort &typed(detail::BenchPort &port)
    {
        const jde_type &type = detail::type_of<T>();
        if (port.bytes() != type.bytes || std::string_view(type.name) != port.table.value_type->name) {
            throw std::invalid_argument(std::string("`") + port.table.name + "` is a " + port.table.value_type->name + ", not a " + type.name);
        }
        return port;
    }
    template <typename T>
    detail::BenchPort &port(std::uint32_t kind, std::string_view name) { return typed<T>(find(kind, name)); }
    template <typename T>
    void put(detail::BenchPort &port, const T &value)
    {
        std::memcpy(port.newest.data(), &value, sizeof value);
        port.has_value = true;
        port.bound = true;
        port.time = state_.now;
        port.sequence++;
    }
    template <typename T>
    std::optional<T> written(const detail::BenchPort &port)
    {
        if (!port.has_value) {
            return std::nullopt;
        }
        detail::Wire<T> wire;
        std::memcpy(&wire, port.newest.data(), sizeof wire);
        return static_cast<T>(wire);
    }
    std::size_t index_of_child(std::string_view role)
    {
        for (std::size_t index = 0; index < state_.children.size(); index++) {
            if (role == state_.children[index].table.name) {
                return index;
            }
        }
        throw std::invalid_argument("there is no child `" + std::string(role) + "`");
    }
    detail::BenchChild &child(std::string_view role) { return state_.children[index_of_child(role)]; }

    const jde_schema table_;
    detail::BenchState state_;
    void *instance_ = nullptr;
};

/** A schema in C++ under test. */
template <typename S>
class Bench : public TableBench {
public:
    Bench() : TableBench(detail::Tables<S>::schema()) {}
    /** The instance, to examine its memory. */
    const S &schema() const noexcept { return static_cast<const detail::Instance<S> *>(instance())->schema; }
};

/** Ends a test with a message and the place if a condition does not hold. */
#define JDE_EXPECT(condition)                                                                       \
    do {                                                                                            \
        if (!(condition)) {                                                                         \
            throw std::runtime_error(std::string(__FILE__ ":") + std::to_string(__LINE__) + ": " #condition " does not hold"); \
        }                                                                                           \
    } while (false)

/** Runs tests, and prints each one that fails: `int main() { return jde::run({{"it stops", it_stops}}); }`. */
inline int run(std::initializer_list<std::pair<const char *, void (*)()>> tests)
{
    int failed = 0;
    for (const auto &[name, test] : tests) {
        try {
            test();
            std::printf("ok %s\n", name);
        } catch (const std::exception &failure) {
            std::printf("FAILED %s: %s\n", name, failure.what());
            failed++;
        }
    }
    return failed == 0 ? 0 : 1;
}

} // namespace jde

#endif
