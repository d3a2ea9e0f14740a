/*
 * The rest of this file is for authors in C and C++: macros that fill tables, and functions that call the host.
 */

#if defined(__GNUC__)
#define JDE_VISIBLE __attribute__((visibility("default")))
#else
#define JDE_VISIBLE
#endif

/** The number of elements of an array. */
#define JDE_COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
/** Milliseconds in ns. */
#define JDE_MS(number) ((uint64_t)(number) * UINT64_C(1000000))
/** No least or greatest value. */
#define JDE_UNBOUNDED ((double)NAN)

/** Exports the plugin: its name, its version, one sentence, and its array of jde_schema. Once in a library. */
#define JDE_PLUGIN(name, version, doc, schemas) JDE_PLUGIN_OF(0u, name, version, doc, schemas)
/** The same for a plugin in C++ all of whose functions run within jde_guarded. */
#define JDE_PLUGIN_GUARDED(name, version, doc, schemas) JDE_PLUGIN_OF(JDE_PLUGIN_CATCHES, name, version, doc, schemas)
/** The same, with its flags. */
#define JDE_PLUGIN_OF(flags, name, version, doc, schemas)                                                   \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), flags, name, version, doc,   \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port of a kind. Fields that a kind does not use are NULL, JDE_UNBOUNDED or 0. */
#define JDE_PORT(kind, name, doc, unit, type, initial, min, max, validity_ns, flags, child, choices, choice_count)      \
    {(uint32_t)sizeof(jde_port), kind, name, doc, unit, &(type), initial, min, max, validity_ns, flags, child, choices, \
     choice_count, 0u, 0}
/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    JDE_PORT(JDE_IMPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    JDE_PORT(JDE_EXPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u, NULL, 0u)
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    JDE_PORT(JDE_MODULATION, name, doc, unit, type, &(initial), min, max, 0u, flags, 0u, NULL, 0u)
/** A jde_port that is a choice. `type` is a whole number, and `choices` is an array of the names of its values from 0 on. */
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
/** A jde_child that does not compete. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Returns whether this header supports a host. Call it in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= offsetof(jde_host, retract) && host->abi_major == JDE_ABI_MAJOR;
}

/** Whether a host has a function of a later minor version: `if (JDE_HOST_HAS(host, retract)) host->retract(...)`. */
#define JDE_HOST_HAS(host, function) \
    ((host)->size >= offsetof(jde_host, function) + sizeof((host)->function) && (host)->function != NULL)

/** Returns the value of an import, modulation or command of `bytes` bytes, or NULL if there is none. `sample` may be NULL. */
static inline const void *jde_get(const jde_host *host, jde_context *context, uint32_t port, size_t bytes,
                                  jde_sample *sample)
{
    jde_sample local;
    jde_sample *result = sample != NULL ? sample : &local;
    if (host->read(context, port, result) != JDE_OK || result->bytes != bytes) {
        return NULL;
    }
    return result->data;
}

/** Writes `bytes` bytes to an export, actuator or child's modulation. Returns the codes of jde_host.publish. */
static inline int32_t jde_put(const jde_host *host, jde_context *context, uint32_t port, const void *value,
                              size_t bytes)
{
    void *buffer = NULL;
    int32_t code = host->loan(context, port, &buffer);
    if (code != JDE_OK) {
        return code;
    }
    memcpy(buffer, value, bytes);
    return host->publish(context, port, 0u);
}

/** Writes a log message. */
static inline void jde_say(const jde_host *host, jde_context *context, uint32_t level, const char *text)
{
    host->log(context, level, text, strlen(text));
}

/** States the reason for a failure: `return jde_failed(host, context, "the cable is loose");`. */
static inline int32_t jde_failed(const jde_host *host, jde_context *context, const char *reason)
{
    host->fail(context, reason, strlen(reason));
    return JDE_FAILED;
}

/*
 * C++. An exception that leaves a function of the plugin ends the application: the host cannot catch an exception of
 * another language. Run the body of each function within jde_guarded:
 *
 *     static int32_t iterate(void *instance, jde_context *context)
 *     {
 *         my_schema *self = static_cast<my_schema *>(instance);
 *         return jde_guarded(self->host, context, JDE_PANICKED, [&]() -> int32_t { return self->iterate(context); });
 *     }
 *
 * and export the plugin with JDE_PLUGIN_GUARDED. Run any other C++ plugin with `isolate = "process"`: an exception then
 * ends only that process, and the schema is Faulted.
 */
#ifdef __cplusplus
} /* extern "C" */

