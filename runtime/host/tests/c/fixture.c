/*
 * The schemas of the tests in C: each call runs the scenario's behaviour in the test, whose requests go through the functions of
 * jde.h here.
 */
#include "fixture.h"

#include <stdlib.h>

static struct functions test;

/** A value of a type of the tests' own, as in common/schemas.rs. */
typedef struct mark {
    struct { uint32_t length; uint32_t spare; jde_pose2d items[4]; } places;
    struct { uint32_t length; char bytes[12]; } label;
} mark;

static const jde_field mark_fields[] = {
    JDE_FIELD("places", offsetof(mark, places.items), offsetof(mark, places.length), JDE_STRUCT, JDE_SEQUENCE, 4u, "Where it is.", "",
              &jde_pose2d_type),
    JDE_FIELD("label", offsetof(mark, label.bytes), offsetof(mark, label.length), JDE_U8, JDE_TEXT, 12u, "What it is.", "", NULL),
};
static const jde_type mark_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(mark_fields), "test_msgs/msg/Mark", "A value of a type of the tests' own.", sizeof(mark), 8u,
    mark_fields};

static const jde_uint32 zero = {0u};
static const jde_float64 none = {0.0};
static const jde_twist still;

#define SCENARIO_PORT \
    JDE_PORT_MODULATION("scenario", "The number of the scenario.", "", jde_uint32_type, zero, JDE_UNBOUNDED, JDE_UNBOUNDED, JDE_FIXED)
#define NUMBER_PORT(name, doc, flags) JDE_PORT_MODULATION(name, doc, "", jde_float64_type, none, JDE_UNBOUNDED, JDE_UNBOUNDED, flags)

enum { SCENARIO };
enum { INPUT = 1, OTHER, MARK, GAIN, GRIP, BASE, ARM, MISSION, GAIN_OF_A, PERIOD_OF_A };
static const jde_port motor_ports[] = {
    SCENARIO_PORT,
    JDE_PORT_IMPORT("input", "An input.", jde_float64_type, JDE_OPTIONAL),
    JDE_PORT_IMPORT("other", "Another input.", jde_float64_type, JDE_OPTIONAL),
    JDE_PORT_IMPORT("mark", "A value of a type of the tests' own.", mark_type, JDE_OPTIONAL),
    NUMBER_PORT("gain", "A modulation for a father or an operator.", 0u),
    NUMBER_PORT("grip", "A modulation that is read at the awakening.", JDE_FIXED),
    JDE_PORT_ACTUATOR("base", "A command with a long validity.", jde_twist_type, JDE_OPTIONAL),
    JDE_PORT_ACTUATOR("arm", "A command with a short validity.", jde_twist_type, JDE_OPTIONAL),
    JDE_PORT_EXPORT("mission", "The progress of the mission.", jde_mission_type),
    JDE_PORT_CHILD_MODULATION(0u, "gain", "The modulation of child a.", jde_float64_type, JDE_OPTIONAL),
    JDE_PORT_CHILD_MODULATION(0u, "period", "The period of child a.", jde_float64_type, JDE_OPTIONAL),
};
static const jde_child children[] = {
    JDE_CHILD_MOTOR("a", "base", "A child.", JDE_OPTIONAL),
    JDE_CHILD_MOTOR("b", "base", "Another child.", JDE_OPTIONAL),
    JDE_CHILD_MOTOR("c", "base", "A third child.", JDE_OPTIONAL),
    JDE_CHILD_PERCEPTIVE("helper", "A perceptive child.", JDE_OPTIONAL),
};

enum { EYE_GAIN = 1, EYE_INPUT, OUT, EYE_MARK };
static const jde_port eye_ports[] = {
    SCENARIO_PORT,
    NUMBER_PORT("gain", "A modulation for an operator.", 0u),
    JDE_PORT_IMPORT("input", "An input.", jde_float64_type, JDE_OPTIONAL),
    JDE_PORT_EXPORT("out", "The value that the test publishes.", jde_float64_type),
    JDE_PORT_EXPORT("mark", "A value of a type of the tests' own.", mark_type),
};

