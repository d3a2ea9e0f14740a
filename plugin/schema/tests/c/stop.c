/*
 * Brakes while an obstacle stands in a very close area ahead: the same as `Stop` in the Rust tests, written with the
 * headers alone.
 */
#include "jde_types.h"

#include <stdlib.h>

enum { LASER, AHEAD, HALF_WIDTH, BASE };

static const jde_float64 ahead = {0.6};
static const jde_float64 half_width = {0.3};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("laser", "What the laser ahead sees.", jde_laser_scan_type, JDE_TRIGGER),
    JDE_PORT_MODULATION("ahead", "How far ahead the watched area reaches.", "m", jde_float64_type, ahead, 0.0,
                        JDE_UNBOUNDED, 0u),
    JDE_PORT_MODULATION("half_width", "Half the width of the watched area.", "m", jde_float64_type, half_width, 0.0,
                        JDE_UNBOUNDED, 0u),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
};

typedef struct {
    const jde_host *host;
} stop;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    stop *self;
    (void)schema;
    if (!jde_host_fits(host) || context == NULL) {
        return NULL;
    }
    self = malloc(sizeof *self);
    if (self == NULL) {
        jde_failed(host, context, "no memory");
        return NULL;
    }
    self->host = host;
    return self;
}

static void destroy(void *instance)
{
    free(instance);
}

static double number(const stop *self, jde_context *context, uint32_t port, double fallback)
{
    const jde_float64 *value = jde_get(self->host, context, port, sizeof *value, NULL);
    return value != NULL ? value->data : fallback;
}

static int32_t check(void *instance, jde_context *context, jde_precondition *result)
{
    const stop *self = instance;
    const jde_laser_scan *laser;
    double reach, side;
    uint32_t beam, beams;
    if (self == NULL || context == NULL || result == NULL) {
        return JDE_BAD_ARGUMENT;
    }
    result->ready = 0u;
    result->urgency = 0.0;
    laser = jde_get(self->host, context, LASER, sizeof *laser, NULL);
    if (laser == NULL) {
        return JDE_OK;
    }
    reach = number(self, context, AHEAD, ahead.data);
    side = number(self, context, HALF_WIDTH, half_width.data);
    beams = laser->ranges.length < 1088u ? laser->ranges.length : 1088u;
    for (beam = 0u; beam < beams; beam++) {
        double range = laser->ranges.items[beam];
        double angle = (double)laser->angle_min + beam * (double)laser->angle_increment;
        /* REP-117: minus infinity is something too close to measure. */
        if (range == -INFINITY) {
            range = laser->range_min;
        }
        if (!(range >= laser->range_min && range <= laser->range_max)) {
            continue;
        }
        if (range * cos(angle) > 0.0 && range * cos(angle) <= reach && fabs(range * sin(angle)) <= side) {
            result->ready = 1u;
        }
    }
    return JDE_OK;
}

static int32_t iterate(void *instance, jde_context *context)
{
    static const jde_twist still;
    const stop *self = instance;
    int32_t code;
    if (self == NULL || context == NULL) {
        return JDE_BAD_ARGUMENT;
    }
    code = jde_put(self->host, context, BASE, &still, sizeof still);
    /* A refusal is no fault of this schema: the host counts and shows it. */
    if (code != JDE_OK && code != JDE_REFUSED) {
        return jde_failed(self->host, context, "the base cannot be commanded");
    }
    return JDE_OK;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "stop", "Brakes the base while an obstacle stands in a very close area ahead.",
     JDE_MS(200), 0u, ports, NULL, JDE_COUNT(ports), 0u, create, destroy, NULL, check, iterate, NULL, NULL, NULL},
};

JDE_PLUGIN("stop", "0.1.0", "Brakes before obstacles.", schemas);
