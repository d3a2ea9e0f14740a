/*
 * What follows is for authors in C and C++: macros that fill tables, and functions that use the host's.
 */

#if defined(__GNUC__)
#define JDE_VISIBLE __attribute__((visibility("default")))
#else
#define JDE_VISIBLE
#endif

/** How many elements an array has. */
#define JDE_COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
/** Milliseconds in ns. */
#define JDE_MS(number) ((uint64_t)(number) * UINT64_C(1000000))
/** No least or greatest value. */
#define JDE_UNBOUNDED ((double)NAN)

/** Exports the plugin: its name, its version, one sentence, and its array of jde_schema. Once in a library. */
#define JDE_PLUGIN(name, version, doc, schemas) JDE_PLUGIN_OF(0u, name, version, doc, schemas)
/** The same for a plugin in C++ whose functions all do their work within jde_guarded. */
#define JDE_PLUGIN_GUARDED(name, version, doc, schemas) JDE_PLUGIN_OF(JDE_PLUGIN_CATCHES, name, version, doc, schemas)
/** The same, with its flags. */
#define JDE_PLUGIN_OF(flags, name, version, doc, schemas)                                                   \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), flags, name, version, doc,   \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port of a kind; what a kind does not have is NULL, JDE_UNBOUNDED or 0. */
#define JDE_PORT(kind, name, doc, unit, type, initial, min, max, validity_ns, flags, child, choices, choice_count)      \
    {(uint32_t)sizeof(jde_port), kind, name, doc, unit, &(type), initial, min, max, validity_ns, flags, child, choices, \
     choice_count, 0u}
