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
    const auto print = [&](double time) {
        run.until(time);
        std::cout << run.number("vff.margin").value() << '\n';
    };
    run.write("vff.margin", 0);
    print(0.1);
    run.write("vff.margin", 0.25f);
    print(0.2);
    run.write("vff.margin", 0.5);
    print(0.3);
    run.write("vff.margin", "75 cm");
    print(0.4);
    return 0;
} catch (const jde::Error &error) {
    std::cerr << error.what() << '\n';
    return 1;
}
