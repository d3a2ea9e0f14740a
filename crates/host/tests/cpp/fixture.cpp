// The schemas of the tests in C++: each call runs the scenario's behaviour in the test, whose requests go through the ports
// here. What a behaviour reports as an error or a panic is thrown here as an exception.
#include <jde.hpp>

#include <exception>
#include <stdexcept>

using namespace std::chrono_literals;

namespace {

/** As in common/io.rs, in that order. */
enum class What : std::uint32_t { awake, check, iterate, sleep, arbitrate, drop };
enum class Request : std::uint32_t {
    input, other, gain, grip, command, reach, wake, sleep, modulate_a, retime_a, publish, retract, seed, now, real_time, is_ready, collides
};

/** As in common/foreign.rs. */
struct Answer {
    std::uint32_t outcome;
    double number;
    std::uint64_t count;
};
struct Call {
    std::uint32_t scenario;
    What what;
    const char *name;
    const char *group;
    std::uint64_t memory;
    double commands[2][2];
    void *caller;
    bool (*request)(void *caller, Request, const char *role, double, Answer *);
    std::uint32_t ready;
    double urgency;
    char role[16];
    char text[512];
};
struct Test {
    /** Returns 0, 1 for an error and 2 for a panic. */
    std::int32_t (*run)(Call *);
    /** Counts instances. */
    void (*alive)(std::int32_t);
};
Test test;

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
            Call call = {};
            call.what = What::drop;
            run(call);
        }
    }
    void run(Call &call) const
    {
        call.scenario = scenario;
        call.name = name.c_str();
        call.memory = calls;
        switch (test.run(&call)) {
        case 0: return;
        case 1: throw jde::Failure(call.text);
        default: throw std::logic_error(call.text);
        }
    }
};

