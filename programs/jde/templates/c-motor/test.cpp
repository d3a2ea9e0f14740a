#include <jde/bench.hpp>

extern "C" const struct jde_plugin jde_plugin;

// A scan with one beam, straight ahead.
static jde::LaserScan scan(float range)
{
    jde::LaserScan scan = {};
    scan.range_max = 8.0f;
    jde::push(scan.ranges, range);
    return scan;
}

static double speed_at(float range)
{
    jde::TableBench bench(jde_plugin.schemas[0]);
    bench.import("laser", scan(range));
    JDE_EXPECT(bench.check().ready);
    bench.iterate();
    return bench.commanded<jde::Twist>("base").value().linear.x;
}

static void it_is_not_ready_without_a_scan()
{
    jde::TableBench bench(jde_plugin.schemas[0]);
    JDE_EXPECT(!bench.check().ready);
}

static void it_slows_down_near_an_obstacle_and_stops_at_a_distance()
{
    JDE_EXPECT(speed_at(5.0f) == 0.4);
    JDE_EXPECT(speed_at(1.0f) < 0.4);
    JDE_EXPECT(speed_at(0.5f) == 0.0);
    JDE_EXPECT(speed_at(0.2f) == 0.0);
}

int main()
{
    return jde::run({{"it is not ready without a scan", it_is_not_ready_without_a_scan},
                     {"it slows down near an obstacle and stops at a distance", it_slows_down_near_an_obstacle_and_stops_at_a_distance}});
}