enum { VELOCITY = 1, REACHED };
static const jde_port robot_ports[] = {
    SCENARIO_PORT,
    JDE_PORT_COMMAND("velocity", "A command that is in force for long.", jde_twist_type, still, JDE_MS(1000000)),
    JDE_PORT_COMMAND("reach", "A command that must be repeated.", jde_twist_type, still, JDE_MS(50)),
};

typedef struct {
    const jde_host *host;
    uint32_t scenario;
    uint64_t calls;
    char name[64];
    double commands[2];
} instance;

/** A call of an instance, and what it lends. */
typedef struct {
    instance *self;
    jde_context *context;
    const jde_level *level;
    const jde_pen *pen;
    const jde_saver *saver;
    const double *saved;
} caller;

static void *create(const jde_schema *schema, const jde_host *host, jde_context *context)
{
    instance *self;
    if (!jde_host_fits(host)) {
        return NULL;
    }
    if (strcmp(schema->name, "fails-to-create") == 0) {
        jde_failed(host, context, "there is no such device");
        return NULL;
    }
    self = calloc(1u, sizeof *self);
    if (self != NULL) {
        self->host = host;
        test.alive(1);
    }
    return self;
}

static uint32_t role(const char *name)
{
    uint32_t number = 0u;
    while (number + 1u < JDE_COUNT(children) && strcmp(children[number].name, name) != 0) {
        number++;
    }
    return number;
}

static const jde_candidate *candidate(const jde_level *level, const char *name)
{
    const char *at = (const char *)level->candidates;
    uint32_t left;
    for (left = level->candidate_count; left > 0u; left--, at += level->candidates->size) {
        if (((const jde_candidate *)(const void *)at)->child == role(name)) {
            return (const jde_candidate *)(const void *)at;
        }
    }
    return NULL;
}

static int32_t drive(const caller *of, uint32_t port, double speed)
{
    jde_twist twist = {0};
    twist.linear.x = speed;
    return jde_put(of->self->host, of->context, port, &twist, sizeof twist);
}

static int32_t put(const caller *of, uint32_t port, double number)
{
    const jde_float64 value = {number};
    return jde_put(of->self->host, of->context, port, &value, sizeof value);
}

static void get(const caller *of, uint32_t port, struct answer *answer)
{
    jde_sample sample;
    const jde_float64 *value = jde_get(of->self->host, of->context, port, sizeof *value, &sample);
    answer->code = value != NULL ? JDE_OK : JDE_NO_VALUE;
    answer->number = value != NULL ? value->data : 0.0;
    answer->count = value != NULL ? sample.sequence : 0u;
}

static void get_mark(const caller *of, const char *label, struct answer *answer)
{
    const mark *value = jde_get(of->self->host, of->context, MARK, sizeof *value, NULL);
    answer->code = JDE_NO_VALUE;
    if (value != NULL && value->label.length == strlen(label) && memcmp(value->label.bytes, label, strlen(label)) == 0) {
        answer->code = JDE_OK;
        answer->count = value->places.length;
        answer->number = value->places.items[value->places.length - 1u].x;
    }
}

static int32_t put_mark(const caller *of, const char *label, double x)
{
    mark value;
    memset(&value, 0, sizeof value);
    value.places.length = 1u;
    value.places.items[0].x = x;
    value.label.length = (uint32_t)strlen(label);
    memcpy(value.label.bytes, label, strlen(label));
    return jde_put(of->self->host, of->context, EYE_MARK, &value, sizeof value);
}

/** Saves a number in the form of the memories in Rust and C++: what it is and the number, each after its length. */
static int32_t save_number(const jde_saver *saver, double number)
{
    char what[64];
    uint64_t length = (uint64_t)snprintf(what, sizeof what, "a %s", jde_float64_type.name);
    const uint64_t size = sizeof number;
    jde_save(saver, &length, sizeof length);
    jde_save(saver, what, (size_t)length);
    jde_save(saver, &size, sizeof size);
    return jde_save(saver, &number, sizeof number);
}

