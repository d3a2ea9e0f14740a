/*
 * A motor schema and father in C that keeps all promises of the ABI, but for the one that OFFENCE names by its number in
 * planted.rs; 0 for none.
 */
#define _GNU_SOURCE
#include "jde_types.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define IS(number) (OFFENCE == (number))

enum { SCAN, SPEED, STEPS, BASE, MAYBE };

static const jde_float64 usual_speed = {0.5};

static const jde_port ports[] = {
    JDE_PORT_IMPORT("scan", "Distances.", jde_uint32_type, 0u),
    JDE_PORT_MODULATION("speed", "How fast.", "m/s", jde_float64_type, usual_speed, 0.0, 2.0, 0u),
    JDE_PORT_EXPORT(IS(1) ? "scan scan" : "steps", IS(2) ? "" : "Iterations of this instance.", jde_uint32_type),
    JDE_PORT_ACTUATOR("base", "Speeds of the base.", jde_twist_type, 0u),
    JDE_PORT_IMPORT("maybe", "A hint.", jde_uint32_type, JDE_OPTIONAL),
};

static const jde_child children[] = {
    JDE_CHILD_MOTOR("first", "base", "Goes first.", 0u),
    JDE_CHILD_MOTOR("second", "base", "Goes second.", JDE_OPTIONAL),
};

typedef struct {
    const jde_host *host;
    jde_context *context;
    jde_uint32 steps;
    int awakenings;
} planted;

/* Always null; volatile hides this from the compiler. */
static int *volatile null_pointer;
static int instances;
static unsigned lives;

static void *wait_for_ever(void *unused)
{
    for (;;) {
        pause();
    }
    return unused;
}

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    planted *self;
    (void)schema;
    if (!jde_host_fits(host) || IS(6)) {
        return NULL;
    }
    if (IS(22) && instances > 0) {
        jde_failed(host, context, "there is one already");
        return NULL;
    }
    instances++;
    lives++;
    self = calloc(1u, sizeof *self);
    if (self != NULL) {
        self->host = host;
        self->context = context;
    }
    return self;
}

static void destroy(void *instance)
{
    planted *self = instance;
    pthread_t thread;
    if (IS(14)) {
        self->host->now(self->context);
    }
    if (IS(24)) {
        pthread_create(&thread, NULL, wait_for_ever, NULL);
    }
    if (IS(25) && open("/dev/null", O_RDONLY) < 0) {
        abort();
    }
    if (IS(26)) {
        memset(malloc(4000u), 1, 4000u);
    }
    if (IS(27)) {
        signal(SIGUSR1, SIG_IGN);
    }
    instances--;
    free(self);
}

static int32_t awake(void *instance, jde_context *context)
{
    planted *self = instance;
    self->awakenings++;
    if (IS(21) && self->awakenings > 1) {
        return jde_failed(self->host, context, "it has slept");
    }
    return JDE_OK;
}

static int32_t check(void *instance, jde_context *context, jde_precondition *out)
{
    planted *self = instance;
    jde_twist twist = {0};
    out->ready = 1u;
    out->urgency = IS(16) ? NAN : 1.0;
    if (IS(15)) {
        jde_put(self->host, context, BASE, &twist, sizeof twist);
    }
    return JDE_OK;
}

