// Drives up to the obstacle ahead and stops in front of it.
#pragma once

#include <jde.hpp>

#include <algorithm>

struct CreepCppPorts : jde::Ports {
    jde::Import<jde::LaserScan> laser{*this, "laser", "The scan of the laser. A new scan triggers a check.", jde::trigger};
    jde::Modulation<double> distance{*this, "distance", "Distance to the obstacle at which the robot stops.", 0.5, jde::unit("m"), jde::min(0.0)};
    jde::Modulation<double> speed{*this, "speed", "Speed far from all obstacles.", 0.4, jde::unit("m/s"), jde::min(0.0)};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base."};
};

class CreepCpp : public jde::Motor<CreepCppPorts>, public jde::Panel {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"creep-cpp", "Drives straight ahead, slows down near an obstacle, and stops at a distance from it.", 100ms};
    }

    // The precondition: it can act while there is a scan.
    jde::Precondition check(jde::Context &cx) override { return bool(laser.get(cx)); }

    // One iteration; called every period while it is WINNER.
    void iterate(jde::Context &cx) override
    {
        const auto nearest = jde::nearest_ahead(*laser.require(cx), half_width);
        // One metre is enough to slow down from full speed.
        const double room = nearest ? std::clamp(*nearest - distance.get(cx), 0.0, 1.0) : 1.0;
        base.command(cx, jde::planar(speed.get(cx) * room, 0.0));
    }

    // Its panel, which is drawn while a window or `jde panel` shows it.
    void draw(jde::Context &cx, jde::Pen &pen) const override
    {
        const double at = distance.get(cx);
        pen.value("distance", at, "m");
        auto ahead = pen.canvas("ahead", jde::Wants::forward_up);
        if (const auto scan = laser.get(cx)) {
            ahead.points(jde::points(*scan), jde::Ink::seen);
        }
        ahead.line({{at, -half_width}, {at, half_width}}, jde::Ink::goal);
        ahead.robot();
    }

private:
    // Half the width of the area that must be free: that of the robot and a margin, m.
    static constexpr double half_width = 0.35;
};
