/*
 * What the schemas of the tests in C and C++ share with the test, runtime/host/tests/common/foreign.rs: each call of a schema runs
 * the scenario's behaviour, whose requests the schema performs.
 */
#ifndef FIXTURE_H
#define FIXTURE_H

#include "jde_types.h"

#include <stdio.h>

/** As in common/io.rs, in that order. */
enum call_kind {
    CALL_AWAKE,
    CALL_CHECK,
    CALL_ITERATE,
    CALL_SLEEP,
    CALL_ARBITRATE,
    CALL_DROP,
    CALL_DRAW,
    CALL_TOUCH,
    CALL_SAVE,
    CALL_RESTORE
};
enum request_kind {
    GET_INPUT,
    GET_OTHER,
    GET_GAIN,
    GET_GRIP,
    COMMAND,
    REACH,
    WAKE,
    SLEEP,
    MODULATE_A,
    RETIME_A,
    PUBLISH,
    RETRACT,
    GET_SEED,
    GET_NOW,
    IS_REAL_TIME,
    IS_READY,
    COLLIDES,
    GET_URGENCY,
    GET_STATE,
    SET_POLICY,
    GET_MARK,
    PUBLISH_MARK,
    LOG,
    DRAW_TEXT,
    DRAW_VALUE,
    DRAW_BUTTON,
    SAVE,
    RESTORE
};

/** The outcome of a request, as a code of jde.h, and its numbers. */
struct answer {
    int32_t code;
    double number;
    uint64_t count;
};

struct call {
    uint32_t scenario;
    uint32_t kind;
    const char *name;
    const char *group;
    const char *gesture;
    uint64_t memory;
    /** The commands of a robot at its last iteration, and now. */
    double commands[2][2];
    void *caller;
    /** Performs a request. Returns 0 if it throws. */
    int32_t (*request)(void *caller, uint32_t request, const char *text, double number, struct answer *);
    uint32_t ready;
    double urgency;
    char role[16];
    char text[512];
};

struct functions {
    /** Returns JDE_OK, JDE_FAILED or JDE_PANICKED. */
    int32_t (*run)(struct call *);
    /** Counts instances. */
    void (*alive)(int32_t);
};

/** Writes a gesture in the words of jde_panel. */
static inline void write_gesture(char *words, size_t size, const jde_gesture *gesture, const char *name)
{
    if (gesture->kind == JDE_TOUCH_TOGGLED) {
        snprintf(words, size, "%s switched `%s` of %s %s", gesture->by, gesture->widget, name, gesture->number != 0u ? "on" : "off");
    } else {
        snprintf(words, size, "%s pressed `%s` of %s", gesture->by, gesture->widget, name);
    }
}

#endif
