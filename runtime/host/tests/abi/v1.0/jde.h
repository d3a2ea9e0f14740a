/*
 * The tables that cross the boundary, in C layout. Nothing of Rust's own layout (bool, enum, slice, String) appears here.
 *
 * Rules of this file, in the manner of CLAP:
 * - Tables only grow at the end; each begins with its `size`, which is also the stride of an array of such tables. A reader
 *   uses no field past the `size` it finds.
 * - A table given by a plugin, and all it points to, lives unchanged until the process ends (libraries are never unmapped).
 * - Texts are UTF-8 and end with a NUL. A null text pointer means an empty text.
 * - Whoever allocates frees. Nothing allocated on one side is freed by the other.
 * - No function unwinds: a panic or an exception is caught on the side where it arose.
 * - Calls for one instance never overlap, but may come from different threads one after another.
 *
 * Made from plugin/abi/src/raw.rs; `cargo xtask headers` renews it.
 */
#ifndef JDE_H
#define JDE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The first eight bytes of a jde_plugin: "JDEPLUG1" read as a little-endian number. */
#define JDE_MAGIC UINT64_C(0x3147554c5045444a)
/** Changes when a table changes in a way that old readers would misread. Host and plugin must have the same. */
#define JDE_ABI_MAJOR 1u
/** Grows when tables grow. A host accepts plugins of its own minor version and older. */
#define JDE_ABI_MINOR 0u

/** The symbol of type jde_plugin that every plugin exports. */
#define JDE_ENTRY_SYMBOL "jde_plugin"

/** Plugin flag: built so that a panic aborts the process; the host refuses it. */
#define JDE_PLUGIN_ABORTS 1u

/** It worked. */
#define JDE_OK 0
/** Nothing has been published on this port yet. */
#define JDE_NO_VALUE 1
/** The caller has no authority at this instant (R7), or an operator holds the child. Counted and shown; not a fault. */
#define JDE_REFUSED 2
/** The value holds a NaN or an infinity where a finite number is required. Counted and shown; not a fault. */
#define JDE_NOT_FINITE 3
/** No such port, child or group, or a call that this port does not allow. */
#define JDE_BAD_ARGUMENT 4
/** An optional port or child that the application left unbound. */
#define JDE_UNBOUND 5
/** The schema failed; the reason was given to jde_host.fail. */
#define JDE_FAILED 6
/** The schema panicked; the reason was given to jde_host.fail. */
#define JDE_PANICKED 7

/** Schema kind: turns data into better data. */
#define JDE_PERCEPTIVE 0u
/** Schema kind: has a precondition, competes, commands. */
#define JDE_MOTOR 1u
/** Schema kind: exports sensors and takes commands. */
#define JDE_DRIVER 2u

/** Schema state: costs no CPU; keeps its memory. */
#define JDE_SLEPT 0u
/** Schema state: awake, precondition false at the last check. */
#define JDE_CHECKING 1u
/** Schema state: awake, precondition true, not chosen. */
#define JDE_READY 2u
/** Schema state: iterates; a motor schema may command and wake children. */
#define JDE_WINNER 3u

/** Port kind: a variable of another schema that this one reads. */
#define JDE_IMPORT 0u
/** Port kind: a variable that this schema writes and any may read. */
#define JDE_EXPORT 1u
/** Port kind: an input that the father or an operator writes while the schema runs. */
#define JDE_MODULATION 2u
/** Port kind: an input of a driver that reaches an actuator. */
#define JDE_COMMAND 3u
/** Port kind: a driver's command that this motor schema writes. */
#define JDE_ACTUATOR 4u
/** Port kind: a modulation of a child that this schema writes. */
#define JDE_CHILD_MODULATION 5u

/** Port or child flag: the application may leave it unbound. */
#define JDE_OPTIONAL 1u
/** Import flag: a new value re-evaluates the precondition at once (R12), unless the application says otherwise. */
#define JDE_TRIGGER 2u
/** Modulation flag: read when the schema awakes; later writes count from the next awakening. */
#define JDE_FIXED 4u

/** Sample flag: no command is in force; the data is the neutral value. */
#define JDE_SAMPLE_NEUTRAL 1u
/** Sample flag: nobody has written this modulation; the data is its default. */
#define JDE_SAMPLE_DEFAULT 2u

