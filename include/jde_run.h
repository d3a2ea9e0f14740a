/*
 * Programs that run applications: libjde.so. docs/embedding.md explains it, and examples/embed shows it.
 *
 * Rules of this file:
 * - A function returns a status: `JDE_OK`, or another number of this file or of `jde.h`; then jde_error() states in words
 *   what was wrong, with the file and the line if there is one.
 * - Every function may be called from any thread, several at once, and in any order. Nothing of the program runs on a
 *   thread of the robot, and no thread of a robot waits for the program. A function that blocks says so.
 * - A handle is a number, not an address. A call with one that was closed returns JDE_NO_HANDLE.
 * - Texts are UTF-8 and end with a NUL. A text that the library returns is freed by jde_free_text().
 * - Pointers to what a function fills in are not null, unless it says so, and are not kept. A `jde_type` that a program
 *   passes stays unchanged until the process ends, as those of `jde_types.h` do.
 * - Times are in seconds since the application's start.
 * - Options grow only at the end, and state their own size; what a program does not know is zero, and what the library does
 *   not know must be. Functions are only added: a program runs with every newer library of the same name.
 * - The library installs no handler of signals, prints nothing, and never ends the process.
 *
 * Generated from programs/c/src; `cargo xtask headers` renews it.
 */
#ifndef JDE_RUN_H
#define JDE_RUN_H

#include "jde.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Increases when functions or options are added. */
#define JDE_LIBRARY_MINOR 1u

/** Status: the application has ended, and time passes no more. */
#define JDE_ENDED 32
/** Status: the time was reached before the condition was true, or nothing is due any more. */
#define JDE_NOT_REACHED 33
/** Status: the handle was closed, or is none. */
#define JDE_NO_HANDLE 34

/**
 * Start flag: time passes only in jde_run_step() and in the functions jde_run_until..., and a seed gives one run. Without
 * it, the application runs in real time on threads of its own.
 */
#define JDE_LOCKSTEP 1u
/** Start flag: jde_start_options.seed takes the place of the seed of the file. */
#define JDE_WITH_SEED 2u
/** Start flag: records and conditions are not available, and time passes faster in lockstep. */
#define JDE_WITHOUT_RECORDS 4u

/** Record: a selection, with its reason. */
#define JDE_RECORD_DECISION 1u
/** Record: a schema changed its state. */
#define JDE_RECORD_STATE 2u
/** Record: any other event. */
#define JDE_RECORD_EVENT 3u

typedef struct jde_application jde_application;
typedef struct jde_run jde_run;
typedef struct jde_load_options jde_load_options;
typedef struct jde_start_options jde_start_options;

/** An application that was loaded and checked; a handle. */
struct jde_application;

/** A started application; a handle. */
struct jde_run;

/** How to load an application. Without it, the file alone counts. */
struct jde_load_options {
    /** Bytes of this structure. */
    uint32_t size;
    /** The number of `values`. */
    uint32_t value_count;
    /**
     * Values in place of those of the file, as `jde run --set` takes them: "goon.fast=30 cm/s". A path in one starts in
     * the working directory.
     */
    const char *const *values;
    /** Schemas that are not called: the program writes what they export and command. */
    const char *const *mocks;
    /** The number of `mocks`. */
    uint32_t mock_count;
    /** Zero. */
    uint32_t reserved;
    /**
     * The executable `jde`, which inspects plugins and runs isolated schemas, or null: then `bin/jde` of the library's
     * prefix, the one beside the library, or that of the `PATH`, whichever is found first.
     */
    const char *executable;
};

/** How to start an application. Without it, it starts in real time. */
struct jde_start_options {
    /** Bytes of this structure. */
    uint32_t size;
    /** JDE_LOCKSTEP, JDE_WITH_SEED, JDE_WITHOUT_RECORDS. */
    uint32_t flags;
    /** The seed of all random generators. */
    uint64_t seed;
    /** The time at which the application ends, s; 0 for none. */
    double limit;
    /** Seconds of the application per second of the machine, in real time; 0 for 1. */
    double speed;
    /** The name under which the program acts as an operator, in records; null for "program". */
    const char *name;
};

/**
 * Returns what was wrong with the last call of this thread that did not return `JDE_OK`. The text is valid until
 * this thread makes another call. In a destructor of a thread that ends, it is empty.
 */
const char *jde_error(void);

/** Frees a text that the library returned. Null is nothing. */
void jde_free_text(char *text);

/**
 * Returns the version of the library: the number in its name times 65536, plus `JDE_LIBRARY_MINOR` of its header. A
 * function or an option of a later header than the library's does not exist.
 */
uint32_t jde_library_version(void);

/**
 * Loads and checks the application of a file, and loads its plugins. `options` may be null. Blocks while files are read.
 * `JDE_FAILED`: jde_error() lists all faults, each with its file and line.
 */
int32_t jde_application_load(const char *file, const jde_load_options *options, jde_application **application);

/** Returns what is absent at present, such as a device that is not plugged in: one per line; an empty text if nothing is. */
int32_t jde_application_warnings(jde_application *application, char **text);

/**
 * Starts an application at time 0; any number of times, also while earlier runs go on. `options` may be null. Blocks
 * while instances are made. The run needs the handle of the application no more.
 */
int32_t jde_application_start(jde_application *application, const jde_start_options *options, jde_run **run);

/** Closes an application. Its runs go on. */
int32_t jde_application_close(jde_application *application);

/**
 * Runs the next instant in lockstep: everything that is due then. `JDE_ENDED` if the application has ended;
 * `JDE_NOT_REACHED` if nothing is due any more. Blocks while the schemas compute.
 */
int32_t jde_run_step(jde_run *run);

