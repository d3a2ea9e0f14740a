/*
 * A perceptive schema in C with its own panel. It draws each kind of widget and handles the gestures on them.
 *
 *     cc -std=c99 -shared -fPIC -I include plugin/schema/examples/c/gauge.c -o libgauge.so
 */
#include "jde_types.h"

#include <stdlib.h>

enum { LEVEL };

static const jde_port ports[] = {
    JDE_PORT_EXPORT("level", "The level, from 0 to 1.", jde_float64_type),
};

/* The memory of an instance. */
typedef struct {
    const jde_host *host;
    double level;
    uint32_t on;
    uint32_t mode;
    double mark[2];
} gauge;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    gauge *self;
    (void)schema;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    self = (gauge *)calloc(1, sizeof *self);
    if (self == NULL) {
        jde_failed(host, context, "no memory");
        return NULL;
    }
    self->host = host;
    self->on = 1u;
    return self;
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t iterate(void *instance, jde_context *context)
{
    gauge *self = (gauge *)instance;
    jde_float64 level;
    if (self == NULL || context == NULL) {
        return JDE_BAD_ARGUMENT;
    }
    level.data = self->on ? self->level : 0.0;
    return jde_put(self->host, context, LEVEL, &level, sizeof level);
}

static int32_t draw(void *instance, jde_context *context, const jde_pen *pen)
{
    static const char *const modes[] = {"slow", "fast"};
    static const char *const cells[] = {"what", "value", "level", "half"};
    static const char *const axes[] = {"time, s", "level"};
    static const double curve[] = {0.0, 0.0, 1.0, 0.5, 2.0, 0.25};
    static const double square[] = {0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0};
    static const double arrow[] = {0.0, 0.0, 1.0, 2.0};
    static const double middle[] = {0.0, 0.0, 0.5};
    static const uint8_t pixels[] = {0, 128, 255, 64};
    const gauge *self = (const gauge *)instance;
    jde_shape box = jde_shape_of(JDE_SHAPE_BOX, 0x80ff8000u);
    if (self == NULL || context == NULL || pen == NULL || pen->size < sizeof *pen) {
        return JDE_BAD_ARGUMENT;
    }
    jde_add_text(pen, JDE_WORDS_HEADING, "Gauge");
    jde_add_value(pen, "level", self->level, "m");
    jde_begin_row(pen);
    jde_add_button(pen, "empty", "Empty", self->level > 0.0 ? 0u : JDE_DISABLED);
    jde_add_toggle(pen, "on", "On", self->on);
    jde_end(pen);
    jde_add_slider(pen, "level", "Level", self->level, 0.0, 1.0, "m");
    jde_add_choice(pen, "mode", "Mode", modes, JDE_COUNT(modes), self->mode);
    jde_add_table(pen, "table", cells, JDE_COUNT(cells), 2u);
    jde_add_image(pen, "image", pixels, 2u, 2u, 1u);
    jde_begin_plot(pen, "plot", "Level", axes);
    jde_draw_curve(pen, "level", curve, 3u, JDE_INK_ACCENT);
    jde_end(pen);
    jde_begin_group(pen, "more", "More", JDE_FOLDED);
    jde_begin_canvas(pen, "plane", JDE_FORWARD_UP | JDE_WANTS_CLICKS);
    jde_draw_points(pen, JDE_SHAPE_LINE, square, 4u, JDE_INK_GOOD, JDE_CLOSED);
    jde_draw_points(pen, JDE_SHAPE_ARROW, arrow, 2u, JDE_INK_BAD, 0u);
    jde_draw_round(pen, JDE_SHAPE_CIRCLE, self->mark, 0.25, JDE_INK_GOAL, JDE_FILLED);
    jde_draw_label(pen, self->mark, "mark", JDE_INK_GOAL);
    jde_draw_robot(pen, 1.0, 2.0, 0.5);
    jde_end(pen);
    jde_end(pen);
    jde_begin_scene(pen, "space", "base_link", 0u);
    box.points = middle;
    box.point_count = 1u;
    box.extent[0] = 1.0;
    box.extent[1] = 2.0;
    box.extent[2] = 3.0;
    box.turned[2] = 0.25;
    jde_draw(pen, &box);
    return jde_end(pen);
}

static int32_t touch(void *instance, jde_context *context, const jde_gesture *gesture)
{
    gauge *self = (gauge *)instance;
    if (self == NULL || context == NULL || gesture == NULL) {
        return JDE_BAD_ARGUMENT;
    }
    if (jde_touched(gesture, JDE_TOUCH_PRESSED, "empty")) {
        self->level = 0.0;
    } else if (jde_touched(gesture, JDE_TOUCH_TOGGLED, "on")) {
        self->on = gesture->number;
    } else if (jde_touched(gesture, JDE_TOUCH_MOVED, "level")) {
        self->level = gesture->value;
    } else if (jde_touched(gesture, JDE_TOUCH_CHOSE, "mode")) {
        self->mode = gesture->number;
    } else if (jde_touched(gesture, JDE_TOUCH_CLICKED, "plane")) {
        self->mark[0] = gesture->at[0];
        self->mark[1] = gesture->at[1];
        jde_say(self->host, context, JDE_INFO, gesture->by);
    } else if (jde_touched(gesture, JDE_TOUCH_KEY, "plane")) {
        return jde_failed(self->host, context, "keys have no effect");
    }
    return JDE_OK;
}

static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};

static const void *ability(const char *id)
{
    return id != NULL && strcmp(id, JDE_ABILITY_PANEL) == 0 ? &panel : NULL;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_PERCEPTIVE, "gauge", "Shows and exports a level that users set.", JDE_MS(100), 0u,
     ports, NULL, JDE_COUNT(ports), 0u, create, destroy, NULL, NULL, iterate, NULL, NULL, ability},
};

JDE_PLUGIN("gauge", "0.1.0", "A level that users set.", schemas);