#include <exception>

/** Returns the result of `body`. If it throws, passes the reason to jde_host.fail and returns `fallback`. Never throws. */
template <typename Result, typename Body>
static inline Result jde_guarded(const jde_host *host, jde_context *context, Result fallback, Body body) noexcept
{
    try {
        return body();
    } catch (const std::exception &thrown) {
        host->fail(context, thrown.what(), strlen(thrown.what()));
    } catch (...) {
        static const char reason[] = "it threw something that is not a std::exception";
        host->fail(context, reason, sizeof reason - 1u);
    }
    return fallback;
}

extern "C" {
#endif

/*
 * Reloading. A schema that passes its memory to its next build returns its jde_state from jde_schema.ability:
 *
 *     static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL; }
 */

/** Appends bytes to the saved memory. */
static inline int32_t jde_save(const jde_saver *saver, const void *bytes, size_t length)
{
    return saver->write(saver->saving, bytes, (uint64_t)length);
}

/*
 * Inspection. A schema that inspects what its modulations name before the application starts returns its jde_inspect
 * from jde_schema.ability:
 *
 *     static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL; }
 */

/** Adds a problem of the modulation `port`. `kind` is JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE. */
static inline int32_t jde_problem(const jde_problems *problems, uint32_t kind, uint32_t port, const char *text)
{
    return problems->add(problems->found, kind, port, text, (uint64_t)strlen(text));
}

/*
 * Guards. A perceptive schema that judges commands before they take effect returns its jde_guard from
 * jde_schema.ability:
 *
 *     static const jde_guard guard = {(uint32_t)sizeof(jde_guard), 0u, &jde_twist_type, judge};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_GUARD) == 0 ? &guard : NULL; }
 */

/** Accepts the command. */
static inline int32_t jde_accept(jde_judgement *out)
{
    out->accepted = 1u;
    return JDE_OK;
}

/** Refuses the command for this reason, which is cut after 127 bytes. */
static inline int32_t jde_refuse(jde_judgement *out, const char *reason)
{
    size_t length = strlen(reason);
    if (length >= sizeof out->reason)
        length = sizeof out->reason - 1u;
    memcpy(out->reason, reason, length);
    out->reason[length] = '\0';
    out->accepted = 0u;
    return JDE_OK;
}

/**
 * Lets this command of so many bytes take effect instead of the judged one, for this reason. A host before minor version 8
 * refuses the command.
 */
static inline int32_t jde_limit(jde_judgement *out, const void *command, size_t bytes, const char *reason)
{
    jde_refuse(out, reason);
    if (out->size >= (uint32_t)sizeof(jde_judgement)) {
        memcpy(out->command, command, bytes);
        out->accepted = JDE_LIMITED;
    }
    return JDE_OK;
}

/*
 * Panels. A schema with a panel returns its jde_panel from jde_schema.ability:
 *
 *     static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_PANEL) == 0 ? &panel : NULL; }
 *
 * The functions below return the codes of the functions of jde_pen. The plugin may ignore them: the panel shows any mistake.
 */

/** Returns a widget of a kind. All other fields are 0. */
static inline jde_widget jde_widget_of(uint32_t kind)
{
    jde_widget widget;
    memset(&widget, 0, sizeof widget);
    widget.size = (uint32_t)sizeof widget;
    widget.kind = kind;
    return widget;
}

/** Returns a shape of a kind and a color. All other fields are 0. */
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

/** Closes the row, group, plot, canvas or scene that was opened last. */
static inline int32_t jde_end(const jde_pen *pen)
{
    return pen->end(pen->drawing);
}

/** Adds a text in the style `words`. */
static inline int32_t jde_add_text(const jde_pen *pen, uint32_t words, const char *text)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TEXT);
    widget.label = text;
    widget.number = words;
    return jde_add(pen, &widget);
}

