// Fits a line to what the laser sees on the left with Eigen, and drives along it at a distance.
#pragma once

#include <jde.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>

/** A wall beside the robot. */
struct Wall {
    double distance;
    double heading;
};
JDE_VALUE(Wall, "example_msgs/msg/Wall", "A wall beside the robot.",
          JDE_MEMBER(distance, "From the laser to the wall.", "m"),
          JDE_MEMBER(heading, "Direction of the wall, positive if it turns to the left.", "rad"));

struct FinderPorts : jde::Ports {
    jde::Import<jde::LaserScan> laser{*this, "laser", "The scan. A new one triggers an iteration.", jde::trigger};
    jde::Modulation<double> reach{*this, "reach", "Farther points are ignored.", 2.5, jde::unit("m"), jde::min(0.1)};
    jde::Export<Wall> wall{*this, "wall", "The wall on the left. It has no value while there is none."};
};

class Finder : public jde::Perceptive<FinderPorts> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"finder", "Finds the wall on the left.", 100ms};
    }

    void iterate(jde::Context &cx) override
    {
        const auto scan = laser.get(cx);
        if (!scan) {
            return;
        }
        points_.clear();
        for (const auto &point : jde::points(*scan)) {
            if (point.angle > 0.5 && point.range <= reach.get(cx)) {
                points_.emplace_back(point.x, point.y);
            }
        }
        if (points_.size() < 10) {
            wall.retract(cx);
            return;
        }
        // The wall lies along the eigenvector of the larger eigenvalue of the points' covariance.
        const Eigen::Map<const Eigen::Matrix2Xd> points(points_.front().data(), 2, static_cast<Eigen::Index>(points_.size()));
        const Eigen::Vector2d mean = points.rowwise().mean();
        const Eigen::Matrix2Xd centered = points.colwise() - mean;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(centered * centered.transpose());
        Eigen::Vector2d along = solver.eigenvectors().col(1);
        along *= along.x() < 0.0 ? -1.0 : 1.0;
        const double distance = std::fabs(mean.dot(solver.eigenvectors().col(0)));
        wall.write_at(cx, {distance, std::atan2(along.y(), along.x())}, scan.time());
    }

private:
    // The buffer is used again.
    std::vector<Eigen::Vector2d> points_;
};

struct FollowPorts : jde::Ports {
    jde::Import<Wall> wall{*this, "wall", "The wall on the left.", jde::trigger};
    jde::Modulation<double> distance{*this, "distance", "Distance to keep.", 1.0, jde::unit("m"), jde::min(0.4)};
    jde::Modulation<double> speed{*this, "speed", "Speed ahead.", 0.25, jde::unit("m/s"), jde::min(0.0)};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base."};
};

class Follow : public jde::Motor<FollowPorts> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"follow", "Drives along the wall on the left.", 100ms};
    }

    jde::Precondition check(jde::Context &cx) override { return bool(wall.get(cx)); }

    void iterate(jde::Context &cx) override
    {
        const auto at = wall.require(cx);
        const double turn = at->heading + 0.8 * (at->distance - distance.get(cx));
        base.command(cx, jde::planar(speed.get(cx), std::clamp(turn, -0.6, 0.6)));
    }
};
