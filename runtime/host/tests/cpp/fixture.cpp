// The schemas of the tests in C++: each call runs the scenario's behaviour in the test, whose requests go through the ports
// here. What a behaviour reports as an error or a panic is thrown here as an exception.
#include "../c/fixture.h"

#include <jde.hpp>

#include <exception>
#include <stdexcept>

using namespace std::chrono_literals;

/** A value of a type of the tests' own, as in common/schemas.rs. */
struct Mark {
    jde::Seq<jde::Pose2D, 4> places;
    jde::Text<12> label;
};
JDE_VALUE(Mark, "test_msgs/msg/Mark", "A value of a type of the tests' own.", JDE_MEMBER(places, "Where it is."),
          JDE_MEMBER(label, "What it is."));

namespace {

functions test;

/** What every instance remembers. */
struct Memory {
    std::uint32_t scenario = 0;
    std::string name;
    std::uint64_t calls = 0;

    Memory() { test.alive(1); }
    ~Memory() noexcept(false)
    {
        test.alive(-1);
        if (scenario != 0) {
            call call = {};
            call.kind = CALL_DROP;
            run(call);
        }
    }
    void run(call &call) const
    {
        call.scenario = scenario;
        call.name = name.c_str();
        call.memory = calls;
        switch (test.run(&call)) {
        case JDE_OK: return;
        case JDE_NO_VALUE: throw jde::NoValue(call.text);
        case JDE_FAILED: throw jde::Failure(call.text);
        default: throw std::logic_error(call.text);
        }
    }
};

/** What a call lends. */
struct Lent {
    const jde::Level *level = nullptr;
    jde::Pen *pen = nullptr;
    jde::Saving *saving = nullptr;
    jde::Saved *saved = nullptr;
};

/** Runs a call of a schema, whose `request` performs what the behaviour requests. */
template <typename S>
call run(S &schema, jde::Context &cx, call_kind kind, const Lent &lent = {}, call call = {})
{
    struct Caller {
        S &schema;
        jde::Context &cx;
        const Lent &lent;
        std::exception_ptr thrown;
    } caller = {schema, cx, lent, nullptr};
    Memory &memory = schema.memory;
    memory.scenario = schema.scenario.get(cx);
    memory.name = cx.name();
    call.kind = kind;
    call.group = lent.level != nullptr ? lent.level->group() : nullptr;
    call.caller = &caller;
    call.request = [](void *self, std::uint32_t request, const char *text, double number, answer *answer) {
        auto &of = *static_cast<Caller *>(self);
        // No exception crosses the functions of another language.
        try {
            *answer = of.schema.request(of.cx, of.lent, static_cast<request_kind>(request), text, number);
            return 1;
        } catch (...) {
            of.thrown = std::current_exception();
            return 0;
        }
    };
    // The memory of this call is the number of earlier ones.
    struct Count {
        std::uint64_t &calls;
        ~Count() { calls++; }
    } count{memory.calls};
    try {
        memory.run(call);
    } catch (...) {
        if (caller.thrown) {
            std::rethrow_exception(caller.thrown);
        }
        throw;
    }
    return call;
}

answer of(jde::Outcome outcome)
{
    static constexpr std::int32_t codes[] = {JDE_OK, JDE_REFUSED, JDE_NOT_FINITE, JDE_OUT_OF_RANGE, JDE_UNBOUND};
    return {codes[static_cast<std::size_t>(outcome)], 0.0, 0};
}
answer of(bool holds) { return of(holds ? jde::Outcome::accepted : jde::Outcome::refused); }
answer of(double number) { return {JDE_OK, number, 0}; }
answer of(const jde::Sample<double> &sample) { return sample ? answer{JDE_OK, *sample, sample.sequence()} : of(false); }
answer of(const jde::Sample<Mark> &mark, std::string_view label)
{
    if (!mark || jde::text(mark->label) != label) {
        return of(false);
    }
    const auto places = jde::elements(mark->places);
    return {JDE_OK, places[places.size() - 1].x, places.size()};
}

/** The requests that every schema answers. */
answer common(jde::Context &cx, request_kind request, const char *text)
{
    switch (request) {
    case GET_SEED: return {JDE_OK, 0.0, cx.seed()};
    case GET_NOW: return {JDE_OK, 0.0, static_cast<std::uint64_t>(cx.now().count())};
    case LOG: return cx.info("%s", text), of(true);
    case IS_REAL_TIME:
        try {
            return cx.require_real_time(), of(true);
        } catch (const jde::Failure &) {
            return of(false);
        }
    default: throw std::logic_error("this schema cannot do that");
    }
}

struct TestPorts : jde::Ports {
    jde::Modulation<std::uint32_t> scenario{*this, "scenario", "The number of the scenario.", 0, jde::fixed};
};

struct MotorPorts : TestPorts {
    jde::Import<double> input{*this, "input", "An input.", jde::optional};
    jde::Import<double> other{*this, "other", "Another input.", jde::optional};
    jde::Import<Mark> mark{*this, "mark", "A value of a type of the tests' own.", jde::optional};
    jde::Modulation<double> gain{*this, "gain", "A modulation for a father or an operator.", 0.0};
    jde::Modulation<double> grip{*this, "grip", "A modulation that is read at the awakening.", 0.0, jde::fixed};
    jde::Actuator<jde::Twist> base{*this, "base", "A command with a long validity.", jde::optional};
    jde::Actuator<jde::Twist> arm{*this, "arm", "A command with a short validity.", jde::optional};
    jde::Export<jde::Mission> mission{*this, "mission", "The progress of the mission."};
    jde::Child a{*this, "a", "A child.", jde::group("base"), jde::optional};
    jde::Child b{*this, "b", "Another child.", jde::group("base"), jde::optional};
    jde::Child c{*this, "c", "A third child.", jde::group("base"), jde::optional};
    jde::Child helper{*this, "helper", "A perceptive child.", jde::perceptive, jde::optional};
    jde::Modulates<double> gain_of_a{*this, a, "gain", "The modulation of child a.", jde::optional};
    jde::Modulates<double> period_of_a{*this, a, "period", "The period of child a.", jde::optional};
};

class Motor : public jde::Motor<MotorPorts>, public jde::Arbitrate {
public:
    static constexpr jde::About about() { return {"motor", "A motor schema.", 10ms}; }
    Memory memory;

