/*
 * Calls from several threads at once: two runs in lockstep and one in real time, read and operated meanwhile. Prints where
 * each run in lockstep ended.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include <jde_run.h>
#include <jde_types.h>

static atomic_int over;

static void require(int32_t status)
{
    if (status != JDE_OK) {
        fprintf(stderr, "%d %s\n", (int)status, jde_error());
        exit(1);
    }
}

/* A reader accepts what the end of a run brings, and nothing else. */
static void accept(int32_t status)
{
    if (status != JDE_NO_VALUE && status != JDE_NO_HANDLE && status != JDE_REFUSED) {
        require(status);
    }
}

static void *drive(void *run)
{
    require(jde_run_until(run, 20.0));
    return NULL;
}

static void *watch(void *run)
{
    jde_laser_scan *scan = calloc(1, sizeof *scan);
    while (!atomic_load(&over)) {
        char *text = NULL;
        uint32_t kind;
        accept(jde_run_read(run, "pioneer.laser", &jde_laser_scan_type, scan, NULL));
        accept(jde_run_next_record(run, &kind, &text, NULL));
        jde_free_text(text);
        text = NULL;
        accept(jde_run_snapshot(run, &text));
        jde_free_text(text);
    }
    free(scan);
    return NULL;
}

static void *wait_for_end(void *run)
{
    return jde_run_until(run, INFINITY) == JDE_ENDED ? run : NULL;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    jde_application *application;
    require(jde_application_load(argv[1], NULL, &application));
    const jde_start_options lockstep = {.size = sizeof lockstep, .flags = JDE_LOCKSTEP | JDE_WITH_SEED, .seed = 3};
    jde_run *runs[3];
    require(jde_application_start(application, &lockstep, &runs[0]));
    require(jde_application_start(application, &lockstep, &runs[1]));
    require(jde_application_start(application, NULL, &runs[2]));

    pthread_t drivers[2], watchers[3], waiters[2];
    for (int each = 0; each < 3; each++) {
        pthread_create(&watchers[each], NULL, watch, runs[each]);
    }
    for (int each = 0; each < 2; each++) {
        pthread_create(&drivers[each], NULL, drive, runs[each]);
        pthread_create(&waiters[each], NULL, wait_for_end, runs[2]);
    }
    for (int each = 0; each < 2; each++) {
        pthread_join(drivers[each], NULL);
        double x, y;
        require(jde_run_read_number(runs[each], "pioneer.truth.pose.x", &x));
        require(jde_run_read_number(runs[each], "pioneer.truth.pose.y", &y));
        printf("%.17g %.17g\n", x, y);
    }
    /* A run in real time can end while others wait for it and read it. */
    require(jde_run_close(runs[2]));
    for (int each = 0; each < 2; each++) {
        void *ended = NULL;
        pthread_join(waiters[each], &ended);
        printf("%s\n", ended != NULL ? "ended" : "no end");
    }
    atomic_store(&over, 1);
    for (int each = 0; each < 3; each++) {
        pthread_join(watchers[each], NULL);
    }
    require(jde_run_close(runs[0]));
    require(jde_run_close(runs[1]));
    require(jde_application_close(application));
    return 0;
}
