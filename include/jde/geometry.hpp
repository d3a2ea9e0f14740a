/*
 * Helpers for the standard types: poses and speeds in the plane, and range sensors.
 */
#ifndef JDE_GEOMETRY_HPP
#define JDE_GEOMETRY_HPP

#include "types.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace jde {

inline constexpr double pi = 3.14159265358979323846;

/** A speed ahead, m/s, and a speed of turning to the left, rad/s. */
constexpr Twist planar(double ahead, double turn) noexcept { return {{ahead, 0.0, 0.0}, {0.0, 0.0, turn}}; }

/** Returns the same angle in (-pi, pi]. */
inline double normalize_angle(double angle) noexcept
{
    const double turned = std::remainder(angle, 2.0 * pi);
    return turned <= -pi ? pi : turned;
}

/** Distance between two positions, m. */
inline double distance(const Pose2D &from, const Pose2D &to) noexcept { return std::hypot(to.x - from.x, to.y - from.y); }

/** Angle from the heading of one pose to the position of another, rad, to the left. */
inline double bearing(const Pose2D &from, const Pose2D &to) noexcept
{
    return normalize_angle(std::atan2(to.y - from.y, to.x - from.x) - from.theta);
}

/** The heading of an orientation, rad, whatever its length; NaN if it has none. */
inline double yaw(const Quaternion &q) noexcept
{
    const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return square > 0.0 ? std::atan2(2.0 * (q.w * q.z + q.x * q.y), square - 2.0 * (q.y * q.y + q.z * q.z)) : std::nan("");
}

/** The orientation of a heading. */
inline Quaternion from_yaw(double yaw) noexcept { return {0.0, 0.0, std::sin(yaw / 2.0), std::cos(yaw / 2.0)}; }

/** The pose of an odometry in the plane. */
inline Pose2D pose2d(const Odometry &odometry) noexcept
{
    const Pose &pose = odometry.pose.pose;
    return {pose.position.x, pose.position.y, yaw(pose.orientation)};
}

/** The target at a position, with any heading. */
constexpr Target target_at(const Pose2D &pose) noexcept { return {pose, 1, 0, {}}; }

/** The target at a position with this heading. */
constexpr Target target_facing(const Pose2D &pose) noexcept { return {pose, 1, 1, {}}; }

/** The hit of a laser beam, in the frame of the scanner. */
struct LaserPoint {
    /** The index of the beam in the scan. */
    std::size_t beam;
    /** Its angle, rad. */
    double angle;
    /** The distance, m. */
    double range;
    /** Ahead, m. */
    double x;
    /** To the left, m. */
    double y;
};

/**
 * Calls `use` with each hit of a scan, first beam first. Beams without a hit or a measurement are left out: REP-117, and a range of
 * `range_max`, which is free. An object too close to measure counts as at `range_min`.
 */
template <typename Use>
void for_each_point(const LaserScan &scan, Use use)
{
    const auto ranges = elements(scan.ranges);
    for (std::size_t beam = 0; beam < ranges.size(); beam++) {
        const bool close = std::isinf(ranges[beam]) && ranges[beam] < 0.0f;
        // At distance 0 an object would be in no direction.
        const float range = close ? std::fmax(scan.range_min, 1e-6f) : ranges[beam];
        if (range > 0.0f && range >= scan.range_min && range < scan.range_max) {
            const double angle = static_cast<double>(scan.angle_min) + static_cast<double>(beam) * static_cast<double>(scan.angle_increment);
            const double length = static_cast<double>(range);
            use(LaserPoint{beam, angle, length, length * std::cos(angle), length * std::sin(angle)});
        }
    }
}

/** The same as a list. */
inline std::vector<LaserPoint> points(const LaserScan &scan)
{
    std::vector<LaserPoint> points;
    points.reserve(elements(scan.ranges).size());
    for_each_point(scan, [&](const LaserPoint &point) { points.push_back(point); });
    return points;
}

/** How far ahead the nearest hit within `half_width` to either side is, m; nothing if there is none. */
inline std::optional<double> nearest_ahead(const LaserScan &scan, double half_width)
{
    std::optional<double> nearest;
    for_each_point(scan, [&](const LaserPoint &point) {
        if (point.x > 0.0 && std::fabs(point.y) <= half_width && (!nearest || point.x < *nearest)) {
            nearest = point.x;
        }
    });
    return nearest;
}

} // namespace jde

#endif
