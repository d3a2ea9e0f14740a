// A father with a value of its own, a choice and an inspection, and a driver: the same as `Porter` and `Bolt` of the tests in Rust.
#include <jde.hpp>

#include <limits>

using namespace std::chrono_literals;

struct Doors {
    jde::Seq<jde::Pose2D, 8> places;
    double narrowest;
    float widths[4];
    jde::Text<12> building;
    jde::Flag open;
    jde::Padding<3> padding;
    std::int16_t floor;
    jde::Padding<2> more_padding;
    std::uint64_t count;
};
JDE_VALUE(Doors, "my_msgs/msg/Doors", "Where the doors are.",
          JDE_MEMBER(places, "In the frame of the base."),
          JDE_MEMBER(narrowest, "Width of the narrowest.", "m"),
          JDE_MEMBER(widths, "Of the first four.", "m"),
          JDE_MEMBER(building, "The building."),
          JDE_MEMBER(open, "Whether all are open."),
          JDE_MEMBER(padding),
          JDE_MEMBER(floor, "The floor."),
          JDE_MEMBER(more_padding),
          JDE_MEMBER(count, "How many there are."));

enum class Gait : std::uint8_t { slow, very_fast };
JDE_CHOICE(Gait, "slow", "very-fast");

// A bundle: ports that several types of schema may have.
struct Manners {
    jde::Ports &schema;
    jde::Modulation<bool> polite{schema, "polite", "Whether it waits.", true, jde::was("waits")};
    jde::Modulation<std::int16_t> floor{schema, "floor", "The floor.", -1, jde::min(-3.0), jde::max(9.0), jde::fixed};
};

struct PorterPorts : jde::Ports {
    jde::Import<Doors> doors{*this, "doors", "Doors."};
    jde::Import<double> wind{*this, "wind", "Wind.", jde::optional, jde::unit("m/s")};
    jde::Modulation<Gait> gait{*this, "gait", "How to go.", Gait::very_fast};
    Manners manners{*this};
    jde::Export<Doors> passed{*this, "passed", "Doors that it passed."};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base.", jde::optional};
    jde::Child brake{*this, "brake", "Stops.", jde::group("base")};
    jde::Child cruise{*this, "cruise", "Drives.", jde::group("base"), jde::optional};
    jde::Child map{*this, "map", "Maps.", jde::perceptive};
    jde::Children others{*this, "others", "Any others.", jde::group("others")};
    jde::Modulates<bool> hurry{*this, cruise, "hurry", "Whether it hurries."};
};

class Porter : public jde::Motor<PorterPorts>, public jde::Arbitrate, public jde::Inspect {
public:
    static constexpr jde::About about() { return {"porter", "Passes doors.", 100ms, 10ms}; }

    void awake(jde::Context &cx) override { cx.require_real_time(); }

    jde::Precondition check(jde::Context &cx) override
    {
        return {doors.require(cx)->count > 0, manners.polite.get(cx) ? 2.0 : std::numeric_limits<double>::infinity()};
    }

    void iterate(jde::Context &cx) override
    {
        const auto seen = doors.require(cx);
        cx.warn("%s, %zu places in %s, %s", cx.name(), jde::elements(seen->places).size(), std::string(jde::text(seen->building)).c_str(),
                gait.get(cx) == Gait::slow ? "slow" : "very fast");
        auto loan = passed.loan(cx);
        *loan = *seen;
        jde::push(loan->places, jde::Pose2D{1.0, 2.0, 0.0});
        jde::assign(loan->building, "annex");
        loan->open = true;
        std::move(loan).publish_at(5ns);
        base.command(cx, jde::planar((wind.is_bound(cx) ? 0.1 : 0.2) * manners.floor.get(cx), 0.0));
        brake.wake(cx);
        cruise.wake(cx);
        others.wake(cx);
        map.wake(cx);
        hurry.set(cx, cruise.state(cx) == jde::State::winner);
        cruise.set_policy(cx, jde::Policy::sticky(1s, 0.5));
        if (brake.status(cx).faulted) {
            map.sleep(cx);
        }
    }

    jde::Verdict arbitrate(jde::Context &, const jde::Level &level) override
    {
        if (level.is_collision() && level.is_ready(brake)) {
            return jde::Verdict::choose(brake, "on overlap the brake wins");
        }
        return jde::Verdict::nobody(std::string(126, '.') + "\u00e9");
    }

    void inspect(jde::Context &cx, jde::Problems &problems) override
    {
        if (gait.get(cx) == Gait::very_fast) {
            problems.wrong(cx, gait, "it may not run");
        }
        problems.unavailable(cx, manners.polite, "nobody is there");
    }
};

struct BoltPorts : jde::Ports {
    jde::Command<double> place{*this, "place", "Where it is to be.", 0.0, 500ms, jde::trigger, jde::unit("m")};
};

class Bolt : public jde::Driver<BoltPorts> {
public:
    static constexpr jde::About about() { return {"bolt", "Locks a door.", 1s}; }

    void iterate(jde::Context &) override {}
};

JDE_EXPORT_PLUGIN("porter", "0.1.0", "Passes doors.", Porter, Bolt);