/** Scalar kind: one byte, 0 or 1. */
#define JDE_BOOL 0u
/** Scalar kind: unsigned 8 bits. */
#define JDE_U8 1u
/** Scalar kind: unsigned 16 bits. */
#define JDE_U16 2u
/** Scalar kind: unsigned 32 bits. */
#define JDE_U32 3u
/** Scalar kind: unsigned 64 bits. */
#define JDE_U64 4u
/** Scalar kind: signed 8 bits. */
#define JDE_I8 5u
/** Scalar kind: signed 16 bits. */
#define JDE_I16 6u
/** Scalar kind: signed 32 bits. */
#define JDE_I32 7u
/** Scalar kind: signed 64 bits. */
#define JDE_I64 8u
/** Scalar kind: IEEE 754, 32 bits. */
#define JDE_F32 9u
/** Scalar kind: IEEE 754, 64 bits. */
#define JDE_F64 10u
/** Field kind: a structure with a jde_type of its own. */
#define JDE_STRUCT 11u

/** Field form: one element. */
#define JDE_ONE 0u
/** Field form: exactly `capacity` elements. */
#define JDE_ARRAY 1u
/**
 * Field form: up to `capacity` elements, their number a `uint32_t` at `length_offset`. Where the first element comes eight bytes
 * after that, the four bytes between belong to the number and mean nothing: so elements of any alignment leave no gap.
 */
#define JDE_SEQUENCE 2u
/** Field form: UTF-8 of up to `capacity` bytes, their number a `uint32_t` at `length_offset`. */
#define JDE_TEXT 3u
/** Field form: `capacity` bytes (JDE_U8) that mean nothing, where C would leave a gap; no description shows them. */
#define JDE_PADDING 4u

/** Log level: for the developer of this schema, in every iteration if need be. */
#define JDE_TRACE 0u
/** Log level: for the developer of this schema. */
#define JDE_DEBUG 1u
/** Log level: for whoever runs the application. */
#define JDE_INFO 2u
/** Log level: something is off, the schema goes on. */
#define JDE_WARN 3u
/** Log level: something failed. */
#define JDE_ERROR 4u

/** Selection case: exactly one READY. */
#define JDE_ALONE 0u
/** Selection case: two or more READY. */
#define JDE_COLLISION 1u
/** Selection case: none READY. */
#define JDE_ABSENCE 2u

/** Policy kind: the order in which the father names its children. */
#define JDE_POLICY_PRIORITY 0u
/** Policy kind: the highest number that a candidate offers. */
#define JDE_POLICY_URGENCY 1u
/** Policy kind: the winner stays for `dwell_ns` and until a rival is `hysteresis` more urgent. */
#define JDE_POLICY_STICKY 2u
/** Policy kind: each READY child in turn, `dwell_ns` each. */
#define JDE_POLICY_ROUND_ROBIN 3u
/** Policy kind: the father's own function. */
#define JDE_POLICY_FATHER 4u

typedef struct jde_context jde_context;
typedef struct jde_schema jde_schema;
typedef struct jde_port jde_port;
typedef struct jde_child jde_child;
typedef struct jde_type jde_type;
typedef struct jde_field jde_field;
typedef struct jde_sample jde_sample;
typedef struct jde_precondition jde_precondition;
typedef struct jde_level jde_level;
typedef struct jde_candidate jde_candidate;
typedef struct jde_verdict jde_verdict;
typedef struct jde_child_status jde_child_status;
typedef struct jde_host jde_host;

/** What the host knows of an instance; opaque to the plugin, and only valid inside a call of that instance. */
struct jde_context;

/**
 * What a plugin exports under the name `jde_plugin`.
 *
 * The host reads `magic`, `abi_major` and `abi_minor` before anything else; these three fields never move.
 */
struct jde_plugin {
    /** JDE_MAGIC. */
    uint64_t magic;
    /** JDE_ABI_MAJOR of the header the plugin was built with. */
    uint32_t abi_major;
    /** JDE_ABI_MINOR of the header the plugin was built with. */
    uint32_t abi_minor;
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_PLUGIN_ABORTS or 0. */
    uint32_t flags;
    /** Name of the plugin: lower-case letters, digits, `-`; the file is `lib<name>.so` with `-` written `_`. */
    const char *name;
    /** Version of the plugin, as its author counts. */
    const char *version;
    /** One sentence on what the plugin holds. */
    const char *doc;
    /** The schema types; stride is the first one's `size`. */
    const jde_schema *schemas;
    /** How many. */
    uint32_t schema_count;
    /** 0. */
    uint32_t reserved;
};

