/*
 * A plugin in C that reads a value of a plugin in Rust: a motor schema that is ready while the ball is seen within reach. Put under
 * `roots` or beside other children, it tells a father, a trigger of a recording or a person that the ball is there.
 *
 *     cc -shared -fPIC -I include -o libnear.so robotics/ball/c/near.c
 */
#include "ball.h"

enum { BALL, REACH };

static const jde_float64 reach = {1.0};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("ball", "Where the ball is.", ball_type, JDE_TRIGGER),
    JDE_PORT_MODULATION("reach", "How near it has to be.", "m", jde_float64_type, reach, 0.0, JDE_UNBOUNDED, 0u),
};

/* It remembers nothing, so the host is all that an instance has. */
static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    (void)schema;
    (void)context;
    return jde_host_fits(host) ? (void *)host : NULL;
}

static int32_t is_near(void *instance, jde_context *context, jde_precondition *answer)
{
    const jde_host *host = instance;
    const ball *seen = jde_get(host, context, BALL, sizeof *seen, NULL);
    const jde_float64 *within = jde_get(host, context, REACH, sizeof *within, NULL);
    answer->ready = seen != NULL && within != NULL && seen->seen != 0u && seen->distance <= within->data;
    return JDE_OK;
}

static int32_t nothing(void *instance, jde_context *context)
{
    (void)instance;
    (void)context;
    return JDE_OK;
}

static const jde_schema schemas[] = {{
    (uint32_t)sizeof(jde_schema), JDE_MOTOR, "near", "Is ready while the ball is seen within reach.", JDE_MS(100), 0u, ports,
    NULL, JDE_COUNT(ports), 0u, create, NULL, NULL, is_near, nothing, NULL, NULL, NULL}};

JDE_PLUGIN("near", "1", "Tells whether the ball is near.", schemas);
