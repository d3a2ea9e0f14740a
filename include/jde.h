/*
 * The tables that cross the boundary, in C layout. Nothing of Rust's own layout (bool, enum, slice, String) appears here.
 *
 * Rules of this file, in the manner of CLAP:
 * - Tables only grow at the end; each begins with its `size`, which is also the stride of an array of such tables.
 * - Whoever reads a table takes what the shorter of the two has, its `size` or the reader's own: what is missing counts as 0 or
 *   null, what is beyond means nothing. One that is shorter than in the minor version that brought it is refused.
 * - Whoever fills in a table that the other side lent (jde_precondition, jde_verdict, jde_child_status) fills in no more than its
 *   `size` says, and leaves that as it is.
 * - A function that a minor version brought is beyond the `size`, or null, in a host that has it not: look before use.
 * - A host takes plugins of every minor version of its major one, older and newer. What it does not know it ignores where that is
 *   a field or a flag, and refuses by name where it is a kind.
 * - jde_sample alone states no size, for it is filled in at every read: its 40 bytes never change, and whatever else there
 *   may be to say of a value is asked for by a function of its own.
 * - A table given by a plugin, and all it points to, lives unchanged until the process ends (libraries are never unmapped).
 * - Texts are UTF-8 and end with a NUL. A null text pointer means an empty text.
 * - Whoever allocates frees. Nothing allocated on one side is freed by the other.
 * - No function unwinds: a panic or an exception is caught on the side where it arose.
 * - Calls for one instance never overlap, but may come from different threads one after another.
 *
 * Made from crates/abi/src/raw/mod.rs; `cargo xtask headers` renews it.
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
/**
 * Grows when tables grow or an ability comes. Hosts up to 1.3 took plugins of their own minor version and older; later ones take
 * all.
 */
#define JDE_ABI_MINOR 5u

/** The symbol of type jde_plugin that every plugin exports. */
#define JDE_ENTRY_SYMBOL "jde_plugin"

/** Plugin flag: built so that a panic aborts the process; the host refuses it. */
#define JDE_PLUGIN_ABORTS 1u
/** Plugin flag: none of its functions lets an exception of C++ out. Since minor version 4. */
#define JDE_PLUGIN_CATCHES 2u

/** It worked. */
#define JDE_OK 0
/** Nothing has been published on this port yet. */
#define JDE_NO_VALUE 1
/**
 * The caller has no authority at this instant (R7), or an operator holds the child. Counted and shown; not a fault. Any function
 * that shows or changes something answers so, uncounted, to a call that hung and was given up: it should return.
 */
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

/**
 * The number is outside of what the child's modulation takes (R8). Counted and shown; not a fault. Since minor version 4: whoever
 * was built before is told JDE_NOT_FINITE.
 */
#define JDE_OUT_OF_RANGE 8

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
/** Modulation flag: taken when the schema awakes, and kept until it sleeps; later writes count from the next awakening (R8). */
#define JDE_FIXED 4u
/** Child flag, of the last child only: any number of motor children, named and grouped by the application, numbered from here on. */
#define JDE_MANY 8u

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

/** The id of the ability, whose table is a jde_panel. Since minor version 2, as all that belongs to it. */
#define JDE_ABILITY_PANEL "jde.panel"