/** A type of schema: what it is, what it reads and writes, and the functions of its instances. */
struct jde_schema {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_PERCEPTIVE, JDE_MOTOR or JDE_DRIVER. */
    uint32_t kind;
    /** Name of the type: lower-case letters, digits, `-`, `_`. */
    const char *name;
    /** What it does; the first line is a sentence of its own. */
    const char *doc;
    /** Default period of its iterations, ns; at least 1. */
    uint64_t period_ns;
    /** Longest an iteration may take, ns; 0 means the period. */
    uint64_t budget_ns;
    /** Its ports; a port is named in calls by its place here. Stride is the first one's `size`. */
    const jde_port *ports;
    /** The roles of its children; a child is named in calls by its place here. Stride is the first one's `size`. */
    const jde_child *children;
    /** How many ports. */
    uint32_t port_count;
    /** How many children. */
    uint32_t child_count;
    /** Makes an instance, SLEPT. Called once, before any other. Null on failure, with the reason given to jde_host.fail. */
    void *(*create)(const jde_schema *, const jde_host *, jde_context *);
    /** Ends an instance that is SLEPT. Called once, after any other. May be null. */
    void (*destroy)(void *);
    /** It leaves SLEPT: before its first check or iteration. May be null. */
    int32_t (*awake)(void *, jde_context *);
    /** Evaluates the precondition of a motor schema. Null: always READY. */
    int32_t (*check)(void *, jde_context *, jde_precondition *);
    /** One iteration, as WINNER. Must return within the budget. */
    int32_t (*iterate)(void *, jde_context *);
    /** The father's own arbitration (R4). Null: the schema has none. */
    int32_t (*arbitrate)(void *, jde_context *, const jde_level *, jde_verdict *);
    /** It goes to SLEPT: after its last iteration. A driver stops its actuators here. May be null. */
    void (*sleep)(void *, jde_context *);
    /** An optional ability by its id, such as "jde.panel"; null where it has none. May be null. */
    const void *(*ability)(const char *);
};

/** An input or output of a schema type. */
struct jde_port {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_IMPORT, JDE_EXPORT, JDE_MODULATION, JDE_COMMAND, JDE_ACTUATOR or JDE_CHILD_MODULATION. */
    uint32_t kind;
    /** Its name, unique among ports of this kind (and child); for JDE_CHILD_MODULATION that of the child's modulation. */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Unit of a plain number ("m", "rad/s"); empty for none, or where the type's fields have their own. */
    const char *unit;
    /** Type of its value. */
    const jde_type *value_type;
    /** Default of a modulation or neutral value of a command, `value_type->bytes` bytes; else null. */
    const void *initial;
    /** Least allowed value of a number given as a modulation; NaN for none. */
    double min;
    /** Greatest allowed value of a number given as a modulation; NaN for none. */
    double max;
    /** How long a command is in force without being repeated, ns; for JDE_COMMAND only, at least 1. */
    uint64_t validity_ns;
    /** JDE_OPTIONAL, JDE_TRIGGER, JDE_FIXED. */
    uint32_t flags;
    /** The child whose modulation this is; for JDE_CHILD_MODULATION only. */
    uint32_t child;
};