/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    JDE_PORT(JDE_IMPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    JDE_PORT(JDE_EXPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u, NULL, 0u)
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    JDE_PORT(JDE_MODULATION, name, doc, unit, type, &(initial), min, max, 0u, flags, 0u, NULL, 0u)
/** A jde_port that is one of several: `type` is a plain whole number, `choices` an array of the names of its values from 0 on. */
#define JDE_PORT_CHOICE(name, doc, type, initial, choices)                                                                      \
    JDE_PORT(JDE_MODULATION, name, doc, "", type, &(initial), 0.0, (double)(JDE_COUNT(choices) - 1u), 0u, 0u, 0u, choices, \
             JDE_COUNT(choices))
/** A jde_port of a driver that reaches an actuator; `neutral` is a static const value that stops it. */
#define JDE_PORT_COMMAND(name, doc, type, neutral, validity_ns) \
    JDE_PORT(JDE_COMMAND, name, doc, "", type, &(neutral), JDE_UNBOUNDED, JDE_UNBOUNDED, validity_ns, 0u, 0u, NULL, 0u)
/** A jde_port that writes a driver's command. */
#define JDE_PORT_ACTUATOR(name, doc, type, flags) \
    JDE_PORT(JDE_ACTUATOR, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes the modulation `name` of the child of this number. */
#define JDE_PORT_CHILD_MODULATION(child, name, doc, type, flags) \
    JDE_PORT(JDE_CHILD_MODULATION, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, child, NULL, 0u)

/** A jde_child that competes in a group. */
#define JDE_CHILD_MOTOR(name, group, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_MOTOR, name, group, doc, flags, 0u}
/** A jde_child that helps. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Whether an instance can be made for a host: to be asked in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= offsetof(jde_host, retract) && host->abi_major == JDE_ABI_MAJOR;
}

/** Whether a host has a function that a later minor version brought: `if (JDE_HOST_HAS(host, retract)) host->retract(...)`. */
#define JDE_HOST_HAS(host, function) \
    ((host)->size >= offsetof(jde_host, function) + sizeof((host)->function) && (host)->function != NULL)

/** The value of an import, modulation or command of `bytes` bytes; NULL if there is none. `sample` may be NULL. */
static inline const void *jde_get(const jde_host *host, jde_context *context, uint32_t port, size_t bytes,
                                  jde_sample *sample)
{
    jde_sample own;
    jde_sample *seen = sample != NULL ? sample : &own;
    if (host->read(context, port, seen) != JDE_OK || seen->bytes != bytes) {
        return NULL;
    }
    return seen->data;
}

/** Writes `bytes` bytes to an export, actuator or child's modulation; answers as jde_host.publish does. */
static inline int32_t jde_put(const jde_host *host, jde_context *context, uint32_t port, const void *value,
                              size_t bytes)
{
    void *room = NULL;
    int32_t code = host->loan(context, port, &room);
    if (code != JDE_OK) {
        return code;
    }
    memcpy(room, value, bytes);
    return host->publish(context, port, 0u);
}

/** Says something to whoever listens. */
static inline void jde_say(const jde_host *host, jde_context *context, uint32_t level, const char *text)
{
    host->log(context, level, text, strlen(text));
}

/** Gives the reason for a failure: `return jde_failed(host, context, "the cable is loose");`. */
static inline int32_t jde_failed(const jde_host *host, jde_context *context, const char *reason)
{
    host->fail(context, reason, strlen(reason));
    return JDE_FAILED;
}

/*
 * C++. An exception that leaves a function of the plugin ends the application: what unwinds another language's frames cannot be caught
 * in the host, only here. Do the work of each function within jde_guarded:
 *
 *     static int32_t iterate(void *instance, jde_context *context)
 *     {
 *         mine *self = static_cast<mine *>(instance);
 *         return jde_guarded(self->host, context, JDE_PANICKED, [&]() -> int32_t { return self->iterate(context); });
 *     }
 *
 * and export the plugin by JDE_PLUGIN_GUARDED. One that is not written so runs with `isolate = "process"`: an exception then ends its own process, and the schema is Faulted.
 */
#ifdef __cplusplus
} /* extern "C" */

#include <exception>

/** Answers as `body` does; with `otherwise` if that throws, for a reason given to jde_host.fail. No exception leaves it. */
template <typename Answer, typename Body>
static inline Answer jde_guarded(const jde_host *host, jde_context *context, Answer otherwise, Body body) noexcept
{
    try {
        return body();
    } catch (const std::exception &thrown) {
        host->fail(context, thrown.what(), strlen(thrown.what()));
    } catch (...) {
        static const char reason[] = "it threw what is no std::exception";
        host->fail(context, reason, sizeof reason - 1u);
    }
    return otherwise;
}

extern "C" {
#endif

/*
 * Reloading. A schema that hands what it remembers to its next build gives its jde_state from jde_schema.ability:
 *
 *     static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL; }
 */

/** Saves bytes behind those before. */
static inline int32_t jde_save(const jde_saver *saver, const void *bytes, size_t length)
{
    return saver->write(saver->saving, bytes, (uint64_t)length);
}

/*
 * Inspection. A schema that looks at what its modulations name before anything starts gives its jde_inspect from
 * jde_schema.ability:
 *
 *     static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL; }
 */

/** Adds a problem of the modulation `port`: JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE, and what to do. */
static inline int32_t jde_problem(const jde_problems *problems, uint32_t kind, uint32_t port, const char *text)
{
    return problems->add(problems->found, kind, port, text, (uint64_t)strlen(text));
}

/*
 * Panels. A schema gives its jde_panel from jde_schema.ability:
 *
 *     static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_PANEL) == 0 ? &panel : NULL; }
 *
 * The functions below answer as those of jde_pen do. Whoever draws need not look: what is wrong is shown in the panel.
 */

/** A widget of a kind, all else 0. */
static inline jde_widget jde_widget_of(uint32_t kind)
{
    jde_widget widget;
    memset(&widget, 0, sizeof widget);
    widget.size = (uint32_t)sizeof widget;
    widget.kind = kind;
    return widget;
}

/** A shape of a kind in a color, all else 0. */
static inline jde_shape jde_shape_of(uint32_t kind, uint32_t color)
{
    jde_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.size = (uint32_t)sizeof shape;
    shape.kind = kind;
    shape.color = color;
    return shape;
}

/** Adds a widget. */
static inline int32_t jde_add(const jde_pen *pen, const jde_widget *widget)
{
    return pen->add(pen->drawing, widget);
}

/** Adds a shape. */
static inline int32_t jde_draw(const jde_pen *pen, const jde_shape *shape)
{
    return pen->shape(pen->drawing, shape);
}

/** Ends the row, group, plot, canvas or scene that was begun last. */
static inline int32_t jde_end(const jde_pen *pen)
{
    return pen->end(pen->drawing);
}

/** A text that matters as `words` say. */
static inline int32_t jde_add_text(const jde_pen *pen, uint32_t words, const char *text)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TEXT);
    widget.label = text;
    widget.number = words;
    return jde_add(pen, &widget);
}

/** A number with its name and unit. */
static inline int32_t jde_add_value(const jde_pen *pen, const char *label, double value, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_VALUE);
    widget.label = label;
    widget.value = value;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** Something to press; `flags` are 0 or JDE_DISABLED. */
static inline int32_t jde_add_button(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_BUTTON);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Something that is on (1) or off (0). */
static inline int32_t jde_add_toggle(const jde_pen *pen, const char *id, const char *label, uint32_t on)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TOGGLE);
    widget.id = id;
    widget.label = label;
    widget.number = on;
    return jde_add(pen, &widget);
}

