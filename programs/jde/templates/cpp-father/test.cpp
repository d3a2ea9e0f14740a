#include "../src/schema.hpp"

#include <jde/bench.hpp>

static jde::Odometry odometry(double x)
{
    jde::Odometry odometry = {};
    odometry.pose.pose = {{x, 1.5, 0.0}, jde::from_yaw(0.0)};
    return odometry;
}

static void it_drives_back_and_forth()
{
    jde::Bench<__Name__> bench;
    const double first = 1.5, second = 4.5;
    for (const auto &[at, to] : {std::pair(first, second), {second, first}, {second, first}, {first, second}}) {
        bench.import("pose", odometry(at));
        bench.iterate();
        JDE_EXPECT(bench.modulated<jde::Target>("cruise", "target")->pose.x == to);
    }
    JDE_EXPECT(bench.child_state("brake") == jde::State::checking && bench.child_state("cruise") == jde::State::checking);
}

static void the_brake_wins_when_both_children_are_ready()
{
    jde::Bench<__Name__> bench;
    bench.set_child("brake", jde::State::ready);
    bench.set_child("cruise", jde::State::winner);
    JDE_EXPECT(bench.arbitrate("base").child == "brake");
    bench.set_child("brake", jde::State::checking);
    bench.set_child("cruise", jde::State::checking);
    JDE_EXPECT(bench.arbitrate("base").child.empty());
}

int main()
{
    return jde::run({{"it drives back and forth", it_drives_back_and_forth},
                     {"the brake wins when both children are ready", the_brake_wins_when_both_children_are_ready}});
}
