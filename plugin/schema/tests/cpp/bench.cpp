// Tests of the bench in C++, on schemas of the other tests.
#include <jde/bench.hpp>
#include <jde.hpp>

#undef JDE_EXPORT_PLUGIN
#define JDE_EXPORT_PLUGIN(...) static_assert(true, "a test exports no plugin")
#include "../../examples/cpp/counter.cpp"
#include "../../examples/cpp/gauge.cpp"
#include "doors.cpp"

template <typename Call>
static std::string failure(Call call)
{
    try {
        call();
    } catch (const std::exception &failure) {
        return failure.what();
    }
    throw std::runtime_error("the call does not fail");
}

static void a_father_acts()
{
    jde::Bench<Porter> bench;
    JDE_EXPECT(!bench.check().ready);
    Doors doors = {};
    doors.count = 1;
    jde::assign(doors.building, "hall");
    bench.import("doors", doors);
    bench.set("gait", Gait::slow);
    bench.unbind("wind");
    JDE_EXPECT(bench.check().ready && bench.check().urgency == 2.0);
    bench.set_now(7ns);
    bench.iterate();
    JDE_EXPECT(bench.log().back().second == "bench, 0 places in hall, slow");
    const Doors *passed = bench.exported_in_place<Doors>("passed");
    JDE_EXPECT(passed != nullptr && jde::text(passed->building) == "annex" && jde::elements(passed->places)[0].y == 2.0);
    JDE_EXPECT(bench.exported_at("passed") == 5ns);
    JDE_EXPECT(bench.commanded<jde::Twist>("base").value().linear.x == -0.2);
    JDE_EXPECT(bench.modulated<bool>("cruise", "hurry") == false);
    JDE_EXPECT(bench.policy("cruise")->time == 1s);
    JDE_EXPECT(bench.child_state("brake") == jde::State::checking && bench.child_state("map") == jde::State::winner);
    bench.set_child("brake", jde::State::ready);
    bench.set_child("cruise", jde::State::winner);
    JDE_EXPECT(bench.arbitrate("base").child == "brake");
    bench.set_authority(false);
    bench.iterate();
    JDE_EXPECT(!bench.commanded<jde::Twist>("base"));
}

static void children_of_any_number_have_names()
{
    jde::Bench<Porter> bench;
    Doors doors = {};
    bench.import("doors", doors);
    JDE_EXPECT(bench.awake_children().empty());
    bench.name_children({{"one", "others"}, {"two", "base"}});
    bench.iterate();
    JDE_EXPECT((bench.awake_children() == std::vector<std::string>{"brake", "cruise", "map", "one", "two"}));
    bench.set_child("brake", jde::State::ready);
    bench.set_child("two", jde::State::ready);
    JDE_EXPECT(bench.arbitrate("base").child == "brake");
}

static void a_panel_is_drawn_and_touched()
{
    jde::Bench<Gauge> bench;
    bench.touch(JDE_TOUCH_MOVED, "level", 0.75);
    bench.touch(JDE_TOUCH_CHOSE, "mode", 1);
    bench.click("plane", 0.5, -1.5);
    JDE_EXPECT(bench.log().back().second == "ana@laptop");
    const jde::DrawnPanel panel = bench.draw();
    JDE_EXPECT(panel.value("level") == 0.75);
    JDE_EXPECT(panel.widget("mode").raw.number == 1 && panel.widget("mode").texts[1] == "fast");
    JDE_EXPECT(panel.widget("plane").shapes.size() == 5);
    JDE_EXPECT((panel.widget("plane").shapes[2].points == std::vector<double>{0.5, -1.5}));
    JDE_EXPECT(panel.widget("space").shapes[0].raw.extent[2] == 3.0);
    bench.iterate();
    JDE_EXPECT(bench.exported<double>("level") == 0.75);
}

static void memory_is_saved_and_restored()
{
    jde::Bench<Counter> before, after;
    before.set<std::uint32_t>("step", 5);
    before.iterate();
    after.restore(before.save());
    after.iterate();
    JDE_EXPECT(after.exported<std::uint32_t>("count") == 6u);
    JDE_EXPECT(failure([&] { after.restore({1, "x"}); }) == "a std_msgs/msg/UInt32 was to come, and nothing more was saved");
}

