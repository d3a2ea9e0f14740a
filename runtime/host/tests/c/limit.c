/*
 * A guard in C: it accepts speeds up to its limit, 0.2 m/s.
 */
#include "jde_types.h"

#include <stdio.h>
#include <stdlib.h>

enum { LIMIT };

static const jde_port ports[] = {
    JDE_PORT_EXPORT("limit", "The greatest speed that it accepts.", jde_float64_type),
};

typedef struct {
    const jde_host *host;
} limiter;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    limiter *self;
    (void)schema;
    (void)context;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    self = calloc(1u, sizeof *self);
    if (self != NULL) {
        self->host = host;
    }
    return self;
}

static int32_t iterate(void *instance, jde_context *context)
{
    const limiter *self = instance;
    const jde_float64 limit = {0.2};
    return jde_put(self->host, context, LIMIT, &limit, sizeof limit);
}

static int32_t judge(const void *state, uint64_t age_ns, const void *command, jde_judgement *out)
{
    const jde_float64 *limit = state;
    const jde_twist *twist = command;
    char reason[128];
    (void)age_ns;
    if (twist->linear.x <= limit->data) {
        return jde_accept(out);
    }
    snprintf(reason, sizeof reason, "at most %.1f m/s", limit->data);
    return jde_refuse(out, reason);
}

static const jde_guard guard = {(uint32_t)sizeof(jde_guard), LIMIT, &jde_twist_type, judge};

static const void *ability(const char *id)
{
    return strcmp(id, JDE_ABILITY_GUARD) == 0 ? &guard : NULL;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_PERCEPTIVE, "limit", "Limits the speed.", JDE_MS(10), 0u, ports, NULL, JDE_COUNT(ports),
     0u, create, free, NULL, NULL, iterate, NULL, NULL, ability},
};

JDE_PLUGIN("limit", "1", "Limits the speed.", schemas);
