/*
 * Drives the robot of an application in lockstep, and prints where it is.
 *
 *     cc lockstep.c -ljde -lm -o lockstep && ./lockstep apps/safe-navigation.toml
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include <jde_run.h>
#include <jde_types.h>

/* Ends the program with the library's words unless a call did what it was to do. */
static void require(int32_t status)
{
    if (status != JDE_OK) {
        fprintf(stderr, "%s\n", jde_error());
        exit(1);
    }
}

static void print_robot(jde_run *run)
{
    double time, x, y;
    char *winner;
    require(jde_run_time(run, &time));
    require(jde_run_read_number(run, "pioneer.truth.pose.x", &x));
    require(jde_run_read_number(run, "pioneer.truth.pose.y", &y));
    require(jde_run_winner(run, "example/base", &winner));
    printf("%6.3f s: the robot is at %.2f, %.2f m, and %s wins\n", time, x, y, winner);
    jde_free_text(winner);
}

/* Returns the least range of the laser, m. */
static float nearest(jde_run *run)
{
    static jde_laser_scan scan;
    jde_sample sample;
    require(jde_run_read(run, "pioneer.laser", &jde_laser_scan_type, &scan, &sample));
    float least = scan.range_max;
    for (uint32_t ray = 0; ray < scan.ranges.length; ray++) {
        if (scan.ranges.items[ray] < least) {
            least = scan.ranges.items[ray];
        }
    }
    printf("%6.3f s: scan %" PRIu64 " has %u ranges\n", (double)sample.time_ns / 1e9, sample.sequence, scan.ranges.length);
    return least;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: %s FILE\n", argv[0]);
        return 2;
    }
    jde_application *application;
    require(jde_application_load(argv[1], NULL, &application));
    const jde_start_options options = {.size = sizeof options, .flags = JDE_LOCKSTEP | JDE_WITH_SEED, .seed = 7};
    jde_run *run;
    require(jde_application_start(application, &options, &run));
    require(jde_application_close(application));

    require(jde_run_until(run, 5.0));
    print_robot(run);
    printf("          the nearest obstacle is %.2f m away\n", nearest(run));

    /* An operator's modulation, in force until it is released. */
    require(jde_run_write_text(run, "goon.fast", "10 cm/s"));
    require(jde_run_until(run, 10.0));
    print_robot(run);
    require(jde_run_release(run, "goon"));

    const int32_t reached = jde_run_until_condition(run, "vff.won", 60.0);
    require(reached == JDE_NOT_REACHED ? JDE_OK : reached);
    print_robot(run);

    unsigned selections = 0;
    uint32_t kind;
    char *record;
    while (jde_run_next_record(run, &kind, &record, NULL) == JDE_OK) {
        selections += kind == JDE_RECORD_DECISION;
        jde_free_text(record);
    }
    printf("          %u selections were recorded\n", selections);
    require(jde_run_close(run));
    return 0;
}
