/*
 * The panel that a bench draws: its widgets, and the mistakes for which a viewer would not show it.
 */
#ifndef JDE_BENCH_PANEL_HPP
#define JDE_BENCH_PANEL_HPP

#include "plugin.hpp"

#include <deque>
#include <set>
#include <utility>

namespace jde {

/** A widget of a drawn panel, with the shapes in it. */
struct DrawnWidget {
    struct Shape {
        std::uint32_t kind;
        std::vector<double> points;
        std::string text;
        jde_shape raw;
    };
    std::uint32_t kind;
    std::string id, label, unit;
    std::vector<std::string> texts;
    /** The rest of it. Its pointers are null. */
    jde_widget raw;
    std::vector<Shape> shapes;
};

namespace detail {

/** A panel under construction, behind the functions of a pen. The first mistake breaks it, with the words of a viewer. */
struct BenchDrawing {
    std::deque<DrawnWidget> widgets;
    std::vector<DrawnWidget *> open;
    std::set<std::string> ids;
    std::size_t items = 0;
    std::string broken;

    static BenchDrawing &of(jde_drawing *drawing) noexcept { return *reinterpret_cast<BenchDrawing *>(drawing); }
    jde_pen pen() noexcept { return {sizeof(jde_pen), 0, reinterpret_cast<jde_drawing *>(this), add, shape, end}; }
    /** Ends the drawing. */
    void finish()
    {
        if (!open.empty()) {
            wrong(name(*open.back()), "it was begun and not ended");
        }
    }

private:
    static std::string text(const char *text) { return text != nullptr ? text : ""; }
    static std::string name(const DrawnWidget &widget)
    {
        switch (widget.kind) {
        case JDE_WIDGET_TEXT: return "a text";
        case JDE_WIDGET_VALUE: return widget.label;
        case JDE_WIDGET_ROW: return "a row";
        default: return widget.id;
        }
    }
    std::int32_t wrong(const std::string &widget, const std::string &reason) { return refuse("`" + widget + "`: " + reason); }
    std::int32_t refuse(const std::string &reason)
    {
        broken = broken.empty() ? reason : broken;
        return JDE_BAD_ARGUMENT;
    }
    bool count(std::size_t more)
    {
        items += more;
        return items <= 20000 || refuse("it has more than 20000 widgets and shapes") == JDE_OK;
    }
    bool finite(const std::string &widget, const double *numbers, std::size_t count)
    {
        for (std::size_t index = 0; index < count; index++) {
            if (!std::isfinite(numbers[index])) {
                const char *const shown = std::isnan(numbers[index]) ? "NaN" : numbers[index] > 0.0 ? "inf" : "-inf";
                return wrong(widget, std::string("a number is ") + shown) == JDE_OK;
            }
        }
        return true;
    }

    static std::int32_t add(jde_drawing *drawing, const jde_widget *widget)
    {
        BenchDrawing &self = of(drawing);
        if (!self.broken.empty()) {
            return JDE_BAD_ARGUMENT;
        }
        DrawnWidget drawn = {widget->kind, text(widget->id), text(widget->label), text(widget->unit), {}, *widget, {}};
        for (std::uint32_t index = 0; index < widget->text_count; index++) {
            drawn.texts.push_back(text(widget->texts[index]));
        }
        const std::int32_t code = self.check(drawn);
        drawn.raw.id = drawn.raw.label = drawn.raw.unit = nullptr;
        drawn.raw.texts = nullptr;
        drawn.raw.pixels = nullptr;
        self.widgets.push_back(std::move(drawn));
        if (widget->kind >= JDE_WIDGET_ROW) {
            self.open.push_back(&self.widgets.back());
        }
        return code;
    }
    std::int32_t check(const DrawnWidget &widget)
    {
        const std::string called = name(widget);
        const jde_widget &raw = widget.raw;
        if (!open.empty() && open.back()->kind >= JDE_WIDGET_PLOT) {
            return wrong(name(*open.back()), "no widget can stand inside it");
        }
        if (open.size() > 8) {
            return refuse("rows and groups stand more than 8 deep in each other");
        }
        if (!count(1 + (widget.kind == JDE_WIDGET_CHOICE || widget.kind == JDE_WIDGET_TABLE ? widget.texts.size() : 0))) {
            return JDE_BAD_ARGUMENT;
        }
        if (widget.kind > JDE_WIDGET_VALUE && widget.kind != JDE_WIDGET_ROW) {
            if (widget.id.empty()) {
                return wrong(called, "a widget of this kind needs an id");
            }
            if (!ids.insert(widget.id).second) {
                return wrong(called, "two widgets have this id");
            }
        }
        const double numbers[] = {raw.value, raw.least, raw.greatest};
        if (!finite(called, numbers, 3) || !finite(called, raw.area, 4)) {
            return JDE_BAD_ARGUMENT;
        }
        switch (widget.kind) {
        case JDE_WIDGET_SLIDER:
            return raw.least > raw.greatest ? wrong(called, "its least value is above its greatest") : JDE_OK;
        case JDE_WIDGET_CHOICE:
            return raw.number >= widget.texts.size() ? wrong(called, "what is chosen is none of its options") : JDE_OK;
        case JDE_WIDGET_IMAGE:
            if (raw.channels != 1 && raw.channels != 3 && raw.channels != 4) {
                return wrong(called, "a pixel has 1, 3 or 4 bytes");
            }
            return raw.width == 0 || raw.height == 0 ? wrong(called, "it has not as many pixels as its width and height say") : JDE_OK;
        case JDE_WIDGET_TABLE:
            if (raw.number == 0 || widget.texts.size() % raw.number != 0) {
                return wrong(called, std::to_string(widget.texts.size()) + " texts do not fill " + std::to_string(raw.number) + " columns");
            }
            return JDE_OK;
        case JDE_WIDGET_CANVAS: {
            const double *const area = raw.area;
            const bool has_area = area[0] != 0.0 || area[1] != 0.0 || area[2] != 0.0 || area[3] != 0.0;
            return has_area && (area[0] >= area[2] || area[1] >= area[3]) ? wrong(called, "its area is empty") : JDE_OK;
        }
        default: return JDE_OK;
        }
    }

