// A father with two children: it wakes them, sets the target of one, and arbitrates between them.
#pragma once

#include <jde.hpp>

struct __Name__Ports : jde::Ports {
    jde::Import<jde::Odometry> pose{*this, "pose", "Pose of the robot."};
    jde::Modulation<jde::Pose2D> first{*this, "first", "The first place, in the frame of the odometry.", jde::Pose2D{1.5, 1.5, 0.0}};
    jde::Modulation<jde::Pose2D> second{*this, "second", "The second place, in the same frame.", jde::Pose2D{4.5, 1.5, 0.0}};
    jde::Modulation<double> tolerance{*this, "tolerance", "The robot has reached a place at this distance from it.", 0.3, jde::unit("m"), jde::min(0.0)};
    jde::Child brake{*this, "brake", "Stops in front of a close obstacle.", jde::group("base")};
    jde::Child cruise{*this, "cruise", "Drives to its target.", jde::group("base")};
    jde::Modulates<jde::Target> target{*this, cruise, "target", "The target of `cruise`."};
};

class __Name__ : public jde::Motor<__Name__Ports>, public jde::Arbitrate {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"__name__", "Drives back and forth between two places, by its children.", 100ms};
    }

    // One iteration; called every period while it is WINNER. Without a `check` it is always ready.
    void iterate(jde::Context &cx) override
    {
        brake.wake(cx);
        cruise.wake(cx);
        const auto at = pose.get(cx);
        if (at && jde::distance(jde::pose2d(*at), place(cx)) < tolerance.get(cx)) {
            cx.info("reached %.2f, %.2f", place(cx).x, place(cx).y);
            returning_ = !returning_;
        }
        target.set(cx, jde::target_at(place(cx)));
    }

    // Arbitrates when both children are ready, or none is. Without it, the first child that is ready wins.
    jde::Verdict arbitrate(jde::Context &, const jde::Level &level) override
    {
        if (level.is_ready(brake)) {
            return jde::Verdict::choose(brake, "an obstacle is too close");
        }
        return jde::Verdict::nobody("no child is ready");
    }

private:
    jde::Pose2D place(jde::Context &cx) const { return returning_ ? first.get(cx) : second.get(cx); }
    bool returning_ = false;
};
