/* Holds a schema asleep under a lease, and prints when it ends. */
#include <stdio.h>
#include <stdlib.h>

#include <jde_run.h>

static void require(int32_t status)
{
    if (status != JDE_OK) {
        fprintf(stderr, "%s\n", jde_error());
        exit(1);
    }
}

static void print(jde_run *run)
{
    double time, ahead;
    uint32_t state;
    require(jde_run_time(run, &time));
    require(jde_run_state(run, "goon", &state));
    require(jde_run_read_number(run, "vff.ahead", &ahead));
    printf("%.3f s: goon %s, ahead %.2f m\n", time, state == JDE_SLEPT ? "sleeps" : "is awake", ahead);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    jde_application *application;
    jde_run *run;
    require(jde_application_load(argv[1], NULL, &application));
    const jde_start_options options = {.size = sizeof options, .flags = JDE_LOCKSTEP};
    require(jde_application_start(application, &options, &run));
    require(jde_run_until(run, 1.0));
    print(run);
    require(jde_run_lease(run, 0.5));
    require(jde_run_stop(run, "goon"));
    require(jde_run_write_text(run, "vff.ahead", "90 cm"));
    require(jde_run_until(run, 1.4));
    print(run);
    require(jde_run_lease(run, 0.5));
    require(jde_run_until(run, 1.89));
    print(run);
    require(jde_run_until(run, 2.1));
    print(run);
    require(jde_run_stop(run, "goon"));
    require(jde_run_until(run, 9.0));
    print(run);
    /* A lease that ends while nothing is held is over as well. */
    require(jde_run_release(run, "goon"));
    require(jde_run_release(run, "vff"));
    require(jde_run_lease(run, 0.5));
    require(jde_run_until(run, 10.0));
    require(jde_run_stop(run, "goon"));
    require(jde_run_until(run, 11.0));
    print(run);
    require(jde_run_close(run));
    require(jde_application_close(application));
    return 0;
}