static void mistakes_of_a_test_are_exceptions()
{
    jde::Bench<Porter> bench;
    JDE_EXPECT(failure([&] { bench.import("door", 1.0); }) == "there is no port `door` of this kind, but doors wind");
    JDE_EXPECT(failure([&] { bench.import("wind", 1.0f); }) == "`wind` is a std_msgs/msg/Float64, not a std_msgs/msg/Float32");
    JDE_EXPECT(failure([&] { bench.set<std::int16_t>("floor", 10); }) == "the value of `floor` is outside its limits");
    JDE_EXPECT(failure([&] { bench.child_state("nobody"); }) == "there is no child `nobody`");
}

/** A schema that makes mistakes. */
struct FaultyPorts : jde::Ports {
    jde::Modulation<std::uint32_t> mistake{*this, "mistake", "Which one.", 0};
    jde::Child helper{*this, "helper", "A perceptive child.", jde::perceptive};
    jde::Export<double> out{*this, "out", "An output."};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds."};
};
class Faulty : public jde::Motor<FaultyPorts>, public jde::Panel {
public:
    static constexpr jde::About about() { return {"faulty", "Fails.", 1s}; }
    CounterPorts foreign;
    PorterPorts other;

    void iterate(jde::Context &cx) override
    {
        switch (mistake.get(cx)) {
        case 0: throw 7;
        case 1: throw std::out_of_range("beyond the end");
        case 2: throw jde::Failure("the cable is loose");
        case 3: foreign.count.write(cx, 1); break;
        case 4: other.brake.wake(cx); break;
        case 6: helper.set_policy(cx, jde::Policy::urgency()); break;
        case 5: JDE_EXPECT(base.command(cx, jde::planar(std::numeric_limits<double>::quiet_NaN(), 0.0)) == jde::Outcome::not_finite);
        }
    }
    void draw(jde::Context &cx, jde::Pen &pen) const override
    {
        static constexpr double huge = std::numeric_limits<double>::infinity();
        static const std::vector<std::uint8_t> pixels(1 << 22);
        switch (mistake.get(cx)) {
        case 10: pen.value("speed", -huge, "m/s"); break;
        case 11: pen.button("go", "Go"), pen.button("go", "Go too"); break;
        case 12: pen.button("", "Go"); break;
        case 13: pen.slider("ahead", "Ahead", 1.0, 2.0, 1.0, "m"); break;
        case 14: pen.choice("mode", "Mode", {"slow", "fast"}, 2); break;
        case 15: pen.canvas("plane").disc({0.0, 0.0}, -1.0); break;
        case 16: pen.scene("space", "map").line({{0.0, 0.0, huge}}); break;
        case 17: {
            auto plane = pen.canvas("plane");
            pen.text("inside");
            break;
        }
        case 18:
            for (int number = 0; number <= 20000; number++) {
                pen.text("again");
            }
            break;
        case 19: pen.text(std::string(4097, 'a').c_str()); break;
        case 20: pen.button(std::string(4097, 'a').c_str(), "Go"); break;
        case 21: pen.button("go\x7F\n\u0085\u00E9", "Go"); break;
        case 22: pen.image("seen", {pixels.data(), 5000}, 5000, 1); break;
        case 23:
            for (const char *id : {"front", "rear"}) {
                pen.image(id, pixels, 2048, 2048);
            }
            break;
        case 24: pen.canvas("plane").line(std::vector<jde::At2>(400001, {0.0, 0.0})); break;
        case 25: pen.canvas("plane").label({0.0, 0.0}, std::string(4097, 'a').c_str()); break;
        default: const_cast<Faulty *>(this)->out.write(cx, 1.0);
        }
    }
};

