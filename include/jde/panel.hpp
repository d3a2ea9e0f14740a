/*
 * Panels: what any viewer shows of a schema, and what its users do there.
 */
#ifndef JDE_PANEL_HPP
#define JDE_PANEL_HPP

#include "schema.hpp"
#include "types.hpp"

#include <initializer_list>
#include <optional>

namespace jde {

/** A color that fits the viewer's theme. */
enum class Ink : std::uint32_t {
    plain = JDE_INK_PLAIN,
    faint = JDE_INK_FAINT,
    accent = JDE_INK_ACCENT,
    good = JDE_INK_GOOD,
    warn = JDE_INK_WARN,
    bad = JDE_INK_BAD,
    goal = JDE_INK_GOAL,
    seen = JDE_INK_SEEN,
};

/** How a shape is drawn: its color, and the width of its lines or the diameter of its points; 0 for the default. */
struct Stroke {
    std::uint32_t color;
    double width;
    constexpr Stroke(Ink ink = Ink::plain, double width = 0.0) noexcept : color(static_cast<std::uint32_t>(ink)), width(width) {}
    /** Exactly 0xAARRGGBB, of which AA, the opacity, is not 0. */
    constexpr explicit Stroke(std::uint32_t color, double width = 0.0) noexcept : color(color), width(width) {}
};

/** A point of a canvas or a plot. Anything with `x` and `y` converts into it. */
struct At2 {
    double x, y;
    constexpr At2(double x, double y) noexcept : x(x), y(y) {}
    template <typename Point, typename = decltype(std::declval<const Point &>().y)>
    constexpr At2(const Point &point) noexcept : x(point.x), y(point.y) {}
};
/** A point of a scene. Anything with `x`, `y` and `z` converts into it. */
struct At3 {
    double x, y, z;
    constexpr At3(double x, double y, double z) noexcept : x(x), y(y), z(z) {}
    template <typename Point, typename = decltype(std::declval<const Point &>().z)>
    constexpr At3(const Point &point) noexcept : x(point.x), y(point.y), z(point.z) {}
};

/** What a canvas, a scene or an image reports, and how a canvas lies: combined by `|`. */
enum class Wants : std::uint32_t { nothing = 0, clicks = JDE_WANTS_CLICKS, drags = JDE_WANTS_DRAGS, keys = JDE_WANTS_KEYS, forward_up = JDE_FORWARD_UP };
constexpr Wants operator|(Wants one, Wants other) noexcept
{
    return static_cast<Wants>(static_cast<std::uint32_t>(one) | static_cast<std::uint32_t>(other));
}

class Pen;

namespace detail {

/** A widget that contains others, or shapes. It is open to the end of its life. */
class Container {
public:
    Container(const Container &) = delete;
    Container &operator=(const Container &) = delete;
    ~Container() { jde_end(&pen_); }

protected:
    Container(const jde_pen &pen, const jde_widget &widget) noexcept : pen_(pen) { jde_add(&pen, &widget); }

    /** Draws a shape through points of the type `At`. */
    template <typename At, typename Points>
    void draw(jde_shape shape, const Points &points, const Stroke &stroke)
    {
        std::vector<At> all;
        for (const auto &point : points) {
            all.push_back(At(point));
        }
        static_assert(std::is_standard_layout_v<At> && sizeof(At) % sizeof(double) == 0, "a point is a row of numbers");
        shape.points = all.empty() ? nullptr : &all.front().x;
        shape.point_count = static_cast<std::uint32_t>(all.size());
        shape.color = stroke.color;
        shape.width = stroke.width;
        jde_draw(&pen_, &shape);
    }

