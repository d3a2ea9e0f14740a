#include "../src/schema.hpp"

#include <jde/bench.hpp>

// A scan with three beams: to the right, straight ahead and to the left.
static jde::LaserScan scan(float right, float ahead, float left)
{
    jde::LaserScan scan = {};
    scan.angle_min = static_cast<float>(-jde::pi / 2);
    scan.angle_increment = -scan.angle_min;
    scan.range_max = 8.0f;
    for (const float range : {right, ahead, left}) {
        jde::push(scan.ranges, range);
    }
    return scan;
}

static void it_finds_the_nearest_obstacle()
{
    jde::Bench<__Name__> bench;
    bench.import("laser", scan(3.0f, 2.0f, 1.0f));
    bench.iterate();
    const auto nearest = bench.exported<jde::Pose2D>("nearest");
    JDE_EXPECT(nearest && jde::distance(*nearest, {0.0, 1.0, 0.0}) < 1e-3);
}

static void it_retracts_its_export_when_there_is_no_obstacle()
{
    jde::Bench<__Name__> bench;
    for (const float range : {4.0f, 6.0f}) {
        bench.import("laser", scan(range, range, range));
        bench.iterate();
        JDE_EXPECT(bench.exported<jde::Pose2D>("nearest").has_value() == (range < 5.0f));
    }
}

static void the_robot_turns_to_the_nearest_obstacle()
{
    jde::Bench<Face> bench;
    JDE_EXPECT(!bench.check().ready);
    bench.import("nearest", jde::Pose2D{0.0, 1.0, 0.0});
    JDE_EXPECT(bench.check().ready);
    bench.iterate();
    JDE_EXPECT(bench.commanded<jde::Twist>("base").value().angular.z == 0.5);
}

int main()
{
    return jde::run({{"it finds the nearest obstacle", it_finds_the_nearest_obstacle},
                     {"it retracts its export when there is no obstacle", it_retracts_its_export_when_there_is_no_obstacle},
                     {"the robot turns to the nearest obstacle", the_robot_turns_to_the_nearest_obstacle}});
}