    void awake(jde::Context &cx) override { run(*this, cx, CALL_AWAKE); }
    jde::Precondition check(jde::Context &cx) override
    {
        const call call = run(*this, cx, CALL_CHECK);
        return {call.ready != 0, call.urgency};
    }
    void iterate(jde::Context &cx) override
    {
        run(*this, cx, CALL_ITERATE);
        // A gain of 100 or more sets the mission's state.
        if (gain.get(cx) >= 100.0) {
            jde::Mission report = {};
            report.state = static_cast<std::uint8_t>(gain.get(cx) - 100.0);
            mission.write(cx, report);
        }
    }
    void sleep(jde::Context &cx) override { run(*this, cx, CALL_SLEEP); }
    jde::Verdict arbitrate(jde::Context &cx, const jde::Level &level) override
    {
        Lent lent;
        lent.level = &level;
        const call call = run(*this, cx, CALL_ARBITRATE, lent);
        if (call.role[0] == '\0') {
            return jde::Verdict::nobody("the scenario chose no child");
        }
        return jde::Verdict::choose(child(call.role), memory.name + " chose " + call.role);
    }

    answer request(jde::Context &cx, const Lent &lent, request_kind request, const char *text, double number)
    {
        switch (request) {
        case GET_INPUT: return of(input.get(cx));
        case GET_OTHER: return of(other.get(cx));
        case GET_MARK: return of(mark.get(cx), text);
        case GET_GAIN: return of(gain.get(cx));
        case GET_GRIP: return of(grip.get(cx));
        case COMMAND: return of(base.command(cx, jde::planar(number, 0.0)));
        case REACH: return of(arm.command(cx, jde::planar(number, 0.0)));
        case WAKE: return of(child(text).wake(cx));
        case SLEEP: return of(child(text).sleep(cx));
        case MODULATE_A: return of(gain_of_a.set(cx, number));
        case RETIME_A: return of(period_of_a.set(cx, number));
        case SET_POLICY: return of(child(text).set_policy(cx, jde::Policy::urgency()));
        case GET_STATE: {
            const jde::Status status = child(text).status(cx);
            return {JDE_OK, status.faulted ? 1.0 : 0.0, static_cast<std::uint64_t>(status.state)};
        }
        case IS_READY: return of(lent.level->is_ready(child(text)));
        case COLLIDES: return of(lent.level->is_collision());
        case GET_URGENCY:
            for (std::size_t index = 0; index < lent.level->size(); index++) {
                if ((*lent.level)[index].child == child(text).number()) {
                    return of((*lent.level)[index].urgency);
                }
            }
            return of(false);
        case DRAW_TEXT: return lent.pen->text(text), of(true);
        case DRAW_VALUE: return lent.pen->value(text, number, "m"), of(true);
        case DRAW_BUTTON: return lent.pen->button(text, text), of(true);
        case SAVE: return lent.saving->put(number), of(true);
        case RESTORE: return of(lent.saved->take<double>());
        default: return common(cx, request, text);
        }
    }

private:
    const jde::Child &child(std::string_view role) const
    {
        for (const jde::Child *child : {&a, &b, &c, &helper}) {
            if (role == child->name()) {
                return *child;
            }
        }
        throw std::invalid_argument("there is no such role");
    }
};

class AbleMotor : public Motor, public jde::Panel, public jde::Memory {
public:
    static constexpr jde::About about() { return {"able-motor", "A motor schema with a panel and a memory.", 10ms}; }