    static jde_shape shape(std::uint32_t kind, std::uint32_t flags = 0) noexcept
    {
        jde_shape shape = jde_shape_of(kind, 0);
        shape.flags = flags;
        return shape;
    }

private:
    const jde_pen &pen_;
};

} // namespace detail

/** A row or a group of widgets. The widgets that the pen adds belong to it, until the end of its life. */
class Group : detail::Container {
    friend class Pen;
    using Container::Container;
};

/** A plot of curves. */
class Plot : detail::Container {
public:
    template <typename Points = std::initializer_list<At2>>
    void curve(const char *name, const Points &points, Stroke stroke = {})
    {
        jde_shape curve = shape(JDE_SHAPE_LINE);
        curve.text = name;
        draw<At2>(curve, points, stroke);
    }

private:
    friend class Pen;
    using Container::Container;
};

/** A plane in metres. */
class Canvas : detail::Container {
public:
    template <typename Points = std::initializer_list<At2>>
    void line(const Points &points, Stroke stroke = {}) { draw<At2>(shape(JDE_SHAPE_LINE), points, stroke); }
    /** A line that returns to its first point. */
    template <typename Points = std::initializer_list<At2>>
    void outline(const Points &points, Stroke stroke = {}) { draw<At2>(shape(JDE_SHAPE_LINE, JDE_CLOSED), points, stroke); }
    void rectangle(At2 least, At2 greatest, Stroke stroke = {})
    {
        outline({{least.x, least.y}, {greatest.x, least.y}, {greatest.x, greatest.y}, {least.x, greatest.y}}, stroke);
    }
    /** A filled convex polygon. */
    template <typename Points = std::initializer_list<At2>>
    void polygon(const Points &corners, Stroke stroke = {}) { draw<At2>(shape(JDE_SHAPE_POLYGON), corners, stroke); }
    template <typename Points = std::initializer_list<At2>>
    void points(const Points &points, Stroke stroke = {}) { draw<At2>(shape(JDE_SHAPE_POINTS), points, stroke); }
    void circle(At2 center, double radius, Stroke stroke = {}) { round(center, radius, 0, stroke); }
    /** A filled circle. */
    void disc(At2 center, double radius, Stroke stroke = {}) { round(center, radius, JDE_FILLED, stroke); }
    void arrow(At2 from, At2 to, Stroke stroke = {}) { draw<At2>(shape(JDE_SHAPE_ARROW), std::initializer_list<At2>{from, to}, stroke); }
    void label(At2 at, const char *text, Stroke stroke = {})
    {
        jde_shape label = shape(JDE_SHAPE_LABEL);
        label.text = text;
        draw<At2>(label, std::initializer_list<At2>{at}, stroke);
    }
    /** The outline of the robot that the application drives. */
    void robot(const Pose2D &pose = {})
    {
        jde_shape robot = shape(JDE_SHAPE_ROBOT);
        robot.turned[2] = pose.theta;
        draw<At2>(robot, std::initializer_list<At2>{pose}, {});
    }

private:
    friend class Pen;
    using Container::Container;
    void round(At2 center, double radius, std::uint32_t flags, const Stroke &stroke)
    {
        jde_shape circle = shape(JDE_SHAPE_CIRCLE, flags);
        circle.radius = radius;
        draw<At2>(circle, std::initializer_list<At2>{center}, stroke);
    }
};

/** A space in metres, in a frame of REP-105. Rotations are roll, pitch and yaw. */
class Scene : detail::Container {
public:
    template <typename Points = std::initializer_list<At3>>
    void line(const Points &points, Stroke stroke = {}) { draw<At3>(shape(JDE_SHAPE_LINE), points, stroke); }
    template <typename Points = std::initializer_list<At3>>
    void points(const Points &points, Stroke stroke = {}) { draw<At3>(shape(JDE_SHAPE_POINTS), points, stroke); }
    void arrow(At3 from, At3 to, Stroke stroke = {}) { draw<At3>(shape(JDE_SHAPE_ARROW), std::initializer_list<At3>{from, to}, stroke); }
    void label(At3 at, const char *text, Stroke stroke = {})
    {
        jde_shape label = shape(JDE_SHAPE_LABEL);
        label.text = text;
        draw<At3>(label, std::initializer_list<At3>{at}, stroke);
    }
    void box(At3 middle, At3 turned, At3 size, Stroke stroke = {}) { solid(JDE_SHAPE_BOX, middle, turned, 0.0, size, stroke); }
    void sphere(At3 center, double radius, Stroke stroke = {}) { solid(JDE_SHAPE_SPHERE, center, {0, 0, 0}, radius, {0, 0, 0}, stroke); }
    void cylinder(At3 middle, At3 turned, double radius, double height, Stroke stroke = {})
    {
        solid(JDE_SHAPE_CYLINDER, middle, turned, radius, {0, 0, height}, stroke);
    }
    /** Triangles with three corners each, counter-clockwise seen from outside. */
    template <typename Points = std::initializer_list<At3>>
    void mesh(const Points &corners, Stroke stroke = {}) { draw<At3>(shape(JDE_SHAPE_MESH), corners, stroke); }

private:
    friend class Pen;
    using Container::Container;
    void solid(std::uint32_t kind, At3 middle, At3 turned, double radius, At3 size, const Stroke &stroke)
    {
        jde_shape solid = shape(kind);
        solid.radius = radius;
        solid.turned[0] = turned.x, solid.turned[1] = turned.y, solid.turned[2] = turned.z;
        solid.extent[0] = size.x, solid.extent[1] = size.y, solid.extent[2] = size.z;
        draw<At3>(solid, std::initializer_list<At3>{middle}, stroke);
    }
};

/** The pen with which a schema draws its panel: each function adds a widget below the last one, or beside it in a row. */
class Pen {
public:
    using Texts = std::initializer_list<const char *>;

