/*
 * Sends the robot of an application to a place in real time, and waits until it is there.
 *
 *     c++ -std=c++17 real_time.cpp -ljde -o real_time && ./real_time apps/safe-navigation.toml
 */
#include <iostream>

#include <jde/run.hpp>

int main(int argc, char **argv)
try {
    if (argc != 2) {
        std::cerr << "usage: " << argv[0] << " FILE\n";
        return 2;
    }
    const jde::Application application(argv[1]);
    jde::StartOptions options;
    options.speed = 2.0;
    options.limit = 60.0;
    jde::Run run = application.start(options);

    run.write("example.route", "{ poses = [[3.55, 2.8, 0]] }");
    // If this program hangs, its operator's actions end after two seconds: the robot then takes the route of the file.
    while (run.lease(2.0), run.until(run.time() + 0.5)) {
        if (const auto odometry = run.read<jde::Odometry>("pioneer.odometry")) {
            std::clog << run.time() << " s: y = " << odometry->pose.pose.position.y << " m\n";
        }
    }
    std::cout << "the mission is " << run.outcome().value() << '\n';
    while (const auto record = run.next_record()) {
        if (record->kind == JDE_RECORD_DECISION) {
            std::clog << record->json << '\n';
        }
    }
    return run.outcome() == "done" ? 0 : 1;
} catch (const jde::Error &error) {
    std::cerr << error.what() << '\n';
    return 1;
}
