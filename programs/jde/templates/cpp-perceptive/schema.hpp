// A perceptive schema that finds the nearest obstacle, and a motor schema that turns to it.
#pragma once

#include <jde.hpp>

#include <algorithm>

struct __Name__Ports : jde::Ports {
    jde::Import<jde::LaserScan> laser{*this, "laser", "The scan of the laser. A new scan triggers an iteration.", jde::trigger};
    jde::Modulation<double> farthest{*this, "farthest", "Obstacles at a greater distance are ignored.", 5.0, jde::unit("m"), jde::min(0.0)};
    jde::Export<jde::Pose2D> nearest{*this, "nearest", "Position of the nearest obstacle in the frame of the laser. It has no value while there is none."};
};

class __Name__ : public jde::Perceptive<__Name__Ports> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"__name__", "Finds the nearest obstacle in a laser scan.", 100ms};
    }

    // One iteration; called every period while an awake schema imports its export.
    void iterate(jde::Context &cx) override
    {
        const auto scan = laser.get(cx);
        if (!scan) {
            return;
        }
        const auto points = jde::points(*scan);
        const auto is_nearer = [](const auto &one, const auto &other) { return one.range < other.range; };
        const auto point = std::min_element(points.begin(), points.end(), is_nearer);
        if (point != points.end() && point->range <= farthest.get(cx)) {
            // The export is as old as the scan that it results from.
            nearest.write_at(cx, {point->x, point->y, 0.0}, scan.time());
        } else {
            nearest.retract(cx);
        }
    }
};

struct FacePorts : jde::Ports {
    jde::Import<jde::Pose2D> nearest{*this, "nearest", "Position of the nearest obstacle.", jde::trigger};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base."};
};

class Face : public jde::Motor<FacePorts> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"face", "Turns to the nearest obstacle, which the other schema finds.", 100ms};
    }

    jde::Precondition check(jde::Context &cx) override { return bool(nearest.get(cx)); }

    void iterate(jde::Context &cx) override
    {
        const double bearing = jde::bearing({}, *nearest.require(cx));
        base.command(cx, jde::planar(0.0, std::clamp(bearing, -0.5, 0.5)));
    }
};