/** Widget: a text in `label`; `number` says how it matters, JDE_WORDS_PLAIN to JDE_WORDS_CODE. */
#define JDE_WIDGET_TEXT 0u
/** Widget: a number `value` with its name in `label` and its `unit`. */
#define JDE_WIDGET_VALUE 1u
/** Widget: something to press, with `id` and `label`. JDE_DISABLED. */
#define JDE_WIDGET_BUTTON 2u
/** Widget: something that is on or off, with `id` and `label`; `number` is 1 for on. */
#define JDE_WIDGET_TOGGLE 3u
/** Widget: a number to move, with `id`, `label`, `value`, `least`, `greatest`, `unit`. */
#define JDE_WIDGET_SLIDER 4u
/** Widget: one of several, with `id`, `label`, the `texts`, and in `number` the place of the present one. */
#define JDE_WIDGET_CHOICE 5u
/** Widget: an image, with `id`, `pixels`, `width`, `height`, `channels`. JDE_WANTS_CLICKS, JDE_WANTS_DRAGS, JDE_WANTS_KEYS. */
#define JDE_WIDGET_IMAGE 6u
/** Widget: a table, with `id`; `texts` are the heads of its `number` columns and then the cells, row by row. */
#define JDE_WIDGET_TABLE 7u
/** Widget: the widgets up to its jde_pen.end, beside each other. */
#define JDE_WIDGET_ROW 8u
/** Widget: the widgets up to its jde_pen.end below `label`, with `id`. JDE_FOLDED. */
#define JDE_WIDGET_GROUP 9u
/**
 * Widget: curves, with `id` and `label`; `texts` are what its two axes show, across and up. Up to its jde_pen.end come only
 * shapes of JDE_SHAPE_LINE, each with its name in `text`.
 */
#define JDE_WIDGET_PLOT 10u
/**
 * Widget: a plane in metres, with `id`; up to its jde_pen.end come shapes with two numbers a point. It begins with `area` in
 * view if that is not empty. JDE_FORWARD_UP, JDE_WANTS_CLICKS, JDE_WANTS_DRAGS, JDE_WANTS_KEYS.
 */
#define JDE_WIDGET_CANVAS 11u
/**
 * Widget: a space in metres, with `id`, in the frame of REP-105 that `label` names; up to its jde_pen.end come shapes with
 * three numbers a point. JDE_WANTS_CLICKS, JDE_WANTS_DRAGS, JDE_WANTS_KEYS.
 */
#define JDE_WIDGET_SCENE 12u

/** Words: as they are. */
#define JDE_WORDS_PLAIN 0u
/** Words: a heading. */
#define JDE_WORDS_HEADING 1u
/** Words: less than the rest. */
#define JDE_WORDS_FAINT 2u
/** Words: all is well. */
#define JDE_WORDS_GOOD 3u
/** Words: something is off. */
#define JDE_WORDS_WARNING 4u
/** Words: something failed. */
#define JDE_WORDS_ERROR 5u
/** Words: letters of one width. */
#define JDE_WORDS_CODE 6u

/** Widget flag: hands clicks back. */
#define JDE_WANTS_CLICKS 1u
/** Widget flag: hands drags back; without it a drag moves the view. */
#define JDE_WANTS_DRAGS 2u
/** Widget flag: hands keys back while it has the focus. */
#define JDE_WANTS_KEYS 4u
/** Widget flag: shown with x up and y to the left, as a robot that looks up the screen sees its own frame. */
#define JDE_FORWARD_UP 8u
/** Widget flag: cannot be pressed now. */
#define JDE_DISABLED 16u
/** Widget flag: folded at first. */
#define JDE_FOLDED 32u

/** Shape: through `points` in turn. JDE_CLOSED. */
#define JDE_SHAPE_LINE 0u
/** Shape: each of `points` by itself; `width` is their diameter. */
#define JDE_SHAPE_POINTS 1u
/** Shape: a line from the first of two `points` to the second, where its head is. */
#define JDE_SHAPE_ARROW 2u
/** Shape: the `text` at the one point. */
#define JDE_SHAPE_LABEL 3u
/** Shape of a canvas: a circle of `radius` about the one point. JDE_FILLED. */
#define JDE_SHAPE_CIRCLE 4u
/** Shape of a canvas: what is between `points`, filled; convex. */
#define JDE_SHAPE_POLYGON 5u
/** Shape of a canvas: the robot that the application drives at the one point, its heading in `turned[2]`. */
#define JDE_SHAPE_ROBOT 6u
/** Shape of a scene: a box of `extent` about the one point, `turned`. */
#define JDE_SHAPE_BOX 7u
/** Shape of a scene: a sphere of `radius` about the one point. */
#define JDE_SHAPE_SPHERE 8u
/** Shape of a scene: a cylinder of `radius` about the one point, `extent[2]` high, `turned`. */
#define JDE_SHAPE_CYLINDER 9u
/** Shape of a scene: triangles, whose corners are three `points` each, counter-clockwise from outside. */
#define JDE_SHAPE_MESH 10u

