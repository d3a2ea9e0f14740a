/*
 * A motor schema in C that counts its steps and saves the count for the next build. Builds differ only in the speed: the tests
 * build the library once and write other speeds into copies of it.
 */
#include "jde_types.h"

#include <stdlib.h>

enum { BASE, STEPS };

/* A test overwrites this value in the library. */
static const volatile double speed = 0.12345678901234567;

static const jde_port ports[] = {
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
    JDE_PORT_EXPORT("steps", "The number of steps.", jde_uint32_type),
};

typedef struct {
    const jde_host *host;
    jde_uint32 steps;
} counter;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    counter *self;
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
    counter *self = instance;
    jde_twist twist = {0};
    int32_t code;
    if (speed < 0) {
        return jde_failed(self->host, context, "the speed is negative");
    }
    twist.linear.x = speed;
    code = jde_put(self->host, context, BASE, &twist, sizeof twist);
    if (code != JDE_OK) {
        return jde_failed(self->host, context, "the command of the base was refused");
    }
    self->steps.data++;
    return jde_put(self->host, context, STEPS, &self->steps, sizeof self->steps);
}

static int32_t save(void *instance, jde_context *context, const jde_saver *saver)
{
    counter *self = instance;
    (void)context;
    return jde_save(saver, &self->steps, sizeof self->steps);
}

static int32_t restore(void *instance, jde_context *context, uint32_t version, const void *bytes, uint64_t length)
{
    counter *self = instance;
    (void)context;
    if (version != 1u || length != sizeof self->steps) {
        return JDE_FAILED;
    }
    memcpy(&self->steps, bytes, sizeof self->steps);
    return JDE_OK;
}

static const void *ability(const char *id)
{
    static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
    return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, TYPE, "Counts its steps.", JDE_MS(10), 0u, ports, NULL, JDE_COUNT(ports), 0u, create,
     free, NULL, NULL, iterate, NULL, NULL, ability},
};

JDE_PLUGIN(PLUGIN, "1", "Counts its steps.", schemas);