/** A role that a schema type has for a child; the application says which instance plays it. */
struct jde_child {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_PERCEPTIVE or JDE_MOTOR. */
    uint32_t kind;
    /** Name of the role. */
    const char *name;
    /** Name of the group in which a motor child competes; children of one group have one winner. */
    const char *group;
    /** What the child is for. */
    const char *doc;
    /** JDE_OPTIONAL. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/** A type of value: plain data of fixed size, every bit pattern valid, every byte described. */
struct jde_type {
    /** Bytes of this table. */
    uint32_t size;
    /** How many fields. */
    uint32_t field_count;
    /** Name, as ROS 2 writes it: "sensor_msgs/msg/LaserScan". Types are the same when names and layouts are the same. */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Bytes of a value. */
    uint64_t bytes;
    /** Alignment of a value, at most 16. */
    uint64_t align;
    /** The fields, in the order of their ROS interface; stride is the first one's `size`. */
    const jde_field *fields;
};

/** A field of a jde_type. */
struct jde_field {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_BOOL to JDE_F64, or JDE_STRUCT. */
    uint32_t kind;
    /** JDE_ONE, JDE_ARRAY, JDE_SEQUENCE, JDE_TEXT or JDE_PADDING. */
    uint32_t form;
    /** Most elements; 1 for JDE_ONE. */
    uint32_t capacity;
    /** Name of the field. */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Unit ("m", "rad"); empty for none. */
    const char *unit;
    /** Bytes from the start of the value to the first element. */
    uint64_t offset;
    /** Bytes from the start of the value to the number of elements; for JDE_SEQUENCE and JDE_TEXT only. */
    uint64_t length_offset;
    /** Type of the elements; for JDE_STRUCT only. */
    const jde_type *value_type;
};

/** A value as a port shows it; the data stays as it is until the present call of the instance returns. */
struct jde_sample {
    /** The value. */
    const void *data;
    /** Its size. */
    uint64_t bytes;
    /** When it was measured or written, ns since the application's start. */
    uint64_t time_ns;
    /** Counts the values of this variable from 1. */
    uint64_t sequence;
    /** Who wrote it: the number of an instance in this application. */
    uint32_t writer;
    /** JDE_SAMPLE_NEUTRAL, JDE_SAMPLE_DEFAULT. */
    uint32_t flags;
};

/** The answer to a check. */
struct jde_precondition {
    /** Bytes of this table. */
    uint32_t size;
    /** 1 if the precondition holds, else 0. */
    uint32_t ready;
    /** How urgent it is to win, for policies that ask; any finite number, 0 by default. */
    double urgency;
};

/** The snapshot of a group given to the father's own arbitration. */
struct jde_level {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_COLLISION or JDE_ABSENCE. */
    uint32_t case_;
    /** Name of the group. */
    const char *group;
    /** Awake children of the group, in the father's order; stride is the first one's `size`. */
    const jde_candidate *candidates;
    /** How many. */
    uint32_t candidate_count;
    /** The child that is WINNER now, -1 for none. */
    int32_t winner;
};

/** A child that competes. */
struct jde_candidate {
    /** Bytes of this table. */
    uint32_t size;
    /** Its role: its place in jde_schema.children. */
    uint32_t child;
    /** JDE_CHECKING, JDE_READY or JDE_WINNER. */
    uint32_t state;
    /** 1 if its precondition held at its last check. */
    uint32_t ready;
    /** What it offered at its last check. */
    double urgency;
};

/** The father's answer. */
struct jde_verdict {
    /** Bytes of this table. */
    uint32_t size;
    /** The chosen child, -1 for nobody. */
    int32_t child;
    /** Why, in words; ends with a NUL. */
    char reason[128];
};

/** What a father sees of a child. */
struct jde_child_status {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_SLEPT, JDE_CHECKING, JDE_READY or JDE_WINNER. */
    uint32_t state;
    /** 1 while it is Faulted. */
    uint32_t faulted;
    /** 0. */
    uint32_t reserved;
};

/**
 * What the host offers to an instance. Every function is called with the jde_context of the present call, on its thread,
 * and only until that call returns. None blocks.
 */
struct jde_host {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_ABI_MAJOR of the host. */
    uint32_t abi_major;
    /** JDE_ABI_MINOR of the host. */
    uint32_t abi_minor;
    /** 0. */
    uint32_t reserved;
    /**
     * The value of an import, modulation or command. The same value throughout a check and the iteration that follows it (R8).
     * JDE_NO_VALUE, JDE_UNBOUND, JDE_BAD_ARGUMENT.
     */
    int32_t (*read)(jde_context *, uint32_t port, jde_sample *);
    /**
     * Room to write the next value of an export, actuator or child's modulation, aligned for its type; its bytes hold
     * anything. Nobody sees it before `publish`; a loan that is not published by the end of the call is dropped.
     * JDE_UNBOUND, JDE_BAD_ARGUMENT.
     */
    int32_t (*loan)(jde_context *, uint32_t port, void **);
    /** Publishes what was loaned, measured at `time_ns` (0: now). JDE_REFUSED and JDE_NOT_FINITE for commands, JDE_BAD_ARGUMENT. */
    int32_t (*publish)(jde_context *, uint32_t port, uint64_t time_ns);
    /** Wakes a child (R7). Waking one that is awake changes nothing. JDE_REFUSED, JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*wake)(jde_context *, uint32_t child);
    /** Puts a child and its subtree to sleep. JDE_REFUSED, JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*sleep)(jde_context *, uint32_t child);
    /** What a child is doing. JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*child)(jde_context *, uint32_t child, jde_child_status *);
    /**
     * Changes the policy of a group of children, named by one of them: JDE_POLICY_PRIORITY to JDE_POLICY_FATHER,
     * with its dwell or turn and its hysteresis.
     */
    int32_t (*set_policy)(jde_context *, uint32_t child, uint32_t policy, uint64_t dwell_ns, double hysteresis);
    /** ns since the application's start; stands still during a call in lockstep. */
    uint64_t (*now)(jde_context *);
    /** A number that depends on the application's seed and the instance's name alone. */
    uint64_t (*seed)(jde_context *);
    /** A number that instances of one running application share and no other application of this process has. */
    uint64_t (*application)(jde_context *);
    /** The instance's name in the application; lives as long as the instance. */
    const char *(*name)(jde_context *);
    /** Says something to whoever listens; `text` is `length` bytes of UTF-8. */
    void (*log)(jde_context *, uint32_t level, const char *text, uint64_t length);
    /** Gives the reason for the error that this call is about to return; `text` is `length` bytes of UTF-8. */
    void (*fail)(jde_context *, const char *text, uint64_t length);
    /** An extension of the host by its id; null where it has none. */
    const void *(*extension)(jde_context *, const char *id);
};

/*
 * What follows is for authors in C and C++: macros that fill tables, and functions that use the host's.
 */

#if defined(__GNUC__)
#define JDE_VISIBLE __attribute__((visibility("default")))
#else
#define JDE_VISIBLE
#endif

/** How many elements an array has. */
#define JDE_COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
/** Milliseconds in ns. */
#define JDE_MS(number) ((uint64_t)(number) * UINT64_C(1000000))
/** No least or greatest value. */
#define JDE_UNBOUNDED ((double)NAN)

/** Exports the plugin: its name, its version, one sentence, and its array of jde_schema. Once in a library. */
#define JDE_PLUGIN(name, version, doc, schemas)                                                             \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), 0u, name, version, doc,      \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    {(uint32_t)sizeof(jde_port), JDE_IMPORT, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u}
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    {(uint32_t)sizeof(jde_port), JDE_EXPORT, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u}
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    {(uint32_t)sizeof(jde_port), JDE_MODULATION, name, doc, unit, &(type), &(initial), min, max, 0u, flags, 0u}
/** A jde_port of a driver that reaches an actuator; `neutral` is a static const value that stops it. */
#define JDE_PORT_COMMAND(name, doc, type, neutral, validity_ns)                                      \
    {(uint32_t)sizeof(jde_port), JDE_COMMAND, name, doc, "", &(type), &(neutral), JDE_UNBOUNDED, JDE_UNBOUNDED, \
     validity_ns, 0u, 0u}
/** A jde_port that writes a driver's command. */
#define JDE_PORT_ACTUATOR(name, doc, type, flags) \
    {(uint32_t)sizeof(jde_port), JDE_ACTUATOR, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u}
/** A jde_port that writes the modulation `name` of the child of this number. */
#define JDE_PORT_CHILD_MODULATION(child, name, doc, type, flags)                                             \
    {(uint32_t)sizeof(jde_port), JDE_CHILD_MODULATION, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, \
     0u, flags, child}

/** A jde_child that competes in a group. */
#define JDE_CHILD_MOTOR(name, group, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_MOTOR, name, group, doc, flags, 0u}
/** A jde_child that helps. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Whether this header's functions may be used on a host: to be asked in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= sizeof(jde_host) && host->abi_major == JDE_ABI_MAJOR;
}

/** The value of an import, modulation or command of `bytes` bytes; NULL if there is none. `sample` may be NULL. */
static inline const void *jde_get(const jde_host *host, jde_context *context, uint32_t port, size_t bytes,
                                  jde_sample *sample)
{
    jde_sample own;
    jde_sample *seen = sample != NULL ? sample : &own;
    if (host->read(context, port, seen) != JDE_OK || seen->bytes != bytes) {
        return NULL;
    }
    return seen->data;
}

/** Writes `bytes` bytes to an export, actuator or child's modulation; answers as jde_host.publish does. */
static inline int32_t jde_put(const jde_host *host, jde_context *context, uint32_t port, const void *value,
                              size_t bytes)
{
    void *room = NULL;
    int32_t code = host->loan(context, port, &room);
    if (code != JDE_OK) {
        return code;
    }
    memcpy(room, value, bytes);
    return host->publish(context, port, 0u);
}

/** Says something to whoever listens. */
static inline void jde_say(const jde_host *host, jde_context *context, uint32_t level, const char *text)
{
    host->log(context, level, text, strlen(text));
}

/** Gives the reason for a failure: `return jde_failed(host, context, "the cable is loose");`. */
static inline int32_t jde_failed(const jde_host *host, jde_context *context, const char *reason)
{
    host->fail(context, reason, strlen(reason));
    return JDE_FAILED;
}

#ifdef __cplusplus
}
#endif

#endif