    explicit Pen(const jde_pen &raw) noexcept : raw_(raw) {}
    Pen(const Pen &) = delete;
    Pen &operator=(const Pen &) = delete;

    void heading(const char *text) { words(JDE_WORDS_HEADING, text); }
    void text(const char *text) { words(JDE_WORDS_PLAIN, text); }
    /** A text in a style, JDE_WORDS_PLAIN to JDE_WORDS_CODE. */
    void words(std::uint32_t style, const char *text) { jde_add_text(&raw_, style, text); }
    void value(const char *label, double value, const char *unit = "") { jde_add_value(&raw_, label, value, unit); }
    void button(const char *id, const char *label, bool enabled = true) { jde_add_button(&raw_, id, label, enabled ? 0 : JDE_DISABLED); }
    void toggle(const char *id, const char *label, bool on) { jde_add_toggle(&raw_, id, label, on ? 1 : 0); }
    void slider(const char *id, const char *label, double value, double least, double greatest, const char *unit = "")
    {
        jde_add_slider(&raw_, id, label, value, least, greatest, unit);
    }
    void choice(const char *id, const char *label, Texts options, std::size_t chosen)
    {
        jde_add_choice(&raw_, id, label, options.begin(), count(options.size()), count(chosen));
    }
    /** A table: the headings of its columns, and the cells row by row. */
    void table(const char *id, Texts headings, Span<const std::string> cells)
    {
        std::vector<const char *> texts(headings);
        for (const std::string &cell : cells) {
            texts.push_back(cell.c_str());
        }
        jde_add_table(&raw_, id, texts.data(), count(texts.size()), count(headings.size()));
    }
    /** An image of rows from the top without gaps, with 1, 3 or 4 bytes for each pixel. */
    void image(const char *id, Span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height, Wants wants = Wants::nothing)
    {
        const std::size_t places = std::size_t{width} * height;
        jde_widget widget = of(JDE_WIDGET_IMAGE, id, nullptr, wants);
        widget.pixels = pixels.data();
        widget.width = width;
        widget.height = height;
        /* The host reports 0 channels as a mistake in the panel. */
        widget.channels = places > 0 && pixels.size() % places == 0 ? count(pixels.size() / places) : 0;
        jde_add(&raw_, &widget);
    }

