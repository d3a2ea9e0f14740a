/*
 * A driver, a father and its two children, written for ABI 1.0. Tests build them with the header of that version, with the current
 * header, and with a header of a future version.
 */
#include "jde.h"

#include <stdlib.h>

enum { SPEED, MOVED };
enum { PACE, MOVES, BASE };
enum { FIRST_PACE, SEEN };
enum { FIRST, SECOND };

static const jde_field number_fields[] = {
    {(uint32_t)sizeof(jde_field), JDE_F64, JDE_ONE, 1u, "data", "The value.", "", 0u, 0u, NULL}};
static const jde_type number = {
    (uint32_t)sizeof(jde_type), 1u, "std_msgs/msg/Float64", "A number by itself.", 8u, 8u, number_fields};

static const double still = 0.0;
static const double pace = 0.25;

static const jde_port base_ports[] = {
    JDE_PORT_COMMAND("speed", "The speed.", number, still, JDE_MS(500)),
    JDE_PORT_EXPORT("moved", "The distance driven.", number),
};
static const jde_port child_ports[] = {
    JDE_PORT_MODULATION("pace", "The speed to command.", "m/s", number, pace, 0.0, 1.0, 0u),
    JDE_PORT_IMPORT("moves", "The distance driven.", number, 0u),
    JDE_PORT_ACTUATOR("base", "The base.", number, 0u),
};
static const jde_port father_ports[] = {
    JDE_PORT_CHILD_MODULATION(FIRST, "pace", "The speed of the first child.", number, 0u),
    JDE_PORT_EXPORT("seen", "The state of the second child.", number),
};
static const jde_child children[] = {
    JDE_CHILD_MOTOR("first", "legs", "Drives.", 0u),
    JDE_CHILD_MOTOR("second", "legs", "Drives, too.", 0u),
};

typedef struct {
    const jde_host *host;
    double moved;
} schema_instance;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    schema_instance *self;
    /* The host passes the plugin's own table. */
    if (!jde_host_fits(host) || schema->size != sizeof(jde_schema)) {
        return NULL;
    }
    self = calloc(1u, sizeof *self);
    if (self == NULL) {
        jde_failed(host, context, "no memory");
        return NULL;
    }
    self->host = host;
    return self;
}

static int32_t drive(void *instance, jde_context *context)
{
    schema_instance *self = instance;
    const double *speed = jde_get(self->host, context, SPEED, sizeof *speed, NULL);
    if (speed == NULL) {
        return jde_failed(self->host, context, "a command always has a value");
    }
    self->moved += *speed;
    return jde_put(self->host, context, MOVED, &self->moved, sizeof self->moved);
}

static int32_t is_ready(void *instance, jde_context *context, jde_precondition *result)
{
    (void)instance;
    (void)context;
    result->ready = 1u;
    result->urgency = 2.0;
    return JDE_OK;
}

static int32_t iterate_child(void *instance, jde_context *context)
{
    schema_instance *self = instance;
    const double *speed = jde_get(self->host, context, PACE, sizeof *speed, NULL);
    int32_t code;
    if (speed == NULL) {
        return jde_failed(self->host, context, "a modulation always has a value");
    }
    code = jde_put(self->host, context, BASE, speed, sizeof *speed);
    return code == JDE_REFUSED ? JDE_OK : code;
}

static int32_t iterate_father(void *instance, jde_context *context)
{
    schema_instance *self = instance;
    /* Memory of the size of a status in ABI 1.0, followed by a guard value. */
    struct {
        uint32_t status[4];
        uint32_t canary;
    } room = {{16u, 77u, 77u, 77u}, 77u};
    double seen;
    double faster = 0.5;
    self->host->wake(context, FIRST);
    self->host->wake(context, SECOND);
    jde_put(self->host, context, FIRST_PACE, &faster, sizeof faster);
    if (self->host->child(context, SECOND, (jde_child_status *)(void *)room.status) != JDE_OK) {
        return jde_failed(self->host, context, "the second has no status");
    }
    if (room.canary != 77u || room.status[0] != 16u) {
        return jde_failed(self->host, context, "the host wrote past the status");
    }
    seen = room.status[1];
    return jde_put(self->host, context, SEEN, &seen, sizeof seen);
}

static int32_t arbitrate(void *instance, jde_context *context, const jde_level *level, jde_verdict *result)
{
    schema_instance *self = instance;
    uint32_t index;
    const char *at = (const char *)level->candidates;
    for (index = 0u; index < level->candidate_count; index++) {
        const jde_candidate *candidate = (const jde_candidate *)(const void *)at;
        if (candidate->urgency != 2.0) {
            return jde_failed(self->host, context, "the urgency of a candidate is wrong");
        }
        at += candidate->size;
    }
    result->child = SECOND;
    strcpy(result->reason, "the second's turn");
    return JDE_OK;
}

/* An ability that version 1.0 does not have: a child whose speed is too high reports this before the start. */
#ifdef JDE_ABILITY_INSPECT
static int32_t inspect(void *instance, jde_context *context, const jde_problems *problems)
{
    schema_instance *self = instance;
    const double *speed = jde_get(self->host, context, PACE, sizeof *speed, NULL);
    if (speed == NULL) {
        return jde_failed(self->host, context, "a modulation always has a value");
    }
    return *speed > 0.5 ? jde_problem(problems, JDE_PROBLEM_WRONG, PACE, "too fast: at most 0.5") : JDE_OK;
}

static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};

static const void *ability(const char *id)
{
    return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL;
}
#define ABILITY ability
#else
#define ABILITY NULL
#endif

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_DRIVER, "base", "Drives.", JDE_MS(10), 0u, base_ports, NULL, JDE_COUNT(base_ports), 0u,
     create, free, NULL, NULL, drive, NULL, NULL, NULL},
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "child", "Drives.", JDE_MS(10), 0u, child_ports, NULL, JDE_COUNT(child_ports), 0u,
     create, free, NULL, is_ready, iterate_child, NULL, NULL, ABILITY},
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "father", "Wakes its children.", JDE_MS(10), 0u, father_ports, children,
     JDE_COUNT(father_ports), JDE_COUNT(children), create, free, NULL, is_ready, iterate_father, arbitrate, NULL, NULL},
};

JDE_PLUGIN("versioned", "1", "A driver, a father and a child.", schemas);
