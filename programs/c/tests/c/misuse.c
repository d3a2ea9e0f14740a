/* Makes the mistakes that a program can make, and prints what the library says. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jde_run.h>
#include <jde_types.h>

static void say(const char *what, int32_t status)
{
    if (status == JDE_OK) {
        printf("%s: done\n", what);
    } else {
        printf("%s: %d %s\n", what, (int)status, jde_error());
    }
}

/* A twist whose speeds are of 32 bits. */
typedef struct {
    float linear, angular;
} narrow;
static const jde_field narrow_fields[] = {
    JDE_FIELD("linear", offsetof(narrow, linear), 0u, JDE_F32, JDE_ONE, 1u, "", "", NULL),
    JDE_FIELD("angular", offsetof(narrow, angular), 0u, JDE_F32, JDE_ONE, 1u, "", "", NULL),
};
static const jde_type narrow_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(narrow_fields), "geometry_msgs/msg/Twist", "", sizeof(narrow), 4u, narrow_fields};

/* A thread may call the library while it ends, when no text is kept for it any more. */
static void at_end(void *run)
{
    say("at the end of a thread", jde_run_step((jde_run *)run));
}

static void *end_thread(void *key)
{
    pthread_setspecific(*(pthread_key_t *)key, key);
    say("in a thread", jde_run_step(NULL));
    return NULL;
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        return 2;
    }
    jde_application *application = NULL;
    jde_run *run = NULL;
    say("no file", jde_application_load("no.toml", NULL, &application));
    say("null file", jde_application_load(NULL, NULL, &application));
    say("broken file", jde_application_load(argv[2], NULL, &application));
    const char *values[] = {"goon.fats=0.3"};
    jde_load_options load = {.size = sizeof load, .values = values, .value_count = 1};
    say("unknown value", jde_application_load(argv[1], &load, &application));
    load.size = 0;
    say("no size", jde_application_load(argv[1], &load, &application));
    load.size = UINT32_MAX;
    say("a size of no structure", jde_application_load(argv[1], &load, &application));
    load = (jde_load_options){.size = sizeof load, .reserved = 7};
    say("a reserved option", jde_application_load(argv[1], &load, &application));
    say("no place", jde_application_load(argv[1], NULL, NULL));

    /* A program of an older header has fewer options. */
    const char *mocks[] = {"goon"};
    load = (jde_load_options){.size = offsetof(jde_load_options, executable), .mocks = mocks, .mock_count = 1,
                              .executable = (const char *)1};
    say("older options", jde_application_load(argv[1], &load, &application));
    jde_start_options start = {.size = sizeof start, .flags = JDE_LOCKSTEP, .speed = -1.0};
    say("negative speed", jde_application_start(application, &start, &run));
    start.speed = 0.0;
    start.flags |= 64;
    say("unknown flag", jde_application_start(application, &start, &run));
    start.flags = JDE_LOCKSTEP;
    struct {
        jde_start_options start;
        uint64_t later;
    } newer = {{.size = sizeof newer, .flags = JDE_LOCKSTEP}, 1};
    say("unknown option", jde_application_start(application, &newer.start, &run));
    newer.later = 0;
    say("newer options", jde_application_start(application, &newer.start, &run));
    jde_run_close(run);
    say("start", jde_application_start(application, &start, &run));
    say("a run as an application", jde_application_start((jde_application *)run, NULL, &run));
    say("an application as a run", jde_run_step((jde_run *)application));
    say("close application", jde_application_close(application));
    say("close it again", jde_application_close(application));
    say("start a closed one", jde_application_start(application, &start, &run));

    double number;
    static jde_laser_scan scan;
    static narrow speeds;
    jde_twist twist;
    memset(&twist, 0, sizeof twist);
    say("before a value", jde_run_read(run, "pioneer.laser", &jde_laser_scan_type, &scan, NULL));
    say("until 1 s", jde_run_until(run, 1.0));
    say("read", jde_run_read(run, "pioneer.laser", &jde_laser_scan_type, &scan, NULL));
    uint32_t kind;
    char *record = NULL;
    say("no place for a kind", jde_run_next_record(run, NULL, &record, NULL));
    say("no place for a record", jde_run_next_record(run, &kind, NULL, NULL));
    say("the first record", jde_run_next_record(run, &kind, &record, NULL));
    printf("%s\n", record);
    jde_free_text(record);
    say("wrong name", jde_run_read(run, "pioneer.lazer", &jde_laser_scan_type, &scan, NULL));
    say("wrong type", jde_run_read(run, "pioneer.laser", &jde_twist_type, &twist, NULL));
    say("wrong layout", jde_run_read(run, "pioneer.velocity", &narrow_type, &speeds, NULL));
    say("no value", jde_run_read(run, "pioneer.laser", &jde_laser_scan_type, NULL, NULL));
    say("wrong field", jde_run_read_number(run, "pioneer.laser.range", &number));
    say("not a number", jde_run_read_number(run, "pioneer.laser", &number));
    say("wrong modulation", jde_run_write_number(run, "vff.a", 1.0));
    say("outside the limits", jde_run_write_number(run, "vff.ahead", -1.0));
    say("wrong unit", jde_run_write_text(run, "vff.ahead", "1 kg"));
    say("a port of a mock", jde_run_write(run, "goon.base", &jde_twist_type, &twist));
    say("no mock", jde_run_write(run, "vff.base", &jde_twist_type, &twist));
    say("wrong schema", jde_run_play(run, "nobody"));
    say("wrong group", jde_run_winner(run, "nobody", &(char *){NULL}));
    say("wrong condition", jde_run_until_condition(run, "vff.wins", 2.0));
    say("before now", jde_run_until(run, 0.5));
    say("no time", jde_run_until(run, NAN));
    say("not true", jde_run_until_condition(run, "time > 5", 2.0));
    say("true", jde_run_until_condition(run, "time > 2.2", 3.0));

    say("end", jde_run_end(run));
    say("end again", jde_run_end(run));
    say("step after the end", jde_run_step(run));
    say("until after the end", jde_run_until(run, 10.0));
    say("play after the end", jde_run_play(run, "goon"));
    say("write after the end", jde_run_write_number(run, "vff.ahead", 1.0));
    say("write as a mock after the end", jde_run_write(run, "goon.base", &jde_twist_type, &twist));
    say("edit after the end", jde_run_edit(run, "pioneer", "{ remove = 'lab door' }"));
    say("read after the end", jde_run_read_number(run, "pioneer.truth.pose.x", &number));
    say("close", jde_run_close(run));
    say("read after the close", jde_run_read_number(run, "pioneer.truth.pose.x", &number));
    say("close again", jde_run_close(run));
    say("null", jde_run_step(NULL));
    pthread_key_t key;
    pthread_t thread;
    pthread_key_create(&key, at_end);
    pthread_create(&thread, NULL, end_thread, &key);
    pthread_join(thread, NULL);
    return 0;
}