static int32_t request(void *data, uint32_t kind, const char *text, double number, struct answer *answer)
{
    const caller *of = data;
    const jde_host *host = of->self->host;
    jde_context *context = of->context;
    jde_child_status status = {(uint32_t)sizeof(jde_child_status), JDE_SLEPT, 0u, 0u};
    const jde_candidate *competes;
    memset(answer, 0, sizeof *answer);
    switch (kind) {
    case GET_INPUT: get(of, INPUT, answer); break;
    case GET_OTHER: get(of, OTHER, answer); break;
    case GET_GAIN: get(of, GAIN, answer); break;
    case GET_GRIP: get(of, GRIP, answer); break;
    case COMMAND: answer->code = drive(of, BASE, number); break;
    case REACH: answer->code = drive(of, ARM, number); break;
    case WAKE: answer->code = host->wake(context, role(text)); break;
    case SLEEP: answer->code = host->sleep(context, role(text)); break;
    case MODULATE_A: answer->code = put(of, GAIN_OF_A, number); break;
    case RETIME_A: answer->code = put(of, PERIOD_OF_A, number); break;
    case PUBLISH: answer->code = put(of, OUT, number); break;
    case RETRACT: answer->code = host->retract(context, OUT); break;
    case GET_SEED: answer->count = host->seed(context); break;
    case GET_NOW: answer->count = host->now(context); break;
    case IS_REAL_TIME: answer->code = host->real_time(context) != 0u ? JDE_OK : JDE_REFUSED; break;
    case IS_READY:
    case GET_URGENCY:
        competes = candidate(of->level, text);
        answer->code = competes != NULL && competes->ready != 0u ? JDE_OK : JDE_REFUSED;
        answer->number = competes != NULL ? competes->urgency : 0.0;
        break;
    case COLLIDES: answer->code = of->level->case_ == JDE_COLLISION ? JDE_OK : JDE_REFUSED; break;
    case GET_STATE:
        answer->code = host->child(context, role(text), &status);
        answer->count = status.state;
        answer->number = status.faulted;
        break;
    case SET_POLICY: answer->code = host->set_policy(context, role(text), JDE_POLICY_URGENCY, 0u, 0.0); break;
    case GET_MARK: get_mark(of, text, answer); break;
    case PUBLISH_MARK: answer->code = put_mark(of, text, number); break;
    case LOG: jde_say(host, context, JDE_INFO, text); break;
    case DRAW_TEXT: jde_add_text(of->pen, JDE_WORDS_PLAIN, text); break;
    case DRAW_VALUE: jde_add_value(of->pen, text, number, "m"); break;
    case DRAW_BUTTON: jde_add_button(of->pen, text, text, 0u); break;
    case SAVE: answer->code = save_number(of->saver, number); break;
    case RESTORE:
        answer->code = of->saved != NULL ? JDE_OK : JDE_REFUSED;
        answer->number = of->saved != NULL ? *of->saved : 0.0;
        break;
    default: answer->code = JDE_BAD_ARGUMENT;
    }
    return 1;
}

/** Runs the behaviour of a call. */
static int32_t run(caller *of, struct call *call, uint32_t kind)
{
    instance *self = of->self;
    const jde_uint32 *scenario = jde_get(self->host, of->context, SCENARIO, sizeof *scenario, NULL);
    int32_t code;
    self->scenario = scenario != NULL ? scenario->data : 0u;
    snprintf(self->name, sizeof self->name, "%s", self->host->name(of->context));
    call->scenario = self->scenario;
    call->kind = kind;
    call->name = self->name;
    call->group = of->level != NULL ? of->level->group : NULL;
    call->memory = self->calls++;
    call->caller = of;
    call->request = request;
    code = test.run(call);
    if (code != JDE_OK) {
        self->host->fail(of->context, call->text, strlen(call->text));
    }
    return code;
}