    // A behaviour may try to write in calls that change nothing.
    void draw(jde::Context &cx, jde::Pen &pen) const override
    {
        Lent lent;
        lent.pen = &pen;
        run(const_cast<AbleMotor &>(*this), cx, CALL_DRAW, lent);
    }
    void touched(jde::Context &cx, const jde::Gesture &gesture) override
    {
        char words[256];
        write_gesture(words, sizeof words, &gesture.raw(), cx.name());
        call call = {};
        call.gesture = words;
        run(*this, cx, CALL_TOUCH, {}, call);
    }
    void save(jde::Context &cx, jde::Saving &saving) const override
    {
        Lent lent;
        lent.saving = &saving;
        run(const_cast<AbleMotor &>(*this), cx, CALL_SAVE, lent);
    }
    void restore(jde::Context &cx, jde::Saved &saved) override
    {
        Lent lent;
        lent.saved = &saved;
        run(*this, cx, CALL_RESTORE, lent);
    }
};

struct EyePorts : TestPorts {
    jde::Modulation<double> gain{*this, "gain", "A modulation for an operator.", 0.0};
    jde::Import<double> input{*this, "input", "An input.", jde::optional};
    jde::Export<double> out{*this, "out", "The value that the test publishes."};
    jde::Export<Mark> mark{*this, "mark", "A value of a type of the tests' own."};
};

class Eye : public jde::Perceptive<EyePorts>, public jde::Guard {
public:
    static constexpr jde::About about() { return {"eye", "A perceptive schema.", 10ms}; }
    Memory memory;

    void awake(jde::Context &cx) override { run(*this, cx, CALL_AWAKE); }
    void iterate(jde::Context &cx) override { run(*this, cx, CALL_ITERATE); }
    void sleep(jde::Context &cx) override { run(*this, cx, CALL_SLEEP); }

    answer request(jde::Context &cx, const Lent &, request_kind request, const char *text, double number)
    {
        switch (request) {
        case PUBLISH: return out.write(cx, number), of(true);
        case RETRACT: return out.retract(cx), of(true);
        case PUBLISH_MARK: {
            Mark value = {};
            jde::push(value.places, jde::Pose2D{number, 0.0, 0.0});
            jde::assign(value.label, text);
            return mark.write(cx, value), of(true);
        }
        default: return common(cx, request, text);
        }
    }

    /* Accepts commands up to its value, in m/s. */
    static constexpr auto state() { return &EyePorts::out; }
    static jde::Judgement judge(const double &limit, jde::Nanoseconds, const jde::Twist &command)
    {
        if (limit != limit) {
            throw std::domain_error("a limit is a number");
        }
        if (command.linear.x <= limit) {
            return jde::accept();
        }
        return jde::refuse("%g m/s, and at most %g m/s are safe", command.linear.x, limit);
    }
    /* Limits commands to its value if it is between 0.3 and 0.4. */
    static std::optional<jde::Twist> limit(const double &limit, jde::Nanoseconds, const jde::Twist &)
    {
        jde::Twist lesser{};
        lesser.linear.x = limit;
        return limit > 0.3 && limit < 0.4 ? std::optional<jde::Twist>(lesser) : std::nullopt;
    }
};

struct RobotPorts : TestPorts {
    jde::Command<jde::Twist> velocity{*this, "velocity", "A command that is in force for long.", jde::Twist{}, 1000s};
    jde::Command<jde::Twist> reach{*this, "reach", "A command that must be repeated.", jde::Twist{}, 50ms};
};

class Robot : public jde::Driver<RobotPorts> {
public:
    static constexpr jde::About about() { return {"robot", "A driver. It records each change of its commands.", 10ms}; }
    Memory memory;

    void awake(jde::Context &cx) override { run(*this, cx, CALL_AWAKE); }
    void iterate(jde::Context &cx) override
    {
        call call = {};
        std::memcpy(call.commands[0], last_, sizeof last_);
        last_[0] = speed(velocity.get(cx)), last_[1] = speed(reach.get(cx));
        std::memcpy(call.commands[1], last_, sizeof last_);
        run(*this, cx, CALL_ITERATE, {}, call);
        if (speed(velocity.get(cx)) != last_[0] || speed(reach.get(cx)) != last_[1]) {
            throw std::logic_error("it read another command in the same iteration");
        }
    }
    void sleep(jde::Context &cx) override { run(*this, cx, CALL_SLEEP); }

    answer request(jde::Context &cx, const Lent &, request_kind request, const char *text, double) { return common(cx, request, text); }

private:
    static double speed(const jde::Sample<jde::Twist> &command) { return command.in_force() ? command->linear.x : 0.0; }
    double last_[2] = {0.0, 0.0};
};

class FailsToCreate : public jde::Motor<TestPorts> {
public:
    static constexpr jde::About about() { return {"fails-to-create", "A schema that cannot be created.", 10ms}; }
    FailsToCreate() { throw std::logic_error("there is no such device"); }
    void iterate(jde::Context &) override {}
};

} // namespace

/** Connects the schemas with the test. */
extern "C" JDE_VISIBLE void fixture_connect(struct functions functions) { test = functions; }

JDE_EXPORT_PLUGIN("test", "0.1.0", "Schemas of the tests.", Motor, AbleMotor, Eye, Robot, FailsToCreate);
