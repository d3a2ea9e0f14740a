/*
 * A motor schema in C that hangs in the first iteration that has an input, until the test releases it. Then it calls every function
 * of the host and reports the results to the test. Later iterations return at once.
 */
#include "jde_types.h"

#include <unistd.h>

enum { INPUT, OUTPUT, BASE, WAIT, REPORT, HELPER = 0 };

static const jde_uint32 none = {0};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("input", "An input.", jde_float64_type, 0u),
    JDE_PORT_EXPORT("output", "An output.", jde_float64_type),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
    JDE_PORT_MODULATION("wait", "The file descriptor to wait for.", "", jde_uint32_type, none, 0.0, JDE_UNBOUNDED, 0u),
    JDE_PORT_MODULATION("report", "The file descriptor of the report.", "", jde_uint32_type, none, 0.0, JDE_UNBOUNDED, 0u),
};

static const jde_child children[] = {
    JDE_CHILD_MOTOR("helper", "group", "A child.", 0u),
};

static const jde_host *stored_host;
static int hung;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    (void)schema;
    (void)context;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    stored_host = host;
    return &hung;
}

static int32_t iterate(void *instance, jde_context *cx)
{
    const jde_host *host = stored_host;
    const jde_uint32 *wait_fd = jde_get(host, cx, WAIT, sizeof *wait_fd, NULL);
    const jde_uint32 *report_fd = jde_get(host, cx, REPORT, sizeof *report_fd, NULL);
    const jde_float64 *input = jde_get(host, cx, INPUT, sizeof *input, NULL);
    jde_twist twist = {0};
    jde_child_status status = {(uint32_t)sizeof(jde_child_status), 0u, 0u, 0u};
    jde_sample sample;
    jde_float64 before;
    void *room;
    char released;
    int32_t statuses[11];
    (void)instance;
    if (hung || input == NULL) {
        return JDE_OK;
    }
    if (wait_fd == NULL || report_fd == NULL || host->loan(cx, OUTPUT, &room) != JDE_OK) {
        return jde_failed(host, cx, "the file descriptors or the output are missing");
    }
    hung = 1;
    twist.linear.x = 0.3;
    before = *input;
    if (jde_put(host, cx, BASE, &twist, sizeof twist) != JDE_OK || read((int)wait_fd->data, &released, 1u) != 1) {
        return jde_failed(host, cx, "the test did not release the call");
    }
    /* The borrowed input and the loan are still valid. */
    memset(room, 0xff, sizeof(jde_float64));
    statuses[0] = memcmp(&before, input, sizeof before);
    statuses[1] = host->publish(cx, OUTPUT, 0u);
    statuses[2] = host->read(cx, INPUT, &sample);
    statuses[3] = host->loan(cx, OUTPUT, &room);
    statuses[4] = host->loan(cx, BASE, &room);
    statuses[5] = host->publish(cx, BASE, 0u);
    statuses[6] = host->retract(cx, OUTPUT);
    statuses[7] = host->wake(cx, HELPER);
    statuses[8] = host->sleep(cx, HELPER);
    statuses[9] = host->child(cx, HELPER, &status);
    statuses[10] = host->set_policy(cx, HELPER, JDE_POLICY_URGENCY, 0u, 0.0);
    jde_say(host, cx, JDE_WARN, "this message is discarded");
    return write((int)report_fd->data, statuses, sizeof statuses) == (ssize_t)sizeof statuses ? JDE_OK : JDE_FAILED;
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "hanging", "Hangs once.", JDE_MS(10), 0u, ports, children, JDE_COUNT(ports),
     JDE_COUNT(children), create, NULL, NULL, NULL, iterate, NULL, NULL, NULL},
};

JDE_PLUGIN("hanging", "1", "Hangs once.", schemas);