/** Shape flag: from the last point back to the first. */
#define JDE_CLOSED 1u
/** Shape flag: filled. */
#define JDE_FILLED 2u

/** Color: as text. Colors below 256 are inks, which fit the viewer's theme. */
#define JDE_INK_PLAIN 0u
/** Color: less than the rest. */
#define JDE_INK_FAINT 1u
/** Color: what this is about. */
#define JDE_INK_ACCENT 2u
/** Color: all is well; free. */
#define JDE_INK_GOOD 3u
/** Color: something is off; near. */
#define JDE_INK_WARN 4u
/** Color: something failed; in the way. */
#define JDE_INK_BAD 5u
/** Color: what attracts: targets. */
#define JDE_INK_GOAL 6u
/** Color: what was measured. */
#define JDE_INK_SEEN 7u

/** Gesture: a button was pressed. */
#define JDE_TOUCH_PRESSED 0u
/** Gesture: a toggle was switched; `number` is 1 for on. */
#define JDE_TOUCH_TOGGLED 1u
/** Gesture: a slider was moved to `value`. */
#define JDE_TOUCH_MOVED 2u
/** Gesture: of a choice, the one at the place `number` was taken. */
#define JDE_TOUCH_CHOSE 3u
/** Gesture: clicked at `at` with `button`. */
#define JDE_TOUCH_CLICKED 4u
/** Gesture: dragged from `from` to `at` with `button`. JDE_DRAG_ENDED. */
#define JDE_TOUCH_DRAGGED 5u
/** Gesture: the `key` went down (`number` is 1) or up. */
#define JDE_TOUCH_KEY 6u

/** Button: the left one. */
#define JDE_BUTTON_PRIMARY 0u
/** Button: the right one. */
#define JDE_BUTTON_SECONDARY 1u
/** Button: the one between. */
#define JDE_BUTTON_MIDDLE 2u

/** Gesture flag: the drag is over. */
#define JDE_DRAG_ENDED 1u

/** The id of the ability, whose table is a jde_state. Since minor version 3, as all that belongs to it. */
#define JDE_ABILITY_STATE "jde.state"

/** Most bytes that a schema may save. */
#define JDE_STATE_MOST 16777216u

/** The id of the ability, whose table is an jde_inspect. Since minor version 5, as all that belongs to it. */
#define JDE_ABILITY_INSPECT "jde.inspect"

/** Problem: the schema would fail when it awakes, until a person changes something. */
#define JDE_PROBLEM_WRONG 0u
/** Problem: something is not there or may not be used at present; the schema would start and wait for it. */
#define JDE_PROBLEM_UNAVAILABLE 1u

/** Most problems of one inspection; the host takes no more. */
#define JDE_PROBLEMS_MOST 64u

/** Policy: the order in which the father names its children. */
#define JDE_POLICY_PRIORITY 0u
/** Policy: the highest number that a candidate offers. */
#define JDE_POLICY_URGENCY 1u
/** Policy: the winner stays for `dwell`, and until a rival is `hysteresis` more urgent. */
#define JDE_POLICY_STICKY 2u
/** Policy: each READY child in turn, for `turn` each. */
#define JDE_POLICY_ROUND_ROBIN 3u
/** Policy: the father's own function. */
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
typedef struct jde_panel jde_panel;
typedef struct jde_drawing jde_drawing;
typedef struct jde_pen jde_pen;
typedef struct jde_widget jde_widget;
typedef struct jde_shape jde_shape;
typedef struct jde_gesture jde_gesture;
typedef struct jde_state jde_state;
typedef struct jde_saving jde_saving;
typedef struct jde_saver jde_saver;
typedef struct jde_inspect jde_inspect;
typedef struct jde_found jde_found;
typedef struct jde_problems jde_problems;

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
    /** JDE_PLUGIN_ABORTS, JDE_PLUGIN_CATCHES. */
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
    /**
     * Names of the numbers from 0 on, of a modulation that is one of several; `min` is 0 then and `max` the last. Since minor
     * version 4.
     */
    const char *const *choices;
    /** How many; 0 for a plain number. Since minor version 4. */
    uint32_t choice_count;
    /** 0. */
    uint32_t reserved;
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
    /** JDE_OPTIONAL, JDE_MANY. */
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