/** Adds a number with its name and unit. */
static inline int32_t jde_add_value(const jde_pen *pen, const char *label, double value, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_VALUE);
    widget.label = label;
    widget.value = value;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** Adds a button. `flags` is 0 or JDE_DISABLED. */
static inline int32_t jde_add_button(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_BUTTON);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Adds a toggle, which is on (1) or off (0). */
static inline int32_t jde_add_toggle(const jde_pen *pen, const char *id, const char *label, uint32_t on)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TOGGLE);
    widget.id = id;
    widget.label = label;
    widget.number = on;
    return jde_add(pen, &widget);
}

/** Adds a slider. */
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

/** Adds a choice among texts. `chosen` is the index of the present one. */
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

/** Adds a table. `texts` are the headings of the columns and then the cells row by row, `count` in all. */
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

/** Adds an image. `pixels` are rows from the top, without gaps. */
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

/** Opens a row of widgets, up to jde_end. */
static inline int32_t jde_begin_row(const jde_pen *pen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_ROW);
    return jde_add(pen, &widget);
}

/** Opens a group of widgets below a heading, up to jde_end. `flags` is 0 or JDE_FOLDED. */
static inline int32_t jde_begin_group(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_GROUP);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Opens a plot, up to jde_end. `axes` are the labels of the horizontal and the vertical axis. */
static inline int32_t jde_begin_plot(const jde_pen *pen, const char *id, const char *label, const char *const *axes)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_PLOT);
    widget.id = id;
    widget.label = label;
    widget.texts = axes;
    widget.text_count = 2u;
    return jde_add(pen, &widget);
}

/** Opens a plane in metres, up to jde_end. */
static inline int32_t jde_begin_canvas(const jde_pen *pen, const char *id, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CANVAS);
    widget.id = id;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Opens a space in metres in a frame of REP-105, up to jde_end. */
static inline int32_t jde_begin_scene(const jde_pen *pen, const char *id, const char *frame, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SCENE);
    widget.id = id;
    widget.label = frame;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Draws a shape of `count` points: JDE_SHAPE_LINE, _POINTS, _ARROW, _POLYGON or _MESH. */
static inline int32_t jde_draw_points(const jde_pen *pen, uint32_t kind, const double *points, uint32_t count,
                                      uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = points;
    shape.point_count = count;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** Draws a text at a point. */
static inline int32_t jde_draw_label(const jde_pen *pen, const double *at, const char *text, uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LABEL, color);
    shape.points = at;
    shape.point_count = 1u;
    shape.text = text;
    return jde_draw(pen, &shape);
}

/** Draws a curve of a plot, with its name. */
static inline int32_t jde_draw_curve(const jde_pen *pen, const char *name, const double *points, uint32_t count,
                                     uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LINE, color);
    shape.points = points;
    shape.point_count = count;
    shape.text = name;
    return jde_draw(pen, &shape);
}

/** Draws JDE_SHAPE_CIRCLE or JDE_SHAPE_SPHERE about a point. */
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

/** Draws the outline of the robot that the application drives. */
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

/** Returns whether a gesture has this kind and is on this widget. */
static inline int jde_touched(const jde_gesture *gesture, uint32_t kind, const char *id)
{
    return gesture->kind == kind && gesture->widget != NULL && strcmp(gesture->widget, id) == 0;
}
