/*
 * Makes every request that the contract forbids, and fails with a message when the host returns another code.
 */
#include "jde_types.h"

enum { INPUT, OUTPUT, MOTOR_CHILD = 0, PERCEPTIVE_CHILD };

static const jde_port ports[] = {
    JDE_PORT_IMPORT("input", "Read.", jde_float64_type, 0u),
    JDE_PORT_EXPORT("output", "Written.", jde_float64_type),
};

static const jde_child children[] = {
    JDE_CHILD_MOTOR("motor", "group", "Competes.", 0u),
    JDE_CHILD_PERCEPTIVE("perceptive", "Helps.", 0u),
};

static const jde_host *shared_host;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    (void)schema;
    if (!jde_host_fits(host) || context == NULL) {
        return NULL;
    }
    shared_host = host;
    return &shared_host;
}

#define EXPECT(code, call)                                        \
    do {                                                          \
        if ((call) != (code)) {                                   \
            return jde_failed(host, cx, #call " is not " #code); \
        }                                                         \
    } while (0)

static int32_t iterate(void *instance, jde_context *cx)
{
    const jde_host *host = shared_host;
    jde_sample sample;
    jde_child_status status = {(uint32_t)sizeof(jde_child_status), 0u, 0u, 0u};
    void *buffer;
    (void)instance;
    EXPECT(JDE_BAD_ARGUMENT, host->read(cx, 99u, &sample));
    EXPECT(JDE_BAD_ARGUMENT, host->read(cx, OUTPUT, &sample));
    EXPECT(JDE_NO_VALUE, host->read(cx, INPUT, &sample));
    EXPECT(JDE_BAD_ARGUMENT, host->loan(cx, 99u, &buffer));
    EXPECT(JDE_BAD_ARGUMENT, host->loan(cx, INPUT, &buffer));
    EXPECT(JDE_BAD_ARGUMENT, host->publish(cx, 99u, 0u));
    EXPECT(JDE_BAD_ARGUMENT, host->publish(cx, OUTPUT, 0u));
    EXPECT(JDE_OK, host->loan(cx, OUTPUT, &buffer));
    EXPECT(JDE_OK, host->publish(cx, OUTPUT, 5u));
    EXPECT(JDE_BAD_ARGUMENT, host->publish(cx, OUTPUT, 0u));
    EXPECT(JDE_BAD_ARGUMENT, host->wake(cx, 99u));
    EXPECT(JDE_BAD_ARGUMENT, host->sleep(cx, 99u));
    EXPECT(JDE_BAD_ARGUMENT, host->child(cx, 99u, &status));
    EXPECT(JDE_OK, host->wake(cx, MOTOR_CHILD));
    EXPECT(JDE_OK, host->wake(cx, MOTOR_CHILD));
    EXPECT(JDE_OK, host->child(cx, MOTOR_CHILD, &status));
    EXPECT(JDE_BAD_ARGUMENT, host->set_policy(cx, MOTOR_CHILD, 99u, 0u, 0.0));
    EXPECT(JDE_BAD_ARGUMENT, host->set_policy(cx, PERCEPTIVE_CHILD, JDE_POLICY_URGENCY, 0u, 0.0));
    EXPECT(JDE_OK, host->set_policy(cx, MOTOR_CHILD, JDE_POLICY_URGENCY, 0u, 0.0));
    EXPECT(1, host->extension(cx, "jde.unknown") == NULL);
    EXPECT(JDE_OK, host->loan(cx, OUTPUT, &buffer));
    return JDE_OK;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "probe", "Makes requests that the contract forbids.", JDE_MS(100), 0u, ports, children,
     JDE_COUNT(ports), JDE_COUNT(children), create, NULL, NULL, NULL, iterate, NULL, NULL, NULL},
};

JDE_PLUGIN("probe", "0.1.0", "Tests a host.", schemas);