    static std::int32_t shape(jde_drawing *drawing, const jde_shape *shape)
    {
        BenchDrawing &self = of(drawing);
        if (!self.broken.empty()) {
            return JDE_BAD_ARGUMENT;
        }
        if (self.open.empty() || self.open.back()->kind < JDE_WIDGET_PLOT) {
            return self.wrong(self.open.empty() ? "" : name(*self.open.back()), "a shape outside of a plot, canvas or scene");
        }
        DrawnWidget &widget = *self.open.back();
        const std::size_t numbers = std::size_t{shape->point_count} * (widget.kind == JDE_WIDGET_SCENE ? 3 : 2);
        widget.shapes.push_back({shape->kind, std::vector<double>(shape->points, shape->points + numbers), text(shape->text), *shape});
        return self.check(widget.id, widget.kind, *shape, widget.shapes.back().points);
    }
    std::int32_t check(const std::string &widget, std::uint32_t kind, const jde_shape &shape, const std::vector<double> &points)
    {
        if (!count(1) || !finite(widget, points.data(), points.size()) || !finite(widget, shape.turned, 3)) {
            return JDE_BAD_ARGUMENT;
        }
        if (kind == JDE_WIDGET_PLOT) {
            return shape.kind == JDE_SHAPE_LINE ? JDE_OK : wrong(widget, "a plot holds nothing but lines");
        }
        const bool flat = shape.kind <= JDE_SHAPE_LABEL || (shape.kind >= JDE_SHAPE_CIRCLE && shape.kind <= JDE_SHAPE_ROBOT);
        const bool solid = shape.kind <= JDE_SHAPE_LABEL || (shape.kind >= JDE_SHAPE_BOX && shape.kind <= JDE_SHAPE_MESH);
        if (kind == JDE_WIDGET_CANVAS ? !flat : !solid) {
            return wrong(widget, (kind == JDE_WIDGET_CANVAS ? "a canvas" : "a scene") + (" has no shape of kind " + std::to_string(shape.kind)));
        }
        if (shape.kind == JDE_SHAPE_MESH && shape.point_count % 3 != 0) {
            return wrong(widget, "a mesh has three corners to a triangle");
        }
        const bool many = shape.kind == JDE_SHAPE_LINE || shape.kind == JDE_SHAPE_POINTS || shape.kind == JDE_SHAPE_POLYGON || shape.kind == JDE_SHAPE_MESH;
        const std::uint32_t expected = shape.kind == JDE_SHAPE_ARROW ? 2 : 1;
        if (!many && shape.point_count != expected) {
            return wrong(widget, "a shape has " + std::to_string(shape.point_count) + " points, and its kind has " + std::to_string(expected));
        }
        const double sizes[] = {shape.radius, shape.extent[0], shape.extent[1], shape.extent[2]};
        if (!finite(widget, sizes, 4)) {
            return JDE_BAD_ARGUMENT;
        }
        for (const double size : sizes) {
            if (size < 0.0) {
                return wrong(widget, format("a size is %g", size));
            }
        }
        return std::isfinite(shape.width) && shape.width >= 0.0 ? JDE_OK : wrong(widget, format("a line of width %g", shape.width));
    }

    static std::int32_t end(jde_drawing *drawing)
    {
        BenchDrawing &self = of(drawing);
        if (self.open.empty()) {
            return self.wrong("", "an end of nothing that was begun");
        }
        self.open.pop_back();
        return JDE_OK;
    }
};

} // namespace detail
} // namespace jde

#endif