/** A number to move. */
static inline int32_t jde_add_slider(const jde_pen *pen, const char *id, const char *label, double value, double least,
                                     double greatest, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SLIDER);
    widget.id = id;
    widget.label = label;
    widget.value = value;
    widget.least = least;
    widget.greatest = greatest;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** One of several texts; `chosen` is the place of the present one. */
static inline int32_t jde_add_choice(const jde_pen *pen, const char *id, const char *label, const char *const *texts,
                                     uint32_t count, uint32_t chosen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CHOICE);
    widget.id = id;
    widget.label = label;
    widget.texts = texts;
    widget.text_count = count;
    widget.number = chosen;
    return jde_add(pen, &widget);
}

/** Texts in rows below the heads of `columns`: heads first, `count` in all. */
static inline int32_t jde_add_table(const jde_pen *pen, const char *id, const char *const *texts, uint32_t count,
                                    uint32_t columns)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TABLE);
    widget.id = id;
    widget.texts = texts;
    widget.text_count = count;
    widget.number = columns;
    return jde_add(pen, &widget);
}

/** Pixels in rows from the top, without gaps. */
static inline int32_t jde_add_image(const jde_pen *pen, const char *id, const uint8_t *pixels, uint32_t width,
                                    uint32_t height, uint32_t channels)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_IMAGE);
    widget.id = id;
    widget.pixels = pixels;
    widget.width = width;
    widget.height = height;
    widget.channels = channels;
    return jde_add(pen, &widget);
}

/** Widgets beside each other, up to jde_end. */
static inline int32_t jde_begin_row(const jde_pen *pen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_ROW);
    return jde_add(pen, &widget);
}

/** Widgets below a heading, up to jde_end; `flags` are 0 or JDE_FOLDED. */
static inline int32_t jde_begin_group(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_GROUP);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Curves, up to jde_end; `axes` are two texts, across and up. */
static inline int32_t jde_begin_plot(const jde_pen *pen, const char *id, const char *label, const char *const *axes)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_PLOT);
    widget.id = id;
    widget.label = label;
    widget.texts = axes;
    widget.text_count = 2u;
    return jde_add(pen, &widget);
}

/** A plane in metres, up to jde_end. */
static inline int32_t jde_begin_canvas(const jde_pen *pen, const char *id, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CANVAS);
    widget.id = id;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** A space in metres in a frame of REP-105, up to jde_end. */
static inline int32_t jde_begin_scene(const jde_pen *pen, const char *id, const char *frame, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SCENE);
    widget.id = id;
    widget.label = frame;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** A shape of `count` points in a color: JDE_SHAPE_LINE, JDE_SHAPE_POINTS, JDE_SHAPE_ARROW, JDE_SHAPE_POLYGON or JDE_SHAPE_MESH. */
static inline int32_t jde_draw_points(const jde_pen *pen, uint32_t kind, const double *points, uint32_t count,
                                      uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = points;
    shape.point_count = count;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** A text at a point. */
static inline int32_t jde_draw_label(const jde_pen *pen, const double *at, const char *text, uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LABEL, color);
    shape.points = at;
    shape.point_count = 1u;
    shape.text = text;
    return jde_draw(pen, &shape);
}

/** A curve of a plot, with its name. */
static inline int32_t jde_draw_curve(const jde_pen *pen, const char *name, const double *points, uint32_t count,
                                     uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LINE, color);
    shape.points = points;
    shape.point_count = count;
    shape.text = name;
    return jde_draw(pen, &shape);
}

/** JDE_SHAPE_CIRCLE or JDE_SHAPE_SPHERE about a point. */
static inline int32_t jde_draw_round(const jde_pen *pen, uint32_t kind, const double *center, double radius,
                                     uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = center;
    shape.point_count = 1u;
    shape.radius = radius;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** The outline of the robot that the application drives. */
static inline int32_t jde_draw_robot(const jde_pen *pen, double x, double y, double theta)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_ROBOT, JDE_INK_PLAIN);
    double at[2];
    at[0] = x;
    at[1] = y;
    shape.points = at;
    shape.point_count = 1u;
    shape.turned[2] = theta;
    return jde_draw(pen, &shape);
}

/** Whether a gesture is of a kind, on a widget. */
static inline int jde_touched(const jde_gesture *gesture, uint32_t kind, const char *id)
{
    return gesture->kind == kind && gesture->widget != NULL && strcmp(gesture->widget, id) == 0;
}
