/*
 * A motor schema in C that does not return from the first iteration in which it sees anything before it is let go. Then it tries
 * everything that a host offers, and tells the test what it was answered. Later iterations return at once.
 */
#include "jde_types.h"

#include <unistd.h>

enum { INPUT, OUTPUT, BASE, HELD, TOLD, HELPER = 0 };

static const jde_uint32 none = {0};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("input", "Looked at.", jde_float64_type, 0u),
    JDE_PORT_EXPORT("output", "Written.", jde_float64_type),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
    JDE_PORT_MODULATION("held", "The file that it waits for.", "", jde_uint32_type, none, 0.0, JDE_UNBOUNDED, 0u),
    JDE_PORT_MODULATION("told", "The file that it answers to.", "", jde_uint32_type, none, 0.0, JDE_UNBOUNDED, 0u),
};

static const jde_child children[] = {
    JDE_CHILD_MOTOR("helper", "group", "Helps.", 0u),
};

static const jde_host *host_of_all;
static int hung;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    (void)schema;
    (void)context;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    host_of_all = host;
    return &hung;
}

static int32_t iterate(void *instance, jde_context *cx)
{
    const jde_host *host = host_of_all;
    const jde_uint32 *held = jde_get(host, cx, HELD, sizeof *held, NULL);
    const jde_uint32 *told = jde_get(host, cx, TOLD, sizeof *told, NULL);
    const jde_float64 *input = jde_get(host, cx, INPUT, sizeof *input, NULL);
    jde_twist twist = {0};
    jde_child_status status = {(uint32_t)sizeof(jde_child_status), 0u, 0u, 0u};
    jde_sample sample;
    jde_float64 before;
    void *room;
    char released;
    int32_t answers[11];
    (void)instance;
    if (hung || input == NULL) {
        return JDE_OK;
    }
    if (held == NULL || told == NULL || host->loan(cx, OUTPUT, &room) != JDE_OK) {
        return jde_failed(host, cx, "there is nothing to hang with");
    }
    hung = 1;
    twist.linear.x = 0.3;
    before = *input;
    if (jde_put(host, cx, BASE, &twist, sizeof twist) != JDE_OK || read((int)held->data, &released, 1u) != 1) {
        return jde_failed(host, cx, "it was never let go");
    }
    /* What it borrowed is still there, and still its own. */
    memset(room, 0xff, sizeof(jde_float64));
    answers[0] = memcmp(&before, input, sizeof before);
    answers[1] = host->publish(cx, OUTPUT, 0u);
    answers[2] = host->read(cx, INPUT, &sample);
    answers[3] = host->loan(cx, OUTPUT, &room);
    answers[4] = host->loan(cx, BASE, &room);
    answers[5] = host->publish(cx, BASE, 0u);
    answers[6] = host->retract(cx, OUTPUT);
    answers[7] = host->wake(cx, HELPER);
    answers[8] = host->sleep(cx, HELPER);
    answers[9] = host->child(cx, HELPER, &status);
    answers[10] = host->set_policy(cx, HELPER, JDE_POLICY_URGENCY, 0u, 0.0);
    jde_say(host, cx, JDE_WARN, "nobody hears this");
    return write((int)told->data, answers, sizeof answers) == (ssize_t)sizeof answers ? JDE_OK : JDE_FAILED;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "captive", "Hangs once.", JDE_MS(10), 0u, ports, children, JDE_COUNT(ports),
     JDE_COUNT(children), create, NULL, NULL, NULL, iterate, NULL, NULL, NULL},
};

JDE_PLUGIN("captive", "1", "Hangs once.", schemas);