    /** The widgets beside each other, while the result lives: `auto row = pen.row();`. */
    [[nodiscard]] Group row() { return {raw_, of(JDE_WIDGET_ROW)}; }
    /** The widgets below a heading, while the result lives. */
    [[nodiscard]] Group group(const char *id, const char *label) { return {raw_, of(JDE_WIDGET_GROUP, id, label)}; }
    /** The same, folded at first. */
    [[nodiscard]] Group folded(const char *id, const char *label)
    {
        jde_widget widget = of(JDE_WIDGET_GROUP, id, label);
        widget.flags = JDE_FOLDED;
        return {raw_, widget};
    }
    [[nodiscard]] Plot plot(const char *id, const char *label, const char *across, const char *up)
    {
        const char *const axes[] = {across, up};
        jde_widget widget = of(JDE_WIDGET_PLOT, id, label);
        widget.texts = axes;
        widget.text_count = JDE_COUNT(axes);
        return {raw_, widget};
    }
    [[nodiscard]] Canvas canvas(const char *id, Wants wants = Wants::nothing) { return {raw_, of(JDE_WIDGET_CANVAS, id, nullptr, wants)}; }
    /** A canvas that shows this area at first. */
    [[nodiscard]] Canvas canvas(const char *id, Wants wants, At2 least, At2 greatest)
    {
        jde_widget widget = of(JDE_WIDGET_CANVAS, id, nullptr, wants);
        widget.area[0] = least.x, widget.area[1] = least.y, widget.area[2] = greatest.x, widget.area[3] = greatest.y;
        return {raw_, widget};
    }
    [[nodiscard]] Scene scene(const char *id, const char *frame, Wants wants = Wants::nothing)
    {
        return {raw_, of(JDE_WIDGET_SCENE, id, frame, wants)};
    }

private:
    static jde_widget of(std::uint32_t kind, const char *id = nullptr, const char *label = nullptr, Wants wants = Wants::nothing) noexcept
    {
        jde_widget widget = jde_widget_of(kind);
        widget.id = id;
        widget.label = label;
        widget.flags = static_cast<std::uint32_t>(wants);
        return widget;
    }
    static std::uint32_t count(std::size_t number) noexcept
    {
        return number < UINT32_MAX ? static_cast<std::uint32_t>(number) : UINT32_MAX;
    }
    const jde_pen &raw_;
};

/** A gesture of a user on a widget. */
class Gesture {
public:
    explicit Gesture(const jde_gesture &raw) noexcept : raw_(raw) {}
    /** The operator: "ana@laptop". */
    const char *by() const noexcept { return raw_.by; }
    /** Whether this button was pressed. */
    bool pressed(const char *id) const noexcept { return is(JDE_TOUCH_PRESSED, id); }
    /** The new state of this toggle. */
    std::optional<bool> toggled(const char *id) const { return one<bool>(JDE_TOUCH_TOGGLED, id, raw_.number != 0); }
    /** The new value of this slider. */
    std::optional<double> moved(const char *id) const { return one<double>(JDE_TOUCH_MOVED, id, raw_.value); }
    /** The index of the option of this choice. */
    std::optional<std::size_t> chose(const char *id) const { return one<std::size_t>(JDE_TOUCH_CHOSE, id, raw_.number); }
    /** Where this canvas, scene or image was clicked. */
    std::optional<At3> clicked(const char *id) const { return one<At3>(JDE_TOUCH_CLICKED, id, {raw_.at[0], raw_.at[1], raw_.at[2]}); }
    /** All data, for drags and keys. */
    const jde_gesture &raw() const noexcept { return raw_; }

private:
    bool is(std::uint32_t kind, const char *id) const noexcept { return jde_touched(&raw_, kind, id) != 0; }
    template <typename T>
    std::optional<T> one(std::uint32_t kind, const char *id, T value) const
    {
        return is(kind, id) ? std::optional<T>(value) : std::nullopt;
    }
    const jde_gesture &raw_;
};

/** The ability to have a panel. */
class Panel {
public:
    /** Draws the panel in its present state. It changes nothing. An exception is shown in the panel and is no fault. */
    virtual void draw(Context &cx, Pen &pen) const = 0;
    /** A user did something with a widget. It is called between two iterations, and like one. */
    virtual void touched(Context &, const Gesture &) {}

protected:
    ~Panel() = default;
};

} // namespace jde

#endif
