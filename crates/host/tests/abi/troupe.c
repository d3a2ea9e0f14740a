/*
 * A driver, a father and two children of his, written for ABI 1.0. Tests build them with the header of that version, with today's and
 * with one that has grown beyond it.
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
    JDE_PORT_COMMAND("speed", "How fast.", number, still, JDE_MS(500)),
    JDE_PORT_EXPORT("moved", "How far it went.", number),
};
static const jde_port child_ports[] = {
    JDE_PORT_MODULATION("pace", "How fast to go.", "m/s", number, pace, 0.0, 1.0, 0u),
    JDE_PORT_IMPORT("moves", "How far it went.", number, 0u),
    JDE_PORT_ACTUATOR("base", "What moves.", number, 0u),
};
static const jde_port father_ports[] = {
    JDE_PORT_CHILD_MODULATION(FIRST, "pace", "How fast the first goes.", number, 0u),
    JDE_PORT_EXPORT("seen", "The state of the second.", number),
};
static const jde_child children[] = {
    JDE_CHILD_MOTOR("first", "legs", "Goes.", 0u),
    JDE_CHILD_MOTOR("second", "legs", "Goes, too.", 0u),
};

typedef struct {
    const jde_host *host;
    double moved;
} one;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    one *self;
    /* What a plugin is handed is its own table, whatever the host makes of it. */
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
    one *self = instance;
    const double *speed = jde_get(self->host, context, SPEED, sizeof *speed, NULL);
    if (speed == NULL) {
        return jde_failed(self->host, context, "a command always has a value");
    }
    self->moved += *speed;
    return jde_put(self->host, context, MOVED, &self->moved, sizeof self->moved);
}

static int32_t is_ready(void *instance, jde_context *context, jde_precondition *answer)
{
    (void)instance;
    (void)context;
    answer->ready = 1u;
    answer->urgency = 2.0;
    return JDE_OK;
}

static int32_t go(void *instance, jde_context *context)
{
    one *self = instance;
    const double *wanted = jde_get(self->host, context, PACE, sizeof *wanted, NULL);
    int32_t code;
    if (wanted == NULL) {
        return jde_failed(self->host, context, "a modulation always has a value");
    }
    code = jde_put(self->host, context, BASE, wanted, sizeof *wanted);
    return code == JDE_REFUSED ? JDE_OK : code;
}

static int32_t lead(void *instance, jde_context *context)
{
    one *self = instance;
    /* Room that ends where the status of ABI 1.0 does. */
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

static int32_t arbitrate(void *instance, jde_context *context, const jde_level *level, jde_verdict *answer)
{
    one *self = instance;
    uint32_t index;
    const char *at = (const char *)level->candidates;
    for (index = 0u; index < level->candidate_count; index++) {
        const jde_candidate *candidate = (const jde_candidate *)(const void *)at;
        if (candidate->urgency != 2.0) {
            return jde_failed(self->host, context, "a candidate is not as it said");
        }
        at += candidate->size;
    }
    answer->child = SECOND;
    strcpy(answer->reason, "the second's turn");
    return JDE_OK;
}

/* What version 1.0 did not have: too fast a child says so before it starts. */
#ifdef JDE_ABILITY_INSPECT
static int32_t inspect(void *instance, jde_context *context, const jde_problems *problems)
{
    one *self = instance;
    const double *wanted = jde_get(self->host, context, PACE, sizeof *wanted, NULL);
    if (wanted == NULL) {
        return jde_failed(self->host, context, "a modulation always has a value");
    }
    return *wanted > 0.5 ? jde_problem(problems, JDE_PROBLEM_WRONG, PACE, "too fast: at most 0.5") : JDE_OK;
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
    {(uint32_t)sizeof(jde_schema), JDE_DRIVER, "base", "Moves.", JDE_MS(10), 0u, base_ports, NULL, JDE_COUNT(base_ports), 0u,
     create, free, NULL, NULL, drive, NULL, NULL, NULL},
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "child", "Goes.", JDE_MS(10), 0u, child_ports, NULL, JDE_COUNT(child_ports), 0u,
     create, free, NULL, is_ready, go, NULL, NULL, ABILITY},
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "father", "Leads.", JDE_MS(10), 0u, father_ports, children,
     JDE_COUNT(father_ports), JDE_COUNT(children), create, free, NULL, is_ready, lead, arbitrate, NULL, NULL},
};

JDE_PLUGIN("troupe", "1", "Three that move.", schemas);
