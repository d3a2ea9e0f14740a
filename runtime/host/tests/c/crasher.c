/*
 * A motor schema in C that counts its steps, saves the count for the next build, and crashes or hangs. Builds differ by macros:
 * SPEED, the speed at which it drives; CRASHES_AT, the turn in which it dereferences a null pointer, or 0 for none; HANGS, whether
 * its restore hangs; MORE_PORTS, whether it has more ports than the first build and numbers them otherwise.
 */
#include "jde_types.h"

#include <stdlib.h>

#if MORE_PORTS
enum { EXTRA, GAIN, STEPS, BASE };
static const jde_uint32 one = {1u};
#else
enum { BASE, STEPS };
#endif

static const jde_port ports[] = {
#if MORE_PORTS
    JDE_PORT_EXPORT("extra", "An additional export.", jde_twist_type),
    JDE_PORT_MODULATION("gain", "How much a step counts.", "", jde_uint32_type, one, 0.0, JDE_UNBOUNDED, 0u),
    JDE_PORT_EXPORT("steps", "The number of steps of this and all earlier builds.", jde_uint32_type),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
#else
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
    JDE_PORT_EXPORT("steps", "The number of steps of this and all earlier builds.", jde_uint32_type),
#endif
};

typedef struct {
    const jde_host *host;
    jde_uint32 steps;
    unsigned turns;
} crasher;

/* Always null; volatile hides this from the compiler. */
static int *volatile null_pointer;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    crasher *self;
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
    crasher *self = instance;
    jde_twist twist = {0};
    int32_t code;
    self->turns++;
    if (CRASHES_AT != 0 && self->turns == CRASHES_AT) {
        *null_pointer = 1;
    }
    twist.linear.x = SPEED;
    code = jde_put(self->host, context, BASE, &twist, sizeof twist);
    if (code != JDE_OK) {
        return jde_failed(self->host, context, "the command of the base was refused");
    }
#if MORE_PORTS
    {
        const jde_uint32 *gain = jde_get(self->host, context, GAIN, sizeof *gain, NULL);
        if (gain == NULL || gain->data != 1u) {
            return jde_failed(self->host, context, "the additional modulation has no default");
        }
        if (jde_put(self->host, context, EXTRA, &twist, sizeof twist) != JDE_OK) {
            return jde_failed(self->host, context, "the additional export was refused");
        }
    }
#endif
    self->steps.data++;
    return jde_put(self->host, context, STEPS, &self->steps, sizeof self->steps);
}

static int32_t save(void *instance, jde_context *context, const jde_saver *saver)
{
    crasher *self = instance;
    (void)context;
    return jde_save(saver, &self->steps, sizeof self->steps);
}

static int32_t restore(void *instance, jde_context *context, uint32_t version, const void *bytes, uint64_t length)
{
    static const volatile int hangs = HANGS;
    crasher *self = instance;
    (void)context;
    while (hangs) {
    }
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
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "crasher", "Crashes or hangs.", JDE_MS(10), 0u, ports, NULL, JDE_COUNT(ports), 0u,
     create, free, NULL, NULL, iterate, NULL, NULL, ability},
};

JDE_PLUGIN("crasher", "1", "Crashes or hangs.", schemas);
