// Every widget and some shapes of a panel: the same as examples/c/gauge.c.
#include <jde.hpp>

using namespace std::chrono_literals;

struct GaugePorts : jde::Ports {
    jde::Export<double> level{*this, "level", "The level, from 0 to 1."};
};

class Gauge : public jde::Perceptive<GaugePorts>, public jde::Panel {
public:
    static constexpr jde::About about() { return {"gauge", "Shows and exports a level that users set.", 100ms}; }

    void iterate(jde::Context &cx) override { level.write(cx, on_ ? height_ : 0.0); }

    void draw(jde::Context &, jde::Pen &pen) const override
    {
        pen.heading("Gauge");
        pen.value("level", height_, "m");
        {
            auto row = pen.row();
            pen.button("empty", "Empty", height_ > 0.0);
            pen.toggle("on", "On", on_);
        }
        pen.slider("level", "Level", height_, 0.0, 1.0, "m");
        pen.choice("mode", "Mode", {"slow", "fast"}, mode_);
        const std::string cells[] = {"level", "half"};
        pen.table("table", {"what", "value"}, cells);
        const std::uint8_t pixels[] = {0, 128, 255, 64};
        pen.image("image", pixels, 2, 2);
        pen.plot("plot", "Level", "time, s", "level").curve("level", {{0.0, 0.0}, {1.0, 0.5}, {2.0, 0.25}}, jde::Ink::accent);
        {
            auto more = pen.folded("more", "More");
            auto plane = pen.canvas("plane", jde::Wants::forward_up | jde::Wants::clicks);
            plane.rectangle({0.0, 0.0}, {1.0, 1.0}, jde::Ink::good);
            plane.arrow({0.0, 0.0}, {1.0, 2.0}, jde::Ink::bad);
            plane.disc(mark_, 0.25, jde::Ink::goal);
            plane.label(mark_, "mark", jde::Ink::goal);
            plane.robot({1.0, 2.0, 0.5});
        }
        pen.scene("space", "base_link").box({0.0, 0.0, 0.5}, {0.0, 0.0, 0.25}, {1.0, 2.0, 3.0}, jde::Stroke(0x80ff8000));
    }

    void touched(jde::Context &cx, const jde::Gesture &gesture) override
    {
        if (gesture.pressed("empty")) {
            height_ = 0.0;
        } else if (const auto on = gesture.toggled("on")) {
            on_ = *on;
        } else if (const auto height = gesture.moved("level")) {
            height_ = *height;
        } else if (const auto mode = gesture.chose("mode")) {
            mode_ = *mode;
        } else if (const auto at = gesture.clicked("plane")) {
            mark_ = *at;
            cx.info("%s", gesture.by());
        } else if (gesture.raw().kind == JDE_TOUCH_KEY) {
            throw jde::Failure("keys have no effect");
        }
    }

private:
    double height_ = 0.0;
    bool on_ = true;
    std::size_t mode_ = 0;
    jde::At2 mark_{0.0, 0.0};
};

JDE_EXPORT_PLUGIN("gauge", "0.1.0", "A level that users set.", Gauge);
