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
    std::size_t items = 0, all_points = 0;
    std::uint64_t bytes = 0;
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
    static constexpr std::size_t most_items = 20000, most_points = 400000, most_bytes = 8 << 20, most_text = 4096, most_side = 4096;

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
    /** Returns a text with a `?` in place of each control character. */
    static std::string printable(const std::string &text)
    {
        const auto byte = [&](std::size_t index) { return static_cast<unsigned char>(text[index]); };
        std::string shown;
        for (std::size_t index = 0; index < text.size(); index++) {
            const bool is_long = byte(index) == 0xC2 && byte(index + 1) < 0xA0;
            shown += is_long || byte(index) < 0x20 || byte(index) == 0x7F ? '?' : text[index];
            index += is_long;
        }
        return shown;
    }
    /** Names the first 40 characters of a widget's name. */
    std::int32_t wrong(const std::string &widget, const std::string &reason)
    {
        const std::string shown = printable(widget);
        std::size_t end = 0, characters = 0;
        while (end < shown.size() && (characters += (shown[end] & 0xC0) != 0x80) <= 40) {
            end++;
        }
        return refuse("`" + shown.substr(0, end) + "`: " + reason);
    }
    std::int32_t refuse(const std::string &reason)
    {
        broken = broken.empty() ? reason : broken;
        return JDE_BAD_ARGUMENT;
    }
    bool count(std::size_t more, std::size_t more_points = 0)
    {
        items += more;
        all_points += more_points;
        if (items > most_items) {
            return refuse("it has more than " + std::to_string(most_items) + " widgets and shapes") == JDE_OK;
        }
        return all_points <= most_points || refuse("it has more than " + std::to_string(most_points) + " points") == JDE_OK;
    }
    bool count_bytes(std::uint64_t more)
    {
        bytes += more;
        return bytes <= most_bytes || refuse("its texts and pixels have " + std::to_string(bytes) + " bytes, and " + std::to_string(most_bytes) + " are allowed") == JDE_OK;
    }
    bool fits(const std::string &widget, const std::string &text)
    {
        if (text.size() > most_text) {
            return wrong(widget, "a text has " + std::to_string(text.size()) + " bytes, and " + std::to_string(most_text) + " are allowed") == JDE_OK;
        }
        return count_bytes(text.size());
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
        if (!count(1 + (widget.kind == JDE_WIDGET_CHOICE || widget.kind == JDE_WIDGET_TABLE ? widget.texts.size() : 0)) || !fits(called, widget.id)) {
            return JDE_BAD_ARGUMENT;
        }
        if (widget.kind > JDE_WIDGET_VALUE && widget.kind != JDE_WIDGET_ROW) {
            if (widget.id.empty()) {
                return wrong(called, "a widget of this kind needs an id");
            }
            if (printable(widget.id) != widget.id) {
                return wrong(called, "its id has control characters, and no gesture may have them");
            }
            if (!ids.insert(widget.id).second) {
                return wrong(called, "two widgets have this id");
            }
        }
        bool is_fit = fits(called, widget.label) && fits(called, widget.unit);
        for (const std::string &text : widget.texts) {
            is_fit = is_fit && fits(called, text);
        }
        const double numbers[] = {raw.value, raw.least, raw.greatest};
        if (!is_fit || !finite(called, numbers, 3) || !finite(called, raw.area, 4)) {
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
            if (raw.width == 0 || raw.height == 0) {
                return wrong(called, "it has not as many pixels as its width and height say");
            }
            if (raw.width > most_side || raw.height > most_side) {
                return wrong(called, "it is " + std::to_string(raw.width) + " × " + std::to_string(raw.height) + " pixels, and " +
                                         std::to_string(most_side) + " to a side are allowed");
            }
            return count_bytes(std::uint64_t{raw.width} * raw.height * raw.channels) ? JDE_OK : JDE_BAD_ARGUMENT;
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
        if (!self.count(1, shape->point_count) || !self.fits(widget.id, text(shape->text))) {
            return JDE_BAD_ARGUMENT;
        }
        const std::size_t numbers = std::size_t{shape->point_count} * (widget.kind == JDE_WIDGET_SCENE ? 3 : 2);
        widget.shapes.push_back({shape->kind, std::vector<double>(shape->points, shape->points + numbers), text(shape->text), *shape});
        return self.check(widget.id, widget.kind, *shape, widget.shapes.back().points);
    }
    std::int32_t check(const std::string &widget, std::uint32_t kind, const jde_shape &shape, const std::vector<double> &points)
    {
        if (!finite(widget, points.data(), points.size()) || !finite(widget, shape.turned, 3)) {
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
