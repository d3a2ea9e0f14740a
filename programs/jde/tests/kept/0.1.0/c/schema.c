/* Drives straight ahead, slows down near an obstacle, and stops at a distance from it. */
#include <jde_types.h>

#include <stdlib.h>

/* Calls identify a port by its index in the table below. */
enum { LASER, DISTANCE, SPEED, BASE };

static const jde_float64 half_a_metre = {0.5};
static const jde_float64 slow = {0.4};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("laser", "The scan of the laser. A new scan triggers a check.", jde_laser_scan_type, JDE_TRIGGER),
    JDE_PORT_MODULATION("distance", "Distance to the obstacle at which the robot stops.", "m", jde_float64_type, half_a_metre, 0.0,
                        JDE_UNBOUNDED, 0u),
    JDE_PORT_MODULATION("speed", "Speed far from all obstacles.", "m/s", jde_float64_type, slow, 0.0, JDE_UNBOUNDED, 0u),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
};

/* Half the width of the area that must be free: that of the robot and a margin, m. */
static const double half_width = 0.35;

/* The memory of an instance. The host may create any number of instances. */
typedef struct {
    const jde_host *host;
} instance;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *cx)
{
    instance *self;
    (void)schema;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    self = calloc(1u, sizeof *self);
    if (self == NULL) {
        jde_failed(host, cx, "no memory");
        return NULL;
    }
    self->host = host;
    return self;
}

/* The precondition: it can act while there is a scan. */
static int32_t check(void *data, jde_context *cx, jde_precondition *result)
{
    const instance *self = data;
    result->ready = jde_get(self->host, cx, LASER, sizeof(jde_laser_scan), NULL) != NULL;
    return JDE_OK;
}

/* How much room is ahead, m. */
static double nearest_ahead(const jde_laser_scan *scan)
{
    double nearest = INFINITY;
    uint32_t beam;
    for (beam = 0u; beam < scan->ranges.length && beam < sizeof scan->ranges.items / sizeof scan->ranges.items[0]; beam++) {
        const double angle = (double)scan->angle_min + beam * (double)scan->angle_increment;
        double range = scan->ranges.items[beam];
        /* REP-117: minus infinity is something too close to measure. */
        if (range == -INFINITY) {
            range = fmax(scan->range_min, 1e-6);
        }
        if (range > 0.0 && range >= scan->range_min && range < scan->range_max && range * cos(angle) > 0.0 &&
            fabs(range * sin(angle)) <= half_width) {
            nearest = fmin(nearest, range * cos(angle));
        }
    }
    return nearest;
}

/* One iteration; called every period while it is WINNER. */
static int32_t iterate(void *data, jde_context *cx)
{
    const instance *self = data;
    const jde_laser_scan *scan = jde_get(self->host, cx, LASER, sizeof *scan, NULL);
    const jde_float64 *distance = jde_get(self->host, cx, DISTANCE, sizeof *distance, NULL);
    const jde_float64 *speed = jde_get(self->host, cx, SPEED, sizeof *speed, NULL);
    jde_twist twist = {0};
    int32_t code;
    if (scan == NULL || distance == NULL || speed == NULL) {
        return jde_failed(self->host, cx, "an input has no value");
    }
    /* One metre is enough to slow down from full speed. */
    twist.linear.x = speed->data * fmin(fmax(nearest_ahead(scan) - distance->data, 0.0), 1.0);
    code = jde_put(self->host, cx, BASE, &twist, sizeof twist);
    /* A refusal is no fault of this schema: the host counts and shows it. */
    return code == JDE_REFUSED ? JDE_OK : code;
}

static const jde_schema schemas[] = {
    {
        (uint32_t)sizeof(jde_schema), JDE_MOTOR, "creep-c",
        "Drives straight ahead, slows down near an obstacle, and stops at a distance from it.",
        JDE_MS(100), 0u,                        /* period, budget (0: the period) */
        ports, NULL, JDE_COUNT(ports), 0u,      /* ports, children */
        create, free, NULL, check, iterate,     /* create, destroy, awake, check, iterate */
        NULL, NULL, NULL,                       /* arbitrate, sleep, ability */
    },
};

JDE_PLUGIN("creep-c", "0.1.0", "Drives up to the obstacle ahead.", schemas);
