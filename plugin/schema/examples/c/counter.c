/*
 * A perceptive schema in C. It counts its iterations, and keeps the count when it is reloaded.
 *
 *     cc -std=c99 -shared -fPIC -I include plugin/schema/examples/c/counter.c -o libcounter.so
 */
#include "jde_types.h"

#include <stdlib.h>

/* Calls identify a port by its index in the table below. */
enum { STEP, COUNT };

static const jde_uint32 one = {1u};

static const jde_port ports[] = {
    JDE_PORT_MODULATION("step", "How much each iteration adds.", "", jde_uint32_type, one, 0.0, JDE_UNBOUNDED, 0u),
    JDE_PORT_EXPORT("count", "The sum so far.", jde_uint32_type),
};

/* The memory of an instance. The host may create any number of instances. */
typedef struct {
    const jde_host *host;
    jde_uint32 count;
} counter;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    counter *self;
    (void)schema;
    if (!jde_host_fits(host)) {
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

static int32_t iterate(void *instance, jde_context *context)
{
    counter *self = instance;
    const jde_uint32 *step = jde_get(self->host, context, STEP, sizeof *step, NULL);
    if (step == NULL) {
        return jde_failed(self->host, context, "a modulation always has a value");
    }
    self->count.data += step->data;
    return jde_put(self->host, context, COUNT, &self->count, sizeof self->count);
}

static int32_t save(void *instance, jde_context *context, const jde_saver *saver)
{
    const counter *self = instance;
    if (jde_save(saver, &self->count, sizeof self->count) != JDE_OK) {
        return jde_failed(self->host, context, "the host did not keep the count");
    }
    return JDE_OK;
}

static int32_t restore(void *instance, jde_context *context, uint32_t version, const void *bytes, uint64_t length)
{
    counter *self = instance;
    if (version != 1u || length != sizeof self->count) {
        return jde_failed(self->host, context, "the saved count has another version or size");
    }
    memcpy(&self->count, bytes, sizeof self->count);
    return JDE_OK;
}

static const void *ability(const char *id)
{
    static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
    return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL;
}

static const jde_schema schemas[] = {
    {
        (uint32_t)sizeof(jde_schema), JDE_PERCEPTIVE, "counter", "Counts its iterations.",
        JDE_MS(100), 0u,                        /* period, budget (0: the period) */
        ports, NULL, JDE_COUNT(ports), 0u,      /* ports, children */
        create, free, NULL, NULL, iterate,      /* create, destroy, awake, check, iterate */
        NULL, NULL, ability,                    /* arbitrate, sleep, ability */
    },
};

JDE_PLUGIN("counter", "0.1.0", "Counts.", schemas);
