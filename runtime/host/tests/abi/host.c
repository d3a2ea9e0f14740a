/*
 * A host of ABI 1.0, built with the header of that version. It calls each function of each schema of a plugin once and prints the
 * results. Guard values follow all memory that it lends, and functions that no plugin may call follow its own table.
 */
#include "jde.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#define GUARD 0x77777777u

static const jde_schema *current;
static char message[256];

/* Reads the initial value of a port, if it has one. */
static int32_t read_port(jde_context *context, uint32_t number, jde_sample *sample)
{
    const char *at = (const char *)current->ports + number * current->ports->size;
    const jde_port *port = (const jde_port *)(const void *)at;
    (void)context;
    if (port->initial == NULL) {
        return JDE_NO_VALUE;
    }
    memset(sample, 0, sizeof *sample);
    sample->data = port->initial;
    sample->bytes = port->value_type->bytes;
    return JDE_OK;
}

static int32_t loan(jde_context *context, uint32_t port, void **room)
{
    static uint64_t rooms[65536];
    (void)context;
    (void)port;
    *room = rooms;
    return JDE_OK;
}

static int32_t publish(jde_context *context, uint32_t port, uint64_t time)
{
    (void)context;
    (void)port;
    (void)time;
    return JDE_OK;
}

static int32_t accept_child(jde_context *context, uint32_t child)
{
    (void)context;
    (void)child;
    return JDE_OK;
}

static int32_t child(jde_context *context, uint32_t number, jde_child_status *status)
{
    (void)context;
    (void)number;
    status->state = JDE_READY;
    status->faulted = 0u;
    status->reserved = 0u;
    return JDE_OK;
}

static int32_t set_policy(jde_context *context, uint32_t number, uint32_t policy, uint64_t dwell, double hysteresis)
{
    (void)context;
    (void)number;
    (void)policy;
    (void)dwell;
    (void)hysteresis;
    return JDE_OK;
}

static uint64_t return_one(jde_context *context)
{
    (void)context;
    return 1u;
}

static const char *name(jde_context *context)
{
    (void)context;
    return "schema";
}

static void say(jde_context *context, uint32_t level, const char *text, uint64_t length)
{
    (void)context;
    (void)level;
    (void)text;
    (void)length;
}

static void fail(jde_context *context, const char *text, uint64_t length)
{
    (void)context;
    snprintf(message, sizeof message, "%.*s", (int)length, text);
}

static const void *extension(jde_context *context, const char *id)
{
    (void)context;
    (void)id;
    return NULL;
}

static void must_not_be_called(void)
{
    puts("a function behind the host's table was called");
    fflush(stdout);
    _Exit(3);
}

static struct {
    jde_host host;
    void (*beyond[8])(void);
} table = {{(uint32_t)sizeof(jde_host), JDE_ABI_MAJOR, JDE_ABI_MINOR, 0u, read_port, loan, publish, accept_child, accept_child, child, set_policy,
            return_one, return_one, return_one, name, say, fail, extension},
           {must_not_be_called, must_not_be_called, must_not_be_called, must_not_be_called, must_not_be_called, must_not_be_called,
            must_not_be_called, must_not_be_called}};

static int call(const jde_schema *schema)
{
    static struct {
        jde_precondition value;
        uint32_t guard[8];
    } ready;
    static struct {
        jde_verdict value;
        uint32_t guard[8];
    } verdict;
    jde_candidate candidates[2];
    jde_level level;
    uint64_t context = 0u;
    jde_context *cx = (jde_context *)(void *)&context;
    void *instance = schema->create(schema, &table.host, cx);
    int32_t code;
    current = schema;
    memset(&ready, 0x77, sizeof ready);
    memset(&verdict, 0x77, sizeof verdict);
    if (instance == NULL) {
        printf("%s: none (%s)\n", schema->name, message);
        return 1;
    }
    message[0] = 0;
    if (schema->awake != NULL && schema->awake(instance, cx) != JDE_OK) {
        printf("%s: awake (%s)\n", schema->name, message);
    }
    ready.value.size = (uint32_t)sizeof ready.value;
    if (schema->check != NULL) {
        code = schema->check(instance, cx, &ready.value);
        printf("%s: check %d, ready %u %s\n", schema->name, code, ready.value.ready, message);
    }
    code = schema->iterate(instance, cx);
    printf("%s: iterate %d %s\n", schema->name, code, message);
    if (schema->arbitrate != NULL) {
        uint32_t at;
        memset(candidates, 0, sizeof candidates);
        for (at = 0u; at < 2u; at++) {
            candidates[at].size = (uint32_t)sizeof *candidates;
            candidates[at].child = at;
            candidates[at].state = JDE_READY;
            candidates[at].ready = 1u;
            candidates[at].urgency = 2.0;
        }
        memset(&level, 0, sizeof level);
        level.size = (uint32_t)sizeof level;
        level.case_ = JDE_COLLISION;
        level.group = "legs";
        level.candidates = candidates;
        level.candidate_count = 2u;
        level.winner = -1;
        verdict.value.size = (uint32_t)sizeof verdict.value;
        code = schema->arbitrate(instance, cx, &level, &verdict.value);
        printf("%s: arbitrate %d, child %d, %s\n", schema->name, code, verdict.value.child, verdict.value.reason);
    }
    if (schema->sleep != NULL) {
        schema->sleep(instance, cx);
    }
    if (schema->destroy != NULL) {
        schema->destroy(instance);
    }
    return ready.guard[0] == GUARD && ready.guard[7] == GUARD && verdict.guard[0] == GUARD && verdict.guard[7] == GUARD ? 0 : 2;
}

int main(int count, char **arguments)
{
    void *library = count == 2 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    const struct jde_plugin *plugin = library != NULL ? dlsym(library, JDE_ENTRY_SYMBOL) : NULL;
    const char *at;
    uint32_t index;
    int worst = 0;
    if (plugin == NULL) {
        puts(library == NULL ? dlerror() : "no plugin");
        return 9;
    }
    if (plugin->magic != JDE_MAGIC || plugin->abi_major != JDE_ABI_MAJOR) {
        puts("another version");
        return 9;
    }
    at = (const char *)plugin->schemas;
    for (index = 0u; index < plugin->schema_count; index++) {
        const jde_schema *schema = (const jde_schema *)(const void *)at;
        int done = call(schema);
        worst = done > worst ? done : worst;
        at += plugin->schemas->size;
    }
    return worst;
}