/**
 * Lets time pass in lockstep, or waits in real time, until a time, s; `INFINITY` for no end. `JDE_ENDED` if the
 * application ends before. Blocks meanwhile; several threads may wait.
 */
int32_t jde_run_until(jde_run *run, double time);

/**
 * The same until a condition is true, as `jde run --break` takes it: "vff.won and clearance < 0.2". In lockstep it is
 * looked at after each instant, in real time a hundred times a second and after each change of a state.
 * `JDE_NOT_REACHED` if the time comes first.
 */
int32_t jde_run_until_condition(jde_run *run, const char *condition, double time);

/** Returns the time, s. */
int32_t jde_run_time(jde_run *run, double *time);

/**
 * Returns how the application ended: "done" or "failed" for its mission, "time up", "stopped", or "broken: " with the
 * reason. `JDE_NO_VALUE` while it runs.
 */
int32_t jde_run_outcome(jde_run *run, char **text);

/**
 * Ends the application and brings it to rest: actuators first, then all schemas in order. Blocks until it is at rest,
 * at most a second for each schema that does not return; threads that wait for the run return `JDE_ENDED`. Variables
 * and records can still be read.
 */
int32_t jde_run_end(jde_run *run);

/** Ends the application as jde_run_end() does, and closes the handle. */
int32_t jde_run_close(jde_run *run);

/**
 * Copies the newest value of a variable, such as "pioneer.laser", into `value`, which has the type `type`: a
 * `jde_laser_scan` with `&jde_laser_scan_type`. Elements of sequences beyond their length stay as they are. `sample`
 * may be null, and gets the time and the number of the value. `JDE_NO_VALUE` without one; `JDE_BAD_ARGUMENT` for another
 * type or layout. It does not block, and a value is never torn.
 */
int32_t jde_run_read(jde_run *run, const char *name, const jde_type *value_type, void *value, jde_sample *sample);

/**
 * Returns a number of a variable by its path: "pioneer.odometry.pose.x", "pioneer.laser.ranges[3]". True is 1.
 * `JDE_NO_VALUE` without a value. It does not block.
 */
int32_t jde_run_read_number(jde_run *run, const char *path, double *number);

/**
 * Returns a variable or a part of it as a text; a text as it is, anything else as tools show it. `JDE_NO_VALUE` without a
 * value. It does not block.
 */
int32_t jde_run_read_text(jde_run *run, const char *path, char **text);

/** Returns the description of the type of a variable. It is valid until the process ends. */
int32_t jde_run_type(jde_run *run, const char *name, const jde_type **value_type);

/**
 * Writes a modulation as an operator (R14), or what a mock exports or commands. The value is copied.
 * `JDE_BAD_ARGUMENT` for another type or layout; `JDE_REFUSED` for a value outside the limits, and after the end. It does
 * not block.
 */
int32_t jde_run_write(jde_run *run, const char *name, const jde_type *value_type, const void *value);

/** Writes a modulation, a period ("goon.period", s) or what a mock exports that is one number. */
int32_t jde_run_write_number(jde_run *run, const char *name, double number);

/** Writes the same from a text, as an application file states it: "30 cm/s", "{ linear = { x = 0.2 } }". */
int32_t jde_run_write_text(jde_run *run, const char *name, const char *value);

/** Returns the winner of a group, such as "roots" or "example/base". `JDE_NO_VALUE` if nobody wins. */
int32_t jde_run_winner(jde_run *run, const char *group, char **text);

/** Returns the state of a schema: `JDE_SLEPT`, `JDE_CHECKING`, `JDE_READY` or `JDE_WINNER`. */
int32_t jde_run_state(jde_run *run, const char *schema, uint32_t *state);

/** Returns the state of every schema and group as JSON: `hierarchy` of docs/protocol.md. */
int32_t jde_run_snapshot(jde_run *run, char **text);

/**
 * Removes the oldest record that the program has not taken, and returns its kind and its JSON, in the form of
 * docs/recordings.md. `JDE_NO_VALUE` if there is none. Of each kind, 100 000 records wait; `dropped` may be null, and gets
 * how many were dropped since the last call.
 */
int32_t jde_run_next_record(jde_run *run, uint32_t *kind, char **text, uint64_t *dropped);

/**
 * Wakes a schema as its father would. As every action of an operator (R14), it lasts until it is released, or until the
 * lease ends. `JDE_REFUSED` with the reason; likewise below.
 */
int32_t jde_run_play(jde_run *run, const char *schema);

/** Puts a schema to sleep until it is released. */
int32_t jde_run_stop(jde_run *run, const char *schema);

/** Makes a schema the winner of its group while it is awake. */
int32_t jde_run_force(jde_run *run, const char *schema);

/** Undoes what operators did to a schema, and restores the modulations that they wrote. */
int32_t jde_run_release(jde_run *run, const char *schema);

/** Stops all schemas at once, and makes every command neutral, until jde_run_release_all(). No lease ends that. */
int32_t jde_run_stop_all(jde_run *run);

/** Undoes jde_run_stop_all(), whoever stopped everything. */
int32_t jde_run_release_all(jde_run *run);

/**
 * Gives all that the program holds as an operator a lease of so many seconds of the application from now on, so that a
 * program that hangs holds nothing any more. Call it again within the lease to renew it. After its end, what was held
 * is undone, and later actions have no lease until this is called again. 0 removes the lease.
 */
int32_t jde_run_lease(jde_run *run, double seconds);

/** Changes the world of a simulated robot by the name of its driver, in TOML: "{ remove = 'door' }" (docs/simulator.md). */
int32_t jde_run_edit(jde_run *run, const char *driver, const char *edits);

#ifdef __cplusplus
}
#endif

#endif