static void exceptions_are_failures_with_their_texts()
{
    jde::Bench<Faulty> bench;
    const char *const reasons[] = {"it threw something that is not a std::exception", "beyond the end", "the cable is loose",
                                   "`count` is a port of another schema than the one that is called; use it in calls of its own",
                                   "`brake` is a child of another schema than the one that is called; use it in calls of its own"};
    for (std::uint32_t mistake = 0; mistake < 5; mistake++) {
        bench.set("mistake", mistake);
        try {
            bench.iterate();
            JDE_EXPECT(false);
        } catch (const jde::CallFailed &failed) {
            JDE_EXPECT(failed.what() == std::string(reasons[mistake]));
            JDE_EXPECT(failed.panicked() == (mistake != 2));
        }
    }
    bench.set<std::uint32_t>("mistake", 5);
    bench.iterate();
    bench.set<std::uint32_t>("mistake", 6);
    JDE_EXPECT(failure([&] { bench.iterate(); }).find("the host answered 4 to `set_policy` of `helper`") == 0);
    JDE_EXPECT(failure([&] { bench.draw(); }) == "it tried to write while its panel was drawn");
}

/** The words are those of the list's own checks, plugin/panel/src/limits.rs. */
static void a_panel_that_no_viewer_shows_is_a_failure()
{
    const char *const reasons[] = {"`speed`: a number is -inf",
                                   "`go`: two widgets have this id",
                                   "``: a widget of this kind needs an id",
                                   "`ahead`: its least value is above its greatest",
                                   "`mode`: what is chosen is none of its options",
                                   "`plane`: a size is -1",
                                   "`space`: a number is inf",
                                   "`plane`: no widget can stand inside it",
                                   "it has more than 20000 widgets and shapes",
                                   "`a text`: a text has 4097 bytes, and 4096 are allowed",
                                   "`aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa`: a text has 4097 bytes, and 4096 are allowed",
                                   "`go???\u00E9`: its id has control characters, and no gesture may have them",
                                   "`seen`: it is 5000 × 1 pixels, and 4096 to a side are allowed",
                                   "its texts and pixels have 8388617 bytes, and 8388608 are allowed",
                                   "it has more than 400000 points",
                                   "`plane`: a text has 4097 bytes, and 4096 are allowed"};
    jde::Bench<Faulty> bench;
    for (std::uint32_t mistake = 0; mistake < std::size(reasons); mistake++) {
        bench.set("mistake", mistake + 10);
        JDE_EXPECT(failure([&] { bench.draw(); }) == reasons[mistake]);
    }
    // A schema in C can begin what it does not end, and end what it has not begun.
    jde::detail::BenchDrawing begun, ended;
    const jde_pen pens[] = {begun.pen(), ended.pen()};
    jde_begin_row(&pens[0]);
    begun.finish();
    jde_end(&pens[1]);
    JDE_EXPECT(begun.broken == "`a row`: it was begun and not ended");
    JDE_EXPECT(ended.broken == "``: an end of nothing that was begun");
}

/** A schema whose destructor throws. */
class Clinging : public jde::Perceptive<> {
public:
    static constexpr jde::About about() { return {"clinging", "Does not end.", 1s}; }
    ~Clinging() { throw std::runtime_error("it does not end"); }
    void iterate(jde::Context &) override {}
};

static void a_destructor_may_throw()
{
    jde::Bench<Clinging> bench;
    bench.iterate();
}

static void hysteresis_has_two_thresholds()
{
    jde::Hysteresis near;
    JDE_EXPECT(!near.below(1.1, 1.0, 1.5) && near.below(1.0, 1.0, 1.5) && near.below(1.5, 1.0, 1.5) && !near.below(1.6, 1.0, 1.5));
    JDE_EXPECT(near.above(2.0, 2.0, 1.0) && near.above(1.0, 2.0, 1.0) && !near.above(0.9, 2.0, 1.0));
}

int main()
{
    return jde::run({{"a father acts", a_father_acts},
                     {"children of any number have names", children_of_any_number_have_names},
                     {"a panel that no viewer shows is a failure", a_panel_that_no_viewer_shows_is_a_failure},
                     {"a panel is drawn and touched", a_panel_is_drawn_and_touched},
                     {"memory is saved and restored", memory_is_saved_and_restored},
                     {"mistakes of a test are exceptions", mistakes_of_a_test_are_exceptions},
                     {"exceptions are failures with their texts", exceptions_are_failures_with_their_texts},
                     {"a destructor may throw", a_destructor_may_throw},
                     {"hysteresis has two thresholds", hysteresis_has_two_thresholds}});
}
