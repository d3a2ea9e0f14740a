#include "tracker.hpp"

#include <jde/bench.hpp>

#include <memory>

// A grey picture of 100 by 50 pixels with an orange square at a column. A value of this size is too large for the stack.
static std::unique_ptr<jde::Image> picture(std::uint32_t column)
{
    auto image = std::make_unique<jde::Image>();
    image->width = 100;
    image->height = 50;
    image->step = 300;
    jde::assign(image->encoding, "rgb8");
    const auto pixels = jde::resize(image->data, 300 * 50);
    std::fill(pixels.begin(), pixels.end(), std::uint8_t{128});
    for (std::uint32_t row = 20; row < 30; row++) {
        for (std::uint32_t place = column - 5; place < column + 5; place++) {
            pixels[row * 300 + place * 3] = 255;
            pixels[row * 300 + place * 3 + 1] = 128;
            pixels[row * 300 + place * 3 + 2] = 0;
        }
    }
    return image;
}

static void it_finds_the_direction_of_a_spot()
{
    jde::Bench<Tracker> bench;
    bench.set("view", 60.0);
    for (const auto &[column, sign] : {std::pair(25u, 1.0), {75u, -1.0}}) {
        bench.import("image", *picture(column));
        bench.iterate();
        // Halfway to the edge of the picture.
        const double expected = sign * std::atan(0.5 * std::tan(jde::pi / 6.0));
        JDE_EXPECT(std::fabs(bench.exported<double>("bearing").value() - expected) < 0.01);
    }
}

static void it_sees_no_other_colour_and_no_small_spot()
{
    jde::Bench<Tracker> bench;
    bench.import("image", *picture(25));
    bench.set("hue_from", 200.0);
    bench.set("hue_to", 240.0);
    bench.iterate();
    JDE_EXPECT(!bench.exported<double>("bearing"));
    bench.set("hue_from", 20.0);
    bench.set<std::uint32_t>("least", 101);
    bench.iterate();
    JDE_EXPECT(!bench.exported<double>("bearing"));
}

int main()
{
    return jde::run({{"it finds the direction of a spot", it_finds_the_direction_of_a_spot},
                     {"it sees no other colour and no small spot", it_sees_no_other_colour_and_no_small_spot}});
}