/** Runs a call of a schema, whose `request` performs what the behaviour requests. */
template <typename S>
Call run(S &schema, jde::Context &cx, What what, const jde::Level *level = nullptr, const double (*commands)[2] = nullptr)
{
    struct Caller {
        S &schema;
        jde::Context &cx;
        const jde::Level *level;
        std::exception_ptr thrown;
    } caller = {schema, cx, level, nullptr};
    Memory &memory = schema.memory;
    memory.scenario = schema.scenario.get(cx);
    memory.name = cx.name();
    Call call = {};
    call.what = what;
    call.group = level != nullptr ? level->group() : "";
    if (commands != nullptr) {
        std::memcpy(call.commands, commands, sizeof call.commands);
    }
    call.caller = &caller;
    call.request = [](void *self, Request request, const char *role, double number, Answer *answer) {
        auto &of = *static_cast<Caller *>(self);
        // No exception crosses the functions of another language.
        try {
            *answer = of.schema.request(of.cx, of.level, request, role, number);
            return true;
        } catch (...) {
            of.thrown = std::current_exception();
            return false;
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

Answer of(jde::Outcome outcome) { return {static_cast<std::uint32_t>(outcome), 0.0, 0}; }
Answer of(bool holds) { return of(holds ? jde::Outcome::accepted : jde::Outcome::refused); }
Answer of(double number) { return {0, number, 0}; }
Answer of(const jde::Sample<double> &sample) { return sample ? Answer{0, *sample, sample.sequence()} : of(false); }

/** The requests that every schema answers. */
Answer common(jde::Context &cx, Request request)
{
    switch (request) {
    case Request::seed: return {0, 0.0, cx.seed()};
    case Request::now: return {0, 0.0, static_cast<std::uint64_t>(cx.now().count())};
    case Request::real_time:
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

    void awake(jde::Context &cx) override { run(*this, cx, What::awake); }
    jde::Precondition check(jde::Context &cx) override
    {
        const Call call = run(*this, cx, What::check);
        return {call.ready != 0, call.urgency};
    }
    void iterate(jde::Context &cx) override
    {
        run(*this, cx, What::iterate);
        // A gain of 100 or more sets the mission's state.
        if (gain.get(cx) >= 100.0) {
            jde::Mission report = {};
            report.state = static_cast<std::uint8_t>(gain.get(cx) - 100.0);
            mission.write(cx, report);
        }
    }
    void sleep(jde::Context &cx) override { run(*this, cx, What::sleep); }
    jde::Verdict arbitrate(jde::Context &cx, const jde::Level &level) override
    {
        const Call call = run(*this, cx, What::arbitrate, &level);
        if (call.role[0] == '\0') {
            return jde::Verdict::nobody("the scenario chose no child");
        }
        return jde::Verdict::choose(child(call.role), memory.name + " chose " + call.role);
    }

    Answer request(jde::Context &cx, const jde::Level *level, Request request, const char *role, double number)
    {
        switch (request) {
        case Request::input: return of(input.get(cx));
        case Request::other: return of(other.get(cx));
        case Request::gain: return of(gain.get(cx));
        case Request::grip: return of(grip.get(cx));
        case Request::command: return of(base.command(cx, jde::planar(number, 0.0)));
        case Request::reach: return of(arm.command(cx, jde::planar(number, 0.0)));
        case Request::wake: return of(child(role).wake(cx));
        case Request::sleep: return of(child(role).sleep(cx));
        case Request::modulate_a: return of(gain_of_a.set(cx, number));
        case Request::retime_a: return of(period_of_a.set(cx, number));
        case Request::is_ready: return of(level->is_ready(child(role)));
        case Request::collides: return of(level->is_collision());
        default: return common(cx, request);
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

struct EyePorts : TestPorts {
    jde::Modulation<double> gain{*this, "gain", "A modulation for an operator.", 0.0};
    jde::Import<double> input{*this, "input", "An input.", jde::optional};
    jde::Export<double> out{*this, "out", "The value that the test publishes."};
};

class Eye : public jde::Perceptive<EyePorts>, public jde::Guard {
public:
    static constexpr jde::About about() { return {"eye", "A perceptive schema.", 10ms}; }
    Memory memory;

    void awake(jde::Context &cx) override { run(*this, cx, What::awake); }
    void iterate(jde::Context &cx) override { run(*this, cx, What::iterate); }
    void sleep(jde::Context &cx) override { run(*this, cx, What::sleep); }

    Answer request(jde::Context &cx, const jde::Level *, Request request, const char *, double number)
    {
        switch (request) {
        case Request::publish: return out.write(cx, number), of(true);
        case Request::retract: return out.retract(cx), of(true);
        default: return common(cx, request);
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
};

struct RobotPorts : TestPorts {
    jde::Command<jde::Twist> velocity{*this, "velocity", "A command that is in force for long.", jde::Twist{}, 1000s};
    jde::Command<jde::Twist> reach{*this, "reach", "A command that must be repeated.", jde::Twist{}, 50ms};
};

class Robot : public jde::Driver<RobotPorts> {
public:
    static constexpr jde::About about() { return {"robot", "A driver. It records each change of its commands.", 10ms}; }
    Memory memory;

    void awake(jde::Context &cx) override { run(*this, cx, What::awake); }
    void iterate(jde::Context &cx) override
    {
        const double commands[2][2] = {{last_[0], last_[1]}, {speed(velocity.get(cx)), speed(reach.get(cx))}};
        std::memcpy(last_, commands[1], sizeof last_);
        run(*this, cx, What::iterate, nullptr, commands);
        if (speed(velocity.get(cx)) != last_[0] || speed(reach.get(cx)) != last_[1]) {
            throw std::logic_error("it read another command in the same iteration");
        }
    }
    void sleep(jde::Context &cx) override { run(*this, cx, What::sleep); }

    Answer request(jde::Context &cx, const jde::Level *, Request request, const char *, double) { return common(cx, request); }

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
extern "C" JDE_VISIBLE void fixture_connect(Test functions) { test = functions; }

JDE_EXPORT_PLUGIN("test", "0.1.0", "Schemas of the tests.", Motor, Eye, Robot, FailsToCreate);