static int32_t run_plain(void *self, jde_context *context, uint32_t kind)
{
    caller of = {self, context, NULL, NULL, NULL, NULL};
    struct call call = {0};
    return run(&of, &call, kind);
}

static void destroy(void *data)
{
    instance *self = data;
    struct call call = {0};
    test.alive(-1);
    if (self->scenario != 0u) {
        call.scenario = self->scenario;
        call.kind = CALL_DROP;
        call.name = self->name;
        call.memory = self->calls;
        test.run(&call);
    }
    free(self);
}

static int32_t awake(void *self, jde_context *context)
{
    return run_plain(self, context, CALL_AWAKE);
}

static int32_t check(void *self, jde_context *context, jde_precondition *out)
{
    caller of = {self, context, NULL, NULL, NULL, NULL};
    struct call call = {0};
    const int32_t code = run(&of, &call, CALL_CHECK);
    out->ready = call.ready;
    out->urgency = call.urgency;
    return code;
}

static int32_t iterate(void *self, jde_context *context)
{
    return run_plain(self, context, CALL_ITERATE);
}

/** A gain of 100 or more sets the mission's state. */
static int32_t iterate_motor(void *self, jde_context *context)
{
    const int32_t code = run_plain(self, context, CALL_ITERATE);
    const jde_host *host = ((instance *)self)->host;
    const jde_float64 *gain = jde_get(host, context, GAIN, sizeof *gain, NULL);
    if (code == JDE_OK && gain != NULL && gain->data >= 100.0) {
        jde_mission mission;
        memset(&mission, 0, sizeof mission);
        mission.state = (uint8_t)(gain->data - 100.0);
        return jde_put(host, context, MISSION, &mission, sizeof mission);
    }
    return code;
}

static double speed(const instance *self, jde_context *context, uint32_t port)
{
    jde_sample sample;
    const jde_twist *twist = jde_get(self->host, context, port, sizeof *twist, &sample);
    return twist != NULL && (sample.flags & JDE_SAMPLE_NEUTRAL) == 0u ? twist->linear.x : 0.0;
}

static int32_t iterate_robot(void *data, jde_context *context)
{
    instance *self = data;
    caller of = {self, context, NULL, NULL, NULL, NULL};
    struct call call = {0};
    int32_t code;
    memcpy(call.commands[0], self->commands, sizeof self->commands);
    self->commands[0] = speed(self, context, VELOCITY);
    self->commands[1] = speed(self, context, REACHED);
    memcpy(call.commands[1], self->commands, sizeof self->commands);
    code = run(&of, &call, CALL_ITERATE);
    if (code == JDE_OK && (speed(self, context, VELOCITY) != self->commands[0] || speed(self, context, REACHED) != self->commands[1])) {
        return jde_failed(self->host, context, "it read another command in the same iteration");
    }
    return code;
}

static void sleep_now(void *self, jde_context *context)
{
    run_plain(self, context, CALL_SLEEP);
}

static int32_t arbitrate(void *self, jde_context *context, const jde_level *level, jde_verdict *out)
{
    caller of = {self, context, level, NULL, NULL, NULL};
    struct call call = {0};
    const int32_t code = run(&of, &call, CALL_ARBITRATE);
    if (code != JDE_OK) {
        return code;
    }
    if (call.role[0] == '\0') {
        out->child = -1;
        snprintf(out->reason, sizeof out->reason, "the scenario chose no child");
    } else {
        out->child = (int32_t)role(call.role);
        snprintf(out->reason, sizeof out->reason, "%s chose %s", call.name, call.role);
    }
    return JDE_OK;
}

static int32_t draw(void *self, jde_context *context, const jde_pen *pen)
{
    caller of = {self, context, NULL, pen, NULL, NULL};
    struct call call = {0};
    return run(&of, &call, CALL_DRAW);
}

