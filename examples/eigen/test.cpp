#include "wall.hpp"

#include <jde/bench.hpp>

// A scan of a wall on the left, at a distance and in a direction.
static jde::LaserScan scan(double distance, double heading)
{
    jde::LaserScan scan = {};
    scan.angle_increment = static_cast<float>(jde::pi / 180.0);
    scan.range_max = 8.0f;
    for (int beam = 0; beam < 180; beam++) {
        const double across = std::sin(beam * jde::pi / 180.0 - heading);
        jde::push(scan.ranges, across > 0.1 ? static_cast<float>(distance / across) : 100.0f);
    }
    return scan;
}

static void it_fits_a_wall_in_any_direction()
{
    jde::Bench<Finder> bench;
    for (const double heading : {-0.3, 0.0, 0.3}) {
        bench.import("laser", scan(1.2, heading));
        bench.iterate();
        const auto wall = bench.exported<Wall>("wall");
        JDE_EXPECT(wall && std::fabs(wall->distance - 1.2) < 1e-4 && std::fabs(wall->heading - heading) < 1e-4);
    }
    bench.import("laser", jde::LaserScan{});
    bench.iterate();
    JDE_EXPECT(!bench.exported<Wall>("wall"));
}

static void it_turns_to_a_wall_that_is_too_far()
{
    jde::Bench<Follow> bench;
    JDE_EXPECT(!bench.check().ready);
    bench.import("wall", Wall{1.5, 0.0});
    bench.iterate();
    JDE_EXPECT(bench.commanded<jde::Twist>("base").value().angular.z == 0.4);
}

int main()
{
    return jde::run({{"it fits a wall in any direction", it_fits_a_wall_in_any_direction},
                     {"it turns to a wall that is too far", it_turns_to_a_wall_that_is_too_far}});
}