/** A value as a port shows it; the data stays as it is until the present call of the instance returns. It never grows. */
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
    /** Bytes of this table. Whoever asks states them before. */
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
    /**
     * Publishes what was loaned, measured at `time_ns` (0: now). JDE_REFUSED and JDE_NOT_FINITE for
     * commands and a child's modulations, JDE_OUT_OF_RANGE for the latter, JDE_BAD_ARGUMENT.
     */
    int32_t (*publish)(jde_context *, uint32_t port, uint64_t time_ns);
    /** Wakes a child (R7). Waking one that is awake changes nothing. JDE_REFUSED, JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*wake)(jde_context *, uint32_t child);
    /** Puts a child and its subtree to sleep. JDE_REFUSED, JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*sleep)(jde_context *, uint32_t child);
    /** What a child is doing. JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*child)(jde_context *, uint32_t child, jde_child_status *);
    /**
     * Changes the policy of a group of children, named by one of them: a number `JDE_POLICY_...`,
     * its time and its number.
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
    /**
     * Takes back the newest value of an export, because it no longer tells how things are: until the next is published, all
     * who read it are answered JDE_NO_VALUE, and who is triggered by it looks again (R12). JDE_BAD_ARGUMENT. Since minor version 1.
     */
    int32_t (*retract)(jde_context *, uint32_t port);
    /**
     * 1 if the application's time passes as fast as everybody's; 0 in lockstep and at another speed, which no device follows.
     * Since minor version 1.
     */
    uint32_t (*real_time)(jde_context *);
};

/** What jde_schema.ability gives for JDE_ABILITY_PANEL. */
struct jde_panel {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /**
     * Draws the panel as it is now. Called while somebody looks and the schema is SLEPT or awake: then after an iteration or a
     * check, whose values jde_host.read still gives. It shows and changes nothing: whatever writes, wakes or puts to sleep
     * is JDE_REFUSED, and the panel says so. An error is shown in the panel and is no fault.
     */
    int32_t (*draw)(void *, jde_context *, const jde_pen *);
    /** Somebody did something to a widget. A call like an iteration, between two of them; an error is a fault. May be null. */
    int32_t (*touch)(void *, jde_context *, const jde_gesture *);
};

/** The list that is being drawn; opaque to the plugin. */
struct jde_drawing;

/** What a plugin draws with, only until its jde_panel.draw returns and on its thread. What is given to it is copied. */
struct jde_pen {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the functions below. */
    jde_drawing *drawing;
    /** Adds a widget below the last, or after it in a row. One with an inside is open until `end`. */
    int32_t (*add)(jde_drawing *, const jde_widget *);
    /** Adds a shape to the plot, canvas or scene that is open. */
    int32_t (*shape)(jde_drawing *, const jde_shape *);
    /** Ends the row, group, plot, canvas or scene that was opened last. */
    int32_t (*end)(jde_drawing *);
};

/** A widget. Each kind uses the fields that its number names; the others are 0. */
struct jde_widget {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_WIDGET_TEXT to JDE_WIDGET_SCENE. */
    uint32_t kind;
    /** Names it in gestures and keeps what viewers remember of it; unique in the panel and not shown. */
    const char *id;
    /** What is on it or beside it. */
    const char *label;
    /** Unit as the symbols of SI: "m/s", "rad"; empty for none. */
    const char *unit;
    /** A number; finite. */
    double value;
    /** Least value; finite. */
    double least;
    /** Greatest value; finite, not below the least. */
    double greatest;
    /** Least x, least y, greatest x, greatest y, m; all 0 for none. */
    double area[4];
    /** Several texts. */
    const char *const *texts;
    /** Rows of pixels from the top, without gaps. */
    const uint8_t *pixels;
    /** How many texts. */
    uint32_t text_count;
    /** A whole number. */
    uint32_t number;
    /** JDE_WANTS_CLICKS to JDE_FOLDED. */
    uint32_t flags;
    /** Columns of pixels. */
    uint32_t width;
    /** Rows of pixels. */
    uint32_t height;
    /** Bytes of a pixel: 1 (grey), 3 (red, green, blue) or 4 (and how opaque). */
    uint32_t channels;
};

