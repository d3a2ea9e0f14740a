// Brakes while an obstacle is in a very close area ahead.
#include <jde.hpp>

using namespace std::chrono_literals;

struct StopPorts : jde::Ports {
    jde::Import<jde::LaserScan> laser{*this, "laser", "The scan of the laser.", jde::trigger};
    jde::Modulation<double> half_width{*this, "half_width", "Half the width of the watched area.", 0.3, jde::unit("m"), jde::min(0.0)};
    jde::Modulation<double> ahead{*this, "ahead", "How far ahead of the laser the watched area reaches.", 0.6, jde::unit("m"), jde::min(0.0)};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base."};
};

class Stop : public jde::Motor<StopPorts> {
public:
    static constexpr jde::About about()
    {
        return {"stop", "Brakes the base while an obstacle is in a very close area ahead.", 200ms, 20ms};
    }

    jde::Precondition check(jde::Context &cx) override
    {
        const auto scan = laser.get(cx);
        const auto nearest = scan ? jde::nearest_ahead(*scan, half_width.get(cx)) : std::nullopt;
        return nearest && *nearest <= ahead.get(cx);
    }

    void iterate(jde::Context &cx) override { base.command(cx, {}); }
};

JDE_EXPORT_PLUGIN("stop", "0.1.0", "Brakes before obstacles.", Stop);