static int32_t iterate(void *instance, jde_context *context)
{
    planted *self = instance;
    const jde_host *host = self->host;
    const jde_float64 *speed = jde_get(host, context, SPEED, sizeof *speed, NULL);
    jde_twist twist = {0};
    jde_sample sample;
    void *buffer;
    int32_t code;
    if (IS(3)) {
        *null_pointer = 1;
    }
    if (IS(4)) {
        exit(0);
    }
    if (IS(5)) {
        wait_for_ever(NULL);
    }
    if (IS(7)) {
        return 42;
    }
    if (IS(8)) {
        return JDE_FAILED;
    }
    if (IS(9)) {
        jde_failed(host, context, "all went wrong");
        return JDE_PANICKED;
    }
    if (speed == NULL) {
        return jde_failed(host, context, "a modulation has no value");
    }
    if (host->read(context, SCAN, &sample) == JDE_NO_VALUE && IS(17)) {
        return jde_failed(host, context, "there is no scan");
    }
    if (host->read(context, MAYBE, &sample) == JDE_UNBOUND && IS(18)) {
        return jde_failed(host, context, "there is no hint");
    }
    if (IS(10)) {
        host->read(context, 99u, &sample);
    }
    if (IS(11)) {
        host->publish(context, STEPS, 0u);
    }
    twist.linear.x = IS(12) ? NAN : speed->data;
    code = jde_put(host, context, BASE, &twist, sizeof twist);
    if (code == JDE_REFUSED && IS(19)) {
        return jde_failed(host, context, "the base does not obey");
    }
    self->steps.data += IS(23) ? lives : 1u;
    if (host->loan(context, STEPS, &buffer) != JDE_OK) {
        return jde_failed(host, context, "no memory for the steps");
    }
    memcpy(buffer, &self->steps, sizeof self->steps);
    host->publish(context, STEPS, IS(13) ? host->now(context) + 1000000000u : 0u);
    if (IS(20) || JDE_HOST_HAS(host, retract)) {
        host->retract(context, STEPS);
    }
    if (IS(28)) {
        printf("step\n");
        fflush(stdout);
    }
    host->wake(context, 0u);
    host->wake(context, 1u);
    return JDE_OK;
}

static int32_t arbitrate(void *instance, jde_context *context, const jde_level *level, jde_verdict *verdict)
{
    (void)instance;
    (void)context;
    verdict->child = IS(32) ? 7 : (int32_t)level->candidates[0].child;
    strcpy(verdict->reason, "it is the first");
    return JDE_OK;
}

static void fall_asleep(void *instance, jde_context *context)
{
    (void)instance;
    (void)context;
}

static int32_t draw(void *instance, jde_context *context, const jde_pen *pen)
{
    planted *self = instance;
    jde_widget widget = jde_widget_of(JDE_WIDGET_TEXT);
    widget.label = "steps";
    if (IS(29)) {
        widget.kind = 999u;
    }
    if (IS(30)) {
        jde_put(self->host, context, STEPS, &self->steps, sizeof self->steps);
    }
    pen->add(pen->drawing, &widget);
    return JDE_OK;
}

static int32_t save(void *instance, jde_context *context, const jde_saver *saver)
{
    planted *self = instance;
    (void)context;
    return jde_save(saver, &self->steps, sizeof self->steps);
}

static int32_t restore(void *instance, jde_context *context, uint32_t version, const void *bytes, uint64_t length)
{
    planted *self = instance;
    if (version != 1u || length != sizeof self->steps) {
        return jde_failed(self->host, context, "the memory is of another version");
    }
    if (!IS(31)) {
        memcpy(&self->steps, bytes, sizeof self->steps);
    }
    return JDE_OK;
}

static int32_t inspect(void *instance, jde_context *context, const jde_problems *problems)
{
    (void)instance;
    (void)context;
    if (IS(33)) {
        jde_problem(problems, JDE_PROBLEM_WRONG, BASE, "the base is slow");
    }
    return JDE_OK;
}

static const void *ability(const char *id)
{
    static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, NULL};
    static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
    static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};
    if (strcmp(id, JDE_ABILITY_PANEL) == 0) {
        return &panel;
    }
    if (strcmp(id, JDE_ABILITY_INSPECT) == 0) {
        return &inspection;
    }
    return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL;
}

/* Runs when the process ends. */
__attribute__((destructor)) static void end(void)
{
    if (IS(34)) {
        wait_for_ever(NULL);
    }
}

static const jde_schema schemas[] = {
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, "planted", "Breaks one promise.", JDE_MS(10), 0u, ports, children,
     JDE_COUNT(ports), JDE_COUNT(children), create, destroy, awake, check, iterate, arbitrate, fall_asleep, ability},
};

JDE_PLUGIN("planted", "1", "Breaks one promise.", schemas);