/** A shape, or a curve of a plot. Each kind uses the fields that its number names; the others are 0. */
struct jde_shape {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_SHAPE_LINE to JDE_SHAPE_MESH. */
    uint32_t kind;
    /** Its points, two or three numbers each as its widget has them; finite. */
    const double *points;
    /** How many points. */
    uint32_t point_count;
    /** One of JDE_INK_PLAIN to JDE_INK_SEEN, or exactly 0xAARRGGBB, of which AA, how opaque, is not 0. */
    uint32_t color;
    /** Width of lines, or diameter of points, in points of the screen; 0 for the usual. */
    double width;
    /** m. */
    double radius;
    /** Along x, y and z, m. */
    double extent[3];
    /** Roll, pitch and yaw, rad. */
    double turned[3];
    /** What it says. */
    const char *text;
    /** JDE_CLOSED, JDE_FILLED. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/**
 * What somebody did to a widget; lives until jde_panel.touch returns. Positions are metres in the plane or frame of a canvas or
 * scene, and pixels from the upper left corner of an image; where there are two numbers the third is 0.
 */
struct jde_gesture {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_TOUCH_PRESSED to JDE_TOUCH_KEY. */
    uint32_t kind;
    /** The widget's id. */
    const char *widget;
    /** Who did it: "ana@laptop". */
    const char *by;
    /** A key by its name: "a", "Space", "ArrowUp". */
    const char *key;
    /** Where a drag began. */
    double from[3];
    /** Where it is. */
    double at[3];
    /** A number. */
    double value;
    /** A whole number. */
    uint32_t number;
    /** JDE_BUTTON_PRIMARY to JDE_BUTTON_MIDDLE. */
    uint32_t button;
    /** JDE_DRAG_ENDED. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/** What jde_schema.ability gives for JDE_ABILITY_STATE. */
struct jde_state {
    /** Bytes of this table. */
    uint32_t size;
    /** The version of what `save` writes, as the author counts. */
    uint32_t version;
    /**
     * Writes down what the instance remembers, between two iterations or while it is SLEPT. It changes nothing: whatever writes
     * a variable, wakes or puts to sleep is JDE_REFUSED. After an error the instance goes on as it was.
     */
    int32_t (*save)(void *, jde_context *, const jde_saver *);
    /**
     * Takes over what another instance of this type saved in that version, maybe of another build: after `create`, and after
     * `awake` if it is awake, before the first check or iteration. It changes nothing else, as `save`. An error refuses: the
     * other instance goes on, and this one ends.
     */
    int32_t (*restore)(void *, jde_context *, uint32_t version, const void *bytes, uint64_t length);
};

/** What is being saved; opaque to the plugin. */
struct jde_saving;

/** What a plugin saves with, only until its jde_state.save returns and on its thread. */
struct jde_saver {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the function below. */
    jde_saving *saving;
    /**
     * Adds bytes behind those before; they are copied. JDE_BAD_ARGUMENT beyond JDE_STATE_MOST, and then nothing of it is
     * kept.
     */
    int32_t (*write)(jde_saving *, const void *bytes, uint64_t length);
};

/** What jde_schema.ability gives for JDE_ABILITY_INSPECT. */
struct jde_inspect {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /**
     * Looks at what the modulations name, and adds a problem for each that cannot work. It reads and changes nothing: no device is
     * opened, no file is written, nobody is called over a network; the host sees to that where the system lets it.
     *
     * Called between `create` and `destroy` of an instance that never awakes, in a process of its own, which is ended if the
     * function does not return within a few seconds. jde_host.read gives the modulations as the application sets them; any
     * other port has no value, and whatever writes, wakes or puts to sleep is JDE_REFUSED.
     */
    int32_t (*inspect)(void *, jde_context *, const jde_problems *);
};

/** The list that problems are added to; opaque to the plugin. */
struct jde_found;

/** What a plugin reports with, only until its jde_inspect.inspect returns and on its thread. */
struct jde_problems {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the function below. */
    jde_found *found;
    /**
     * Adds a problem of the modulation `port`: what is wrong and what to do, as `length` bytes of UTF-8, which are copied.
     * JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE. JDE_BAD_ARGUMENT for another kind, a null text, and beyond
     * JDE_PROBLEMS_MOST.
     */
    int32_t (*add)(jde_found *, uint32_t kind, uint32_t port, const char *text, uint64_t length);
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
#define JDE_PLUGIN(name, version, doc, schemas) JDE_PLUGIN_OF(0u, name, version, doc, schemas)
/** The same for a plugin in C++ whose functions all do their work within jde_guarded. */
#define JDE_PLUGIN_GUARDED(name, version, doc, schemas) JDE_PLUGIN_OF(JDE_PLUGIN_CATCHES, name, version, doc, schemas)
/** The same, with its flags. */
#define JDE_PLUGIN_OF(flags, name, version, doc, schemas)                                                   \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), flags, name, version, doc,   \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port of a kind; what a kind does not have is NULL, JDE_UNBOUNDED or 0. */
#define JDE_PORT(kind, name, doc, unit, type, initial, min, max, validity_ns, flags, child, choices, choice_count)      \
    {(uint32_t)sizeof(jde_port), kind, name, doc, unit, &(type), initial, min, max, validity_ns, flags, child, choices, \
     choice_count, 0u}
/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    JDE_PORT(JDE_IMPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    JDE_PORT(JDE_EXPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u, NULL, 0u)
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    JDE_PORT(JDE_MODULATION, name, doc, unit, type, &(initial), min, max, 0u, flags, 0u, NULL, 0u)
/** A jde_port that is one of several: `type` is a plain whole number, `choices` an array of the names of its values from 0 on. */
#define JDE_PORT_CHOICE(name, doc, type, initial, choices)                                                                      \
    JDE_PORT(JDE_MODULATION, name, doc, "", type, &(initial), 0.0, (double)(JDE_COUNT(choices) - 1u), 0u, 0u, 0u, choices, \
             JDE_COUNT(choices))
/** A jde_port of a driver that reaches an actuator; `neutral` is a static const value that stops it. */
#define JDE_PORT_COMMAND(name, doc, type, neutral, validity_ns) \
    JDE_PORT(JDE_COMMAND, name, doc, "", type, &(neutral), JDE_UNBOUNDED, JDE_UNBOUNDED, validity_ns, 0u, 0u, NULL, 0u)
/** A jde_port that writes a driver's command. */
#define JDE_PORT_ACTUATOR(name, doc, type, flags) \
    JDE_PORT(JDE_ACTUATOR, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes the modulation `name` of the child of this number. */
#define JDE_PORT_CHILD_MODULATION(child, name, doc, type, flags) \
    JDE_PORT(JDE_CHILD_MODULATION, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, child, NULL, 0u)

/** A jde_child that competes in a group. */
#define JDE_CHILD_MOTOR(name, group, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_MOTOR, name, group, doc, flags, 0u}
/** A jde_child that helps. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Whether an instance can be made for a host: to be asked in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= offsetof(jde_host, retract) && host->abi_major == JDE_ABI_MAJOR;
}

/** Whether a host has a function that a later minor version brought: `if (JDE_HOST_HAS(host, retract)) host->retract(...)`. */
#define JDE_HOST_HAS(host, function) \
    ((host)->size >= offsetof(jde_host, function) + sizeof((host)->function) && (host)->function != NULL)

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

/*
 * C++. An exception that leaves a function of the plugin ends the application: what unwinds another language's frames cannot be caught
 * in the host, only here. Do the work of each function within jde_guarded:
 *
 *     static int32_t iterate(void *instance, jde_context *context)
 *     {
 *         mine *self = static_cast<mine *>(instance);
 *         return jde_guarded(self->host, context, JDE_PANICKED, [&]() -> int32_t { return self->iterate(context); });
 *     }
 *
 * and export the plugin by JDE_PLUGIN_GUARDED. One that is not written so runs with `isolate = "process"`: an exception then ends its own process, and the schema is Faulted.
 */
#ifdef __cplusplus
} /* extern "C" */

#include <exception>

/** Answers as `body` does; with `otherwise` if that throws, for a reason given to jde_host.fail. No exception leaves it. */
template <typename Answer, typename Body>
static inline Answer jde_guarded(const jde_host *host, jde_context *context, Answer otherwise, Body body) noexcept
{
    try {
        return body();
    } catch (const std::exception &thrown) {
        host->fail(context, thrown.what(), strlen(thrown.what()));
    } catch (...) {
        static const char reason[] = "it threw what is no std::exception";
        host->fail(context, reason, sizeof reason - 1u);
    }
    return otherwise;
}

extern "C" {
#endif

/*
 * Reloading. A schema that hands what it remembers to its next build gives its jde_state from jde_schema.ability:
 *
 *     static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL; }
 */

/** Saves bytes behind those before. */
static inline int32_t jde_save(const jde_saver *saver, const void *bytes, size_t length)
{
    return saver->write(saver->saving, bytes, (uint64_t)length);
}

/*
 * Inspection. A schema that looks at what its modulations name before anything starts gives its jde_inspect from
 * jde_schema.ability:
 *
 *     static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL; }
 */

/** Adds a problem of the modulation `port`: JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE, and what to do. */
static inline int32_t jde_problem(const jde_problems *problems, uint32_t kind, uint32_t port, const char *text)
{
    return problems->add(problems->found, kind, port, text, (uint64_t)strlen(text));
}

/*
 * Panels. A schema gives its jde_panel from jde_schema.ability:
 *
 *     static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_PANEL) == 0 ? &panel : NULL; }
 *
 * The functions below answer as those of jde_pen do. Whoever draws need not look: what is wrong is shown in the panel.
 */

/** A widget of a kind, all else 0. */
static inline jde_widget jde_widget_of(uint32_t kind)
{
    jde_widget widget;
    memset(&widget, 0, sizeof widget);
    widget.size = (uint32_t)sizeof widget;
    widget.kind = kind;
    return widget;
}

/** A shape of a kind in a color, all else 0. */
static inline jde_shape jde_shape_of(uint32_t kind, uint32_t color)
{
    jde_shape shape;
    memset(&shape, 0, sizeof shape);
    shape.size = (uint32_t)sizeof shape;
    shape.kind = kind;
    shape.color = color;
    return shape;
}

/** Adds a widget. */
static inline int32_t jde_add(const jde_pen *pen, const jde_widget *widget)
{
    return pen->add(pen->drawing, widget);
}

/** Adds a shape. */
static inline int32_t jde_draw(const jde_pen *pen, const jde_shape *shape)
{
    return pen->shape(pen->drawing, shape);
}

/** Ends the row, group, plot, canvas or scene that was begun last. */
static inline int32_t jde_end(const jde_pen *pen)
{
    return pen->end(pen->drawing);
}

/** A text that matters as `words` say. */
static inline int32_t jde_add_text(const jde_pen *pen, uint32_t words, const char *text)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TEXT);
    widget.label = text;
    widget.number = words;
    return jde_add(pen, &widget);
}

/** A number with its name and unit. */
static inline int32_t jde_add_value(const jde_pen *pen, const char *label, double value, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_VALUE);
    widget.label = label;
    widget.value = value;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** Something to press; `flags` are 0 or JDE_DISABLED. */
static inline int32_t jde_add_button(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_BUTTON);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Something that is on (1) or off (0). */
static inline int32_t jde_add_toggle(const jde_pen *pen, const char *id, const char *label, uint32_t on)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TOGGLE);
    widget.id = id;
    widget.label = label;
    widget.number = on;
    return jde_add(pen, &widget);
}

/** A number to move. */
static inline int32_t jde_add_slider(const jde_pen *pen, const char *id, const char *label, double value, double least,
                                     double greatest, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SLIDER);
    widget.id = id;
    widget.label = label;
    widget.value = value;
    widget.least = least;
    widget.greatest = greatest;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** One of several texts; `chosen` is the place of the present one. */
static inline int32_t jde_add_choice(const jde_pen *pen, const char *id, const char *label, const char *const *texts,
                                     uint32_t count, uint32_t chosen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CHOICE);
    widget.id = id;
    widget.label = label;
    widget.texts = texts;
    widget.text_count = count;
    widget.number = chosen;
    return jde_add(pen, &widget);
}

