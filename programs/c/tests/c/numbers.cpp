// Writes numbers of several types, and prints what became of them.
#include <iostream>

#include <jde/run.hpp>

int main(int argc, char **argv)
try {
    if (argc != 2) {
        return 2;
    }
    jde::StartOptions options;
    options.lockstep = true;
    jde::Run run = jde::Application(argv[1]).start(options);
    double time = 0.0;
    const auto print = [&](const char *name) {
        run.until(time += 0.1);
        std::cout << run.number(name).value() << '\n';
    };
    run.write("dock.margin", 1);
    print("dock.margin");
    run.write("dock.margin", 0.25f);
    print("dock.margin");
    run.write("dock.margin", 0.5);
    print("dock.margin");
    run.write("dock.margin", "75 cm");
    print("dock.margin");
    run.write("dock.id", 9u);
    print("dock.id");
    run.write("dock.leave", true);
    print("dock.leave");
    return 0;
} catch (const jde::Error &error) {
    std::cerr << error.what() << '\n';
    return 1;
}