static int32_t touch(void *self, jde_context *context, const jde_gesture *gesture)
{
    caller of = {self, context, NULL, NULL, NULL, NULL};
    struct call call = {0};
    char words[256];
    write_gesture(words, sizeof words, gesture, ((instance *)self)->host->name(context));
    call.gesture = words;
    return run(&of, &call, CALL_TOUCH);
}

static int32_t save(void *self, jde_context *context, const jde_saver *saver)
{
    caller of = {self, context, NULL, NULL, saver, NULL};
    struct call call = {0};
    return run(&of, &call, CALL_SAVE);
}

static int32_t restore(void *self, jde_context *context, uint32_t version, const void *bytes, uint64_t length)
{
    caller of = {self, context, NULL, NULL, NULL, NULL};
    struct call call = {0};
    double number;
    (void)version;
    if (length > sizeof number) {
        memcpy(&number, (const char *)bytes + length - sizeof number, sizeof number);
        of.saved = &number;
    }
    return run(&of, &call, CALL_RESTORE);
}

static int32_t judge(const void *state, uint64_t age_ns, const void *command, jde_judgement *out)
{
    const double limit = ((const jde_float64 *)state)->data;
    const double wanted = ((const jde_twist *)command)->linear.x;
    char reason[128];
    (void)age_ns;
    if (isnan(limit)) {
        jde_refuse(out, "a limit is a number");
        return JDE_PANICKED;
    }
    if (wanted <= limit) {
        return jde_accept(out);
    }
    snprintf(reason, sizeof reason, "%g m/s, and at most %g m/s are safe", wanted, limit);
    if (limit > 0.3 && limit < 0.4) {
        jde_twist lesser;
        memset(&lesser, 0, sizeof lesser);
        lesser.linear.x = limit;
        return jde_limit(out, &lesser, sizeof lesser, reason);
    }
    return jde_refuse(out, reason);
}

static const void *ability_of_motor(const char *id)
{
    static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};
    static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
    if (strcmp(id, JDE_ABILITY_PANEL) == 0) {
        return &panel;
    }
    return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL;
}

static const void *ability_of_eye(const char *id)
{
    static const jde_guard guard = {(uint32_t)sizeof(jde_guard), OUT, &jde_twist_type, judge};
    return strcmp(id, JDE_ABILITY_GUARD) == 0 ? &guard : NULL;
}

#define MOTOR(name, doc, ability)                                                                                             \
    {(uint32_t)sizeof(jde_schema), JDE_MOTOR, name, doc, JDE_MS(10), 0u, motor_ports, children, JDE_COUNT(motor_ports),       \
     JDE_COUNT(children), create, destroy, awake, check, iterate_motor, arbitrate, sleep_now, ability}

static const jde_schema schemas[] = {
    MOTOR("motor", "A motor schema.", NULL),
    MOTOR("able-motor", "A motor schema with a panel and a memory.", ability_of_motor),
    {(uint32_t)sizeof(jde_schema), JDE_PERCEPTIVE, "eye", "A perceptive schema.", JDE_MS(10), 0u, eye_ports, NULL,
     JDE_COUNT(eye_ports), 0u, create, destroy, awake, NULL, iterate, NULL, sleep_now, ability_of_eye},
    {(uint32_t)sizeof(jde_schema), JDE_DRIVER, "robot", "A driver. It records each change of its commands.", JDE_MS(10), 0u,
     robot_ports, NULL, JDE_COUNT(robot_ports), 0u, create, destroy, awake, NULL, iterate_robot, NULL, sleep_now, NULL},
    MOTOR("fails-to-create", "A schema that cannot be created.", NULL),
};

/** Connects the schemas with the test. */
extern JDE_VISIBLE void fixture_connect(struct functions functions);
void fixture_connect(struct functions functions)
{
    test = functions;
}

JDE_PLUGIN("test", "0.1.0", "Schemas of the tests.", schemas);