/** Texts in rows below the heads of `columns`: heads first, `count` in all. */
static inline int32_t jde_add_table(const jde_pen *pen, const char *id, const char *const *texts, uint32_t count,
                                    uint32_t columns)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TABLE);
    widget.id = id;
    widget.texts = texts;
    widget.text_count = count;
    widget.number = columns;
    return jde_add(pen, &widget);
}

/** Pixels in rows from the top, without gaps. */
static inline int32_t jde_add_image(const jde_pen *pen, const char *id, const uint8_t *pixels, uint32_t width,
                                    uint32_t height, uint32_t channels)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_IMAGE);
    widget.id = id;
    widget.pixels = pixels;
    widget.width = width;
    widget.height = height;
    widget.channels = channels;
    return jde_add(pen, &widget);
}

/** Widgets beside each other, up to jde_end. */
static inline int32_t jde_begin_row(const jde_pen *pen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_ROW);
    return jde_add(pen, &widget);
}

/** Widgets below a heading, up to jde_end; `flags` are 0 or JDE_FOLDED. */
static inline int32_t jde_begin_group(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_GROUP);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Curves, up to jde_end; `axes` are two texts, across and up. */
static inline int32_t jde_begin_plot(const jde_pen *pen, const char *id, const char *label, const char *const *axes)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_PLOT);
    widget.id = id;
    widget.label = label;
    widget.texts = axes;
    widget.text_count = 2u;
    return jde_add(pen, &widget);
}

/** A plane in metres, up to jde_end. */
static inline int32_t jde_begin_canvas(const jde_pen *pen, const char *id, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CANVAS);
    widget.id = id;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** A space in metres in a frame of REP-105, up to jde_end. */
static inline int32_t jde_begin_scene(const jde_pen *pen, const char *id, const char *frame, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SCENE);
    widget.id = id;
    widget.label = frame;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** A shape of `count` points in a color: JDE_SHAPE_LINE, JDE_SHAPE_POINTS, JDE_SHAPE_ARROW, JDE_SHAPE_POLYGON or JDE_SHAPE_MESH. */
static inline int32_t jde_draw_points(const jde_pen *pen, uint32_t kind, const double *points, uint32_t count,
                                      uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = points;
    shape.point_count = count;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** A text at a point. */
static inline int32_t jde_draw_label(const jde_pen *pen, const double *at, const char *text, uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LABEL, color);
    shape.points = at;
    shape.point_count = 1u;
    shape.text = text;
    return jde_draw(pen, &shape);
}

/** A curve of a plot, with its name. */
static inline int32_t jde_draw_curve(const jde_pen *pen, const char *name, const double *points, uint32_t count,
                                     uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LINE, color);
    shape.points = points;
    shape.point_count = count;
    shape.text = name;
    return jde_draw(pen, &shape);
}

/** JDE_SHAPE_CIRCLE or JDE_SHAPE_SPHERE about a point. */
static inline int32_t jde_draw_round(const jde_pen *pen, uint32_t kind, const double *center, double radius,
                                     uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = center;
    shape.point_count = 1u;
    shape.radius = radius;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** The outline of the robot that the application drives. */
static inline int32_t jde_draw_robot(const jde_pen *pen, double x, double y, double theta)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_ROBOT, JDE_INK_PLAIN);
    double at[2];
    at[0] = x;
    at[1] = y;
    shape.points = at;
    shape.point_count = 1u;
    shape.turned[2] = theta;
    return jde_draw(pen, &shape);
}

/** Whether a gesture is of a kind, on a widget. */
static inline int jde_touched(const jde_gesture *gesture, uint32_t kind, const char *id)
{
    return gesture->kind == kind && gesture->widget != NULL && strcmp(gesture->widget, id) == 0;
}

#ifdef __cplusplus
}
#endif

#endif
