/*
 * The tables that cross the boundary, in C layout. They contain nothing of Rust's own layout (bool, enum,
 * slice, String).
 *
 * Rules of this file, in the manner of CLAP:
 * - Tables grow only at the end. Each begins with its `size`, which is also the stride of an array of such
 *   tables.
 * - A reader uses as many bytes of a table as the shorter layout has: its `size`, or the reader's own.
 *   Missing fields count as 0 or null, and further bytes are ignored. A table that is shorter than in the
 *   minor version that introduced it is refused.
 * - A writer of a table that the other side lent (jde_precondition, jde_verdict, jde_child_status) fills in
 *   no more than its `size`, and does not change that `size`.
 * - A function of a later minor version is beyond the `size` of an older host, or null: check before use.
 * - A host accepts plugins of every minor version of its major one, older and newer. It ignores unknown
 *   fields and flags, and refuses unknown kinds with a message.
 * - Only jde_sample states no size, because it is filled in at every read. Its 40 bytes never change.
 *   Further data of a value would have a function of its own.
 * - A table of a plugin, and all it points to, stays unchanged until the process ends (libraries are never
 *   unmapped).
 * - Texts are UTF-8 and end with a NUL; a null one is empty. The side that allocates memory frees it.
 * - No function unwinds: a panic or an exception is caught on the side where it arose.
 * - Calls of one instance never overlap, but may come from different threads one after another.
 *
 * Generated from plugin/abi/src/raw/mod.rs; `cargo xtask headers` renews it.
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
/** Changes when older readers would misread a table. Host and plugin must have the same. */
#define JDE_ABI_MAJOR 1u
/**
 * Increases when tables grow or an ability is added. Hosts up to 1.3 accept plugins of their own minor
 * version and older; later ones accept all.
 */
#define JDE_ABI_MINOR 9u

/** The symbol of type jde_plugin that every plugin exports. */
#define JDE_ENTRY_SYMBOL "jde_plugin"

/** Plugin flag: built so that a panic aborts the process. The host refuses it. */
#define JDE_PLUGIN_ABORTS 1u
/** Plugin flag: no C++ exception leaves any of its functions. Since minor version 4. */
#define JDE_PLUGIN_CATCHES 2u

/** Success. */
#define JDE_OK 0
/**
 * This import has no value: nothing has been published yet, or the value has ended. A check or an iteration that returns
 * it ends there without a fault, and a motor schema is not READY (R19); hosts before minor version 8 call it a fault.
 */
#define JDE_NO_VALUE 1
/**
 * The caller has no authority at this instant (R7), a guard refuses the command (R18), or an operator holds
 * the child. Counted and shown; not a
 * fault. Every function that reads or changes something also returns this, uncounted, to a call that hung
 * and was given up. Such a call should return.
 */
#define JDE_REFUSED 2
/** The value contains a NaN or an infinity where a finite number is required. Counted and shown; not a fault. */
#define JDE_NOT_FINITE 3
/** No such port, child or group, or a call that this port does not allow. */
#define JDE_BAD_ARGUMENT 4
/** An optional port or child that the application left unbound. */
#define JDE_UNBOUND 5
/** The schema failed. The reason was passed to jde_host.fail. */
#define JDE_FAILED 6
/** The schema panicked. The reason was passed to jde_host.fail. */
#define JDE_PANICKED 7

/**
 * The number is outside the limits of the child's modulation (R8). Counted and shown; not a fault. Since
 * minor version 4: older plugins get JDE_NOT_FINITE.
 */
#define JDE_OUT_OF_RANGE 8

/** Schema kind: turns data into better data. */
#define JDE_PERCEPTIVE 0u
/** Schema kind: has a precondition, competes, commands. */
#define JDE_MOTOR 1u
/** Schema kind: exports sensors and takes commands. */
#define JDE_DRIVER 2u

/** Schema state: uses no processor time; keeps its memory. */
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
/**
 * Import flag: a new value re-evaluates the precondition at once, or lets a schema without one iterate at once (R12),
 * unless the application sets other triggers. Command flag: a new command lets the driver iterate at once.
 */
#define JDE_TRIGGER 2u
/**
 * Modulation flag: read when the schema awakes, and kept until it sleeps. Later writes take effect at the
 * next awakening (R8).
 */
#define JDE_FIXED 4u
/** Modulation flag: where the sensor of the imports of measurements is on the base. All that read a sensor state the same. */
#define JDE_MOUNT 16u
/** Modulation flag: a distance kept from obstacles, where that of a guard is the least, or a zone around the base. */
#define JDE_MARGIN 32u
/**
 * Modulation flag: the greatest speed (m/s), turn rate (rad/s), or change of one (m/s2, rad/s2), that the schema asks of the
 * base, or by which its guard expects the base to brake. No schema asks for more than its driver and its guard state.
 */
#define JDE_LIMIT 64u
/**
 * Child flag, only for the last child: any number of motor children, which the application names and groups,
 * numbered from this one on.
 */
#define JDE_MANY 8u

/** Validity of an export whose values are valid until they are replaced or retracted. Since minor version 8. */
#define JDE_LASTING 18446744073709551615u

/** Sample flag: no command is in force; the data is the neutral value. */
#define JDE_SAMPLE_NEUTRAL 1u
/** Sample flag: this modulation was never written; the data is its default. */
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
/** Field kind: a structure with its own jde_type. */
#define JDE_STRUCT 11u

/** Field form: one element. */
#define JDE_ONE 0u
/** Field form: exactly `capacity` elements. */
#define JDE_ARRAY 1u
/**
 * Field form: up to `capacity` elements, their number a `uint32_t` at `length_offset`. If the first element is
 * eight bytes after that offset, the four bytes between belong to the number and are unused, so that
 * elements of any alignment leave no gap.
 */
#define JDE_SEQUENCE 2u
/** Field form: UTF-8 of up to `capacity` bytes, their number a `uint32_t` at `length_offset`. */
#define JDE_TEXT 3u
/** Field form: `capacity` unused bytes (JDE_U8), where C would leave a gap. Descriptions omit them. */
#define JDE_PADDING 4u

/** Field flag: its elements are a `byte` in ROS 2. Only the hash of the type (REP-2016) distinguishes it from JDE_U8. */
#define JDE_BYTE 1u
/**
 * Field flag: the capacity is a bound in ROS 2 too. Otherwise a text or a sequence has none there. Only the hash depends
 * on it.
 */
#define JDE_BOUNDED 2u

/** Log level: for the developer of this schema; may occur in every iteration. */
#define JDE_TRACE 0u
/** Log level: for the developer of this schema. */
#define JDE_DEBUG 1u
/** Log level: for the operator of the application. */
#define JDE_INFO 2u
/** Log level: a problem after which the schema continues. */
#define JDE_WARN 3u
/** Log level: a failure. */
#define JDE_ERROR 4u

/** Selection case: exactly one READY. */
#define JDE_ALONE 0u
/** Selection case: two or more READY. */
#define JDE_COLLISION 1u
/** Selection case: none READY. */
#define JDE_ABSENCE 2u

/**
 * The id of the ability, whose table is a jde_panel. It and all that belongs to it exist since minor version
 * 2.
 */
#define JDE_ABILITY_PANEL "jde.panel"

/** Widget: a text in `label`. `number` is its style, JDE_WORDS_PLAIN to JDE_WORDS_CODE. */
#define JDE_WIDGET_TEXT 0u
/** Widget: a number `value` with its name in `label` and its `unit`. */
#define JDE_WIDGET_VALUE 1u
/** Widget: a button, with `id` and `label`. JDE_DISABLED. */
#define JDE_WIDGET_BUTTON 2u
/** Widget: a toggle, with `id` and `label`. `number` is 1 for on. */
#define JDE_WIDGET_TOGGLE 3u
/** Widget: a slider, with `id`, `label`, `value`, `least`, `greatest`, `unit`. */
#define JDE_WIDGET_SLIDER 4u
/** Widget: a choice, with `id`, `label` and the options in `texts`. `number` is the index of the present one. */
#define JDE_WIDGET_CHOICE 5u
/**
 * Widget: an image, with `id`, `pixels`, `width`, `height`, `channels`. JDE_WANTS_CLICKS, JDE_WANTS_DRAGS,
 * JDE_WANTS_KEYS.
 */
#define JDE_WIDGET_IMAGE 6u
/**
 * Widget: a table, with `id`; `texts` are the headings of its `number` columns, and then the cells, row by
 * row.
 */
#define JDE_WIDGET_TABLE 7u
/** Widget: the widgets up to its jde_pen.end, beside each other. */
#define JDE_WIDGET_ROW 8u
/** Widget: the widgets up to its jde_pen.end below `label`, with `id`. JDE_FOLDED. */
#define JDE_WIDGET_GROUP 9u
/**
 * Widget: a plot, with `id` and `label`. `texts` are the labels of its axes, horizontal and vertical. Up to
 * its jde_pen.end it contains only shapes of JDE_SHAPE_LINE, each with its name in `text`.
 */
#define JDE_WIDGET_PLOT 10u
/**
 * Widget: a plane in metres, with `id`. Up to its jde_pen.end it contains shapes with two numbers per
 * point. It shows `area` at first, if that is not empty. JDE_FORWARD_UP, JDE_WANTS_CLICKS, JDE_WANTS_DRAGS,
 * JDE_WANTS_KEYS.
 */
#define JDE_WIDGET_CANVAS 11u
/**
 * Widget: a space in metres, with `id`, in the frame of REP-105 that `label` names. Up to its jde_pen.end
 * it contains shapes with three numbers per point. JDE_WANTS_CLICKS, JDE_WANTS_DRAGS, JDE_WANTS_KEYS.
 */
#define JDE_WIDGET_SCENE 12u

/** Text style: plain. */
#define JDE_WORDS_PLAIN 0u
/** Text style: a heading. */
#define JDE_WORDS_HEADING 1u
/** Text style: less prominent. */
#define JDE_WORDS_FAINT 2u
/** Text style: a good state. */
#define JDE_WORDS_GOOD 3u
/** Text style: a warning. */
#define JDE_WORDS_WARNING 4u
/** Text style: an error. */
#define JDE_WORDS_ERROR 5u
/** Text style: a fixed-width font. */
#define JDE_WORDS_CODE 6u

/** Widget flag: reports clicks. */
#define JDE_WANTS_CLICKS 1u
/** Widget flag: reports drags. Without it a drag moves the view. */
#define JDE_WANTS_DRAGS 2u
/** Widget flag: reports keys while it has the focus. */
#define JDE_WANTS_KEYS 4u
/** Widget flag: shown with x up and y to the left, the frame of a robot that faces up the screen. */
#define JDE_FORWARD_UP 8u
/** Widget flag: cannot be pressed at present. */
#define JDE_DISABLED 16u
/** Widget flag: folded at first. */
#define JDE_FOLDED 32u

/** Shape: a line through `points` in their order. JDE_CLOSED. */
#define JDE_SHAPE_LINE 0u
/** Shape: separate `points`. `width` is their diameter. */
#define JDE_SHAPE_POINTS 1u
/** Shape: an arrow from the first of two `points` to the second. */
#define JDE_SHAPE_ARROW 2u
/** Shape: the `text` at the one point. */
#define JDE_SHAPE_LABEL 3u
/** Shape of a canvas: a circle of `radius` about the one point. JDE_FILLED. */
#define JDE_SHAPE_CIRCLE 4u
/** Shape of a canvas: a filled convex polygon with the corners `points`. */
#define JDE_SHAPE_POLYGON 5u
/** Shape of a canvas: the robot that the application drives at the one point, its heading in `turned[2]`. */
#define JDE_SHAPE_ROBOT 6u
/** Shape of a scene: a box of `extent` about the one point, `turned`. */
#define JDE_SHAPE_BOX 7u
/** Shape of a scene: a sphere of `radius` about the one point. */
#define JDE_SHAPE_SPHERE 8u
/** Shape of a scene: a cylinder of `radius` about the one point, `extent[2]` high, `turned`. */
#define JDE_SHAPE_CYLINDER 9u
/** Shape of a scene: triangles with three `points` each, counter-clockwise seen from outside. */
#define JDE_SHAPE_MESH 10u

/** Shape flag: the line returns from the last point to the first. */
#define JDE_CLOSED 1u
/** Shape flag: filled. */
#define JDE_FILLED 2u

/** Color: that of text. Colors below 256 are inks, which fit the viewer's theme. */
#define JDE_INK_PLAIN 0u
/** Color: less prominent. */
#define JDE_INK_FAINT 1u
/** Color: the main subject. */
#define JDE_INK_ACCENT 2u
/** Color: a good state; free. */
#define JDE_INK_GOOD 3u
/** Color: a warning; near. */
#define JDE_INK_WARN 4u
/** Color: a failure; an obstacle. */
#define JDE_INK_BAD 5u
/** Color: a target. */
#define JDE_INK_GOAL 6u
/** Color: measured data. */
#define JDE_INK_SEEN 7u

/** Gesture: a button was pressed. */
#define JDE_TOUCH_PRESSED 0u
/** Gesture: a toggle was switched; `number` is 1 for on. */
#define JDE_TOUCH_TOGGLED 1u
/** Gesture: a slider was moved to `value`. */
#define JDE_TOUCH_MOVED 2u
/** Gesture: the option with the index `number` of a choice was chosen. */
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
/** Button: the middle one. */
#define JDE_BUTTON_MIDDLE 2u

/** Gesture flag: the drag has ended. */
#define JDE_DRAG_ENDED 1u

/**
 * The id of the ability, whose table is a jde_state. It and all that belongs to it exist since minor version
 * 3.
 */
#define JDE_ABILITY_STATE "jde.state"

/** The largest number of bytes that a schema may save. */
#define JDE_STATE_MOST 16777216u

/**
 * The id of the ability, whose table is an jde_inspect. It and all that belongs to it exist since minor
 * version 5.
 */
#define JDE_ABILITY_INSPECT "jde.inspect"

/** Problem: the schema would fail when it awakes, until a user changes something. */
#define JDE_PROBLEM_WRONG 0u
/** Problem: something is missing or may not be used at present. The schema would start and wait for it. */
#define JDE_PROBLEM_UNAVAILABLE 1u

/** The largest number of problems of one inspection. */
#define JDE_PROBLEMS_MOST 64u

/**
 * The id of the ability, whose table is a jde_guard. It and all that belongs to it exist since minor version
 * 6.
 */
#define JDE_ABILITY_GUARD "jde.guard"

/**
 * The judgement: not the judged command takes effect, but jde_judgement.command. Since minor version 8; a host of
 * before refuses the command.
 */
#define JDE_LIMITED 2u

/** The id of the ability, whose table is a jde_lists. It and all that belongs to it exist since minor version 7. */
#define JDE_ABILITY_LISTS "jde.lists"

/**
 * The id of the extension, whose table is a jde_turns. jde_host.extension returns null in lockstep, at another
 * speed than real time, in a replay, in a process of its own, and in a host that does not know it.
 */
#define JDE_EXTENSION_TURNS "jde.turns"

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
typedef struct jde_guard jde_guard;
typedef struct jde_judgement jde_judgement;
typedef struct jde_lists jde_lists;
typedef struct jde_port_list jde_port_list;
typedef struct jde_listed_port jde_listed_port;
typedef struct jde_turns jde_turns;

/** The host's data of an instance; opaque to the plugin, and valid only inside a call of that instance. */
struct jde_context;

/**
 * The table that a plugin exports under the name `jde_plugin`.
 *
 * The host reads `magic`, `abi_major` and `abi_minor` before anything else; the offsets of these three
 * fields never change.
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
    /** Version of the plugin, in the author's own numbering. */
    const char *version;
    /** One sentence about the plugin. */
    const char *doc;
    /** The schema types. The stride is the `size` of the first. */
    const jde_schema *schemas;
    /** The number of schema types. */
    uint32_t schema_count;
    /** 0. */
    uint32_t reserved;
};

/** A type of schema: its description, its ports and children, and the functions of its instances. */
struct jde_schema {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_PERCEPTIVE, JDE_MOTOR or JDE_DRIVER. */
    uint32_t kind;
    /** Name of the type: lower-case letters, digits, `-`, `_`. */
    const char *name;
    /** What it does. The first line is a complete sentence. */
    const char *doc;
    /** Default period of its iterations, ns; at least 1. */
    uint64_t period_ns;
    /** The longest that an iteration may take, ns; 0 means the period. */
    uint64_t budget_ns;
    /** Its ports. Calls identify a port by its index. The stride is the `size` of the first. */
    const jde_port *ports;
    /** The roles of its children. Calls identify a child by its index. The stride is the `size` of the first. */
    const jde_child *children;
    /** The number of ports. */
    uint32_t port_count;
    /** The number of children. */
    uint32_t child_count;
    /**
     * Creates an instance in the state SLEPT. Called once, before any other function. Returns null on
     * failure, with the reason passed to jde_host.fail.
     */
    void *(*create)(const jde_schema *, const jde_host *, jde_context *);
    /** Destroys an instance that is SLEPT. Called once, after every other function. May be null. */
    void (*destroy)(void *);
    /** The instance leaves SLEPT. Called before its first check or iteration. May be null. */
    int32_t (*awake)(void *, jde_context *);
    /** Evaluates the precondition of a motor schema. Null: always READY. */
    int32_t (*check)(void *, jde_context *, jde_precondition *);
    /** One iteration, as WINNER. Must return within the budget. */
    int32_t (*iterate)(void *, jde_context *);
    /** The father's own arbitration (R4). Null if the schema has none. */
    int32_t (*arbitrate)(void *, jde_context *, const jde_level *, jde_verdict *);
    /**
     * The instance enters SLEPT. Called after its last iteration. A driver stops its actuators in this call.
     * May be null.
     */
    void (*sleep)(void *, jde_context *);
    /**
     * Returns the table of an optional ability by its id, such as "jde.panel", or null if the type does not
     * have it. The function may be null.
     */
    const void *(*ability)(const char *);
};

/** An input or output of a schema type. */
struct jde_port {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_IMPORT, JDE_EXPORT, JDE_MODULATION, JDE_COMMAND, JDE_ACTUATOR or JDE_CHILD_MODULATION. */
    uint32_t kind;
    /**
     * Its name, unique among the ports of this kind (and child). For JDE_CHILD_MODULATION, the name of the
     * child's modulation.
     */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Unit of a plain number ("m", "rad/s"); empty for none, or if the fields of the type have units. */
    const char *unit;
    /** Type of its value. */
    const jde_type *value_type;
    /** Default of a modulation or neutral value of a command, `value_type->bytes` bytes; otherwise null. */
    const void *initial;
    /** The least allowed number of a modulation; NaN for none. */
    double min;
    /** The greatest allowed number of a modulation; NaN for none. */
    double max;
    /**
     * How long a command is in force without being repeated, ns, at least 1. Since minor version 8 also how long a
     * value of an export is valid without a newer one (JDE_EXPORT): 0 for some of the periods that the application states,
     * or JDE_LASTING. Otherwise 0.
     */
    uint64_t validity_ns;
    /** JDE_OPTIONAL, JDE_TRIGGER, JDE_FIXED. */
    uint32_t flags;
    /** The child whose modulation this is. Only for JDE_CHILD_MODULATION. */
    uint32_t child;
    /**
     * The names of the numbers from 0 on, if the modulation is a choice. `min` is then 0, and `max` is the
     * last number. Since minor version 4.
     */
    const char *const *choices;
    /** The number of choices; 0 for a plain number. Since minor version 4. */
    uint32_t choice_count;
    /** 0. */
    uint32_t reserved;
    /**
     * The name that a modulation had before, by which application files and options are still read, with a warning; no
     * other port of the type has it. Null for none. Since minor version 9.
     */
    const char *former_name;
};

/** A role that a schema type has for a child. The application binds an instance to it. */
struct jde_child {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_PERCEPTIVE or JDE_MOTOR. */
    uint32_t kind;
    /** Name of the role. */
    const char *name;
    /** Name of the group in which a motor child competes. A group has at most one winner. */
    const char *group;
    /** What the child is for. */
    const char *doc;
    /** JDE_OPTIONAL, JDE_MANY. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/** A type of value: plain data of fixed size. Every bit pattern is valid, and a field describes every byte. */
struct jde_type {
    /** Bytes of this table. */
    uint32_t size;
    /** The number of fields. */
    uint32_t field_count;
    /**
     * Name, in the notation of ROS 2: "sensor_msgs/msg/LaserScan". Types are equal if their names and
     * layouts are.
     */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Bytes of a value. */
    uint64_t bytes;
    /** Alignment of a value, at most 16. */
    uint64_t align;
    /** The fields, in the order of their ROS interface. The stride is the `size` of the first. */
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
    /** The largest number of elements; 1 for JDE_ONE. */
    uint32_t capacity;
    /** Name of the field. */
    const char *name;
    /** What it means. */
    const char *doc;
    /** Unit ("m", "rad"); empty for none. */
    const char *unit;
    /** Bytes from the start of the value to the first element. */
    uint64_t offset;
    /** Bytes from the start of the value to the number of elements. Only for JDE_SEQUENCE and JDE_TEXT. */
    uint64_t length_offset;
    /** Type of the elements. Only for JDE_STRUCT. */
    const jde_type *value_type;
    /** JDE_BYTE and JDE_BOUNDED, or 0. Since minor version 8. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/**
 * A value of a port. The data does not change until the present call of the instance returns. This table
 * never grows.
 */
struct jde_sample {
    /** The value. */
    const void *data;
    /** Its size. */
    uint64_t bytes;
    /** When it was measured or written, ns since the application's start. */
    uint64_t time_ns;
    /** The sequence number of the value, from 1. */
    uint64_t sequence;
    /** The writer: the number of an instance in this application. */
    uint32_t writer;
    /** JDE_SAMPLE_NEUTRAL, JDE_SAMPLE_DEFAULT. */
    uint32_t flags;
};

/** The result of a check. */
struct jde_precondition {
    /** Bytes of this table. */
    uint32_t size;
    /** 1 if the precondition holds, otherwise 0. */
    uint32_t ready;
    /** The urgency, for policies that use it: any finite number, 0 by default. */
    double urgency;
};

/** The snapshot of a group for the father's own arbitration. */
struct jde_level {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_COLLISION or JDE_ABSENCE. */
    uint32_t case_;
    /** Name of the group. */
    const char *group;
    /** The awake children of the group, in the father's order. The stride is the `size` of the first. */
    const jde_candidate *candidates;
    /** The number of candidates. */
    uint32_t candidate_count;
    /** The child that is WINNER now, -1 for none. */
    int32_t winner;
};

/** A child that competes. */
struct jde_candidate {
    /** Bytes of this table. */
    uint32_t size;
    /** Its role: its index in jde_schema.children. */
    uint32_t child;
    /** JDE_CHECKING, JDE_READY or JDE_WINNER. */
    uint32_t state;
    /** 1 if its precondition held at its last check. */
    uint32_t ready;
    /** The urgency that its last check returned. */
    double urgency;
};

/** The father's choice. */
struct jde_verdict {
    /** Bytes of this table. */
    uint32_t size;
    /** The chosen child, -1 for none. */
    int32_t child;
    /** The reason for the choice; ends with a NUL. */
    char reason[128];
};

/** The status of a child, for its father. */
struct jde_child_status {
    /** Bytes of this table. The caller sets it before the call. */
    uint32_t size;
    /** JDE_SLEPT, JDE_CHECKING, JDE_READY or JDE_WINNER. */
    uint32_t state;
    /** 1 while it is Faulted. */
    uint32_t faulted;
    /** 0. */
    uint32_t reserved;
};

/**
 * The functions that the host offers to an instance. Call each with the jde_context of the present call, on
 * its thread, and only until that call returns. None blocks.
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
     * Reads an import, modulation or command. The value is the same throughout a check and the iteration
     * that follows it (R8). JDE_NO_VALUE, JDE_UNBOUND, JDE_BAD_ARGUMENT.
     */
    int32_t (*read)(jde_context *, uint32_t port, jde_sample *);
    /**
     * Returns a buffer for the next value of an export, actuator or child's modulation, aligned for its
     * type. Its bytes are arbitrary. The value is not visible before `publish`. A loan that is not published
     * by the end of the call is dropped. JDE_UNBOUND, JDE_BAD_ARGUMENT.
     */
    int32_t (*loan)(jde_context *, uint32_t port, void **);
    /**
     * Publishes the loaned value as measured at `time_ns` (0: now). JDE_REFUSED and
     * JDE_NOT_FINITE for commands and a child's modulations, JDE_OUT_OF_RANGE for the latter,
     * JDE_BAD_ARGUMENT.
     */
    int32_t (*publish)(jde_context *, uint32_t port, uint64_t time_ns);
    /**
     * Wakes a child (R7). Has no effect on a child that is awake. JDE_REFUSED, JDE_UNBOUND,
     * JDE_BAD_ARGUMENT.
     */
    int32_t (*wake)(jde_context *, uint32_t child);
    /**
     * Puts a child and its subtree to sleep. JDE_REFUSED, JDE_UNBOUND,
     * JDE_BAD_ARGUMENT.
     */
    int32_t (*sleep)(jde_context *, uint32_t child);
    /** Returns the status of a child. JDE_UNBOUND, JDE_BAD_ARGUMENT. */
    int32_t (*child)(jde_context *, uint32_t child, jde_child_status *);
    /**
     * Changes the policy of the group in which a child competes: a number `JDE_POLICY_...`, its time and its
     * number.
     */
    int32_t (*set_policy)(jde_context *, uint32_t child, uint32_t policy, uint64_t dwell_ns, double hysteresis);
    /** Returns the time since the application's start, ns. In lockstep it is constant during a call. */
    uint64_t (*now)(jde_context *);
    /** Returns a seed that depends only on the application's seed and the instance's name. */
    uint64_t (*seed)(jde_context *);
    /**
     * Returns a number that identifies the running application within this process. All its instances share
     * it.
     */
    uint64_t (*application)(jde_context *);
    /** Returns the instance's name in the application. The text lives as long as the instance. */
    const char *(*name)(jde_context *);
    /** Writes a log message. `text` is `length` bytes of UTF-8. */
    void (*log)(jde_context *, uint32_t level, const char *text, uint64_t length);
    /** States the reason for the error that this call is about to return. `text` is `length` bytes of UTF-8. */
    void (*fail)(jde_context *, const char *text, uint64_t length);
    /** Returns an extension of the host by its id; null if the host does not have it. */
    const void *(*extension)(jde_context *, const char *id);
    /**
     * Retracts the newest value of an export because it is no longer valid. Until the next value is
     * published, readers get JDE_NO_VALUE. Schemas with a trigger on it check again (R12).
     * JDE_BAD_ARGUMENT. Since minor version 1.
     */
    int32_t (*retract)(jde_context *, uint32_t port);
    /**
     * Returns 1 if the application runs in real time; 0 in lockstep and at another speed, which no device
     * can follow. Since minor version 1.
     */
    uint32_t (*real_time)(jde_context *);
};

/** The table that jde_schema.ability returns for JDE_ABILITY_PANEL. */
struct jde_panel {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /**
     * Draws the panel in its present state. Called only while a viewer shows it: while the schema is SLEPT,
     * or after an iteration or a check, whose values jde_host.read still returns. It must change
     * nothing: any call that writes, wakes or puts to sleep is JDE_REFUSED, and the panel shows that.
     * An error is shown in the panel and is no fault.
     */
    int32_t (*draw)(void *, jde_context *, const jde_pen *);
    /**
     * Handles a gesture on a widget. Called between two iterations, and like an iteration. An error is a
     * fault. May be null.
     */
    int32_t (*touch)(void *, jde_context *, const jde_gesture *);
};

/** The list of widgets under construction; opaque to the plugin. */
struct jde_drawing;

/**
 * The functions with which a plugin draws. Valid only until its jde_panel.draw returns, and on its thread.
 * They copy their arguments.
 */
struct jde_pen {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the functions below. */
    jde_drawing *drawing;
    /** Adds a widget below the last one, or beside it in a row. A container is open until `end`. */
    int32_t (*add)(jde_drawing *, const jde_widget *);
    /** Adds a shape to the open plot, canvas or scene. */
    int32_t (*shape)(jde_drawing *, const jde_shape *);
    /** Closes the row, group, plot, canvas or scene that was opened last. */
    int32_t (*end)(jde_drawing *);
};

/** A widget. Each kind uses the fields that the comment of its number names. The others are 0. */
struct jde_widget {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_WIDGET_TEXT to JDE_WIDGET_SCENE. */
    uint32_t kind;
    /** Identifies it in gestures and in the settings of viewers. Unique in the panel and not shown. */
    const char *id;
    /** The text on it or beside it. */
    const char *label;
    /** Unit in SI symbols: "m/s", "rad"; empty for none. */
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
    /** The number of texts. */
    uint32_t text_count;
    /** A whole number. */
    uint32_t number;
    /** JDE_WANTS_CLICKS to JDE_FOLDED. */
    uint32_t flags;
    /** Columns of pixels. */
    uint32_t width;
    /** Rows of pixels. */
    uint32_t height;
    /** Bytes of a pixel: 1 (grey), 3 (red, green, blue) or 4 (and the opacity). */
    uint32_t channels;
};

/**
 * A shape, or a curve of a plot. Each kind uses the fields that the comment of its number names. The others
 * are 0.
 */
struct jde_shape {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_SHAPE_LINE to JDE_SHAPE_MESH. */
    uint32_t kind;
    /** Its points, two or three numbers each as its widget has them; finite. */
    const double *points;
    /** The number of points. */
    uint32_t point_count;
    /** One of JDE_INK_PLAIN to JDE_INK_SEEN, or exactly 0xAARRGGBB, of which AA, the opacity, is not 0. */
    uint32_t color;
    /** Width of lines, or diameter of points, in points of the screen; 0 for the default. */
    double width;
    /** Radius, m. */
    double radius;
    /** Along x, y and z, m. */
    double extent[3];
    /** Roll, pitch and yaw, rad. */
    double turned[3];
    /** Its text. */
    const char *text;
    /** JDE_CLOSED, JDE_FILLED. */
    uint32_t flags;
    /** 0. */
    uint32_t reserved;
};

/**
 * A gesture of a user on a widget. Valid until jde_panel.touch returns. Positions are in metres in the
 * plane or frame of a canvas or scene, and in pixels from the upper left corner of an image. If a position
 * has two numbers, the third is 0.
 */
struct jde_gesture {
    /** Bytes of this table. */
    uint32_t size;
    /** JDE_TOUCH_PRESSED to JDE_TOUCH_KEY. */
    uint32_t kind;
    /** The widget's id. */
    const char *widget;
    /** The operator: "ana@laptop". */
    const char *by;
    /** The name of a key: "a", "Space", "ArrowUp". */
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

/** The table that jde_schema.ability returns for JDE_ABILITY_STATE. */
struct jde_state {
    /** Bytes of this table. */
    uint32_t size;
    /** The version of the format that `save` writes, in the author's own numbering. */
    uint32_t version;
    /**
     * Saves the memory of the instance. Called between two iterations, or while it is SLEPT. It must change
     * nothing: any call that writes a variable, wakes or puts to sleep is JDE_REFUSED. After an error
     * the instance continues as before.
     */
    int32_t (*save)(void *, jde_context *, const jde_saver *);
    /**
     * Restores what another instance of this type, perhaps of another build, saved in that version. Called
     * after `create`, and after `awake` if the schema is awake, before the first check or iteration. As for
     * `save`, it must change nothing else. After an error the other instance continues, and this one ends.
     */
    int32_t (*restore)(void *, jde_context *, uint32_t version, const void *bytes, uint64_t length);
};

/** The memory under construction; opaque to the plugin. */
struct jde_saving;

/** The functions with which a plugin saves. Valid only until its jde_state.save returns, and on its thread. */
struct jde_saver {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the function below. */
    jde_saving *saving;
    /**
     * Appends bytes, which are copied. JDE_BAD_ARGUMENT beyond JDE_STATE_MOST; then nothing of the
     * memory is kept.
     */
    int32_t (*write)(jde_saving *, const void *bytes, uint64_t length);
};

/** The table that jde_schema.ability returns for JDE_ABILITY_INSPECT. */
struct jde_inspect {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /**
     * Inspects what the modulations name, and adds a problem for each that cannot work. It only reads: it
     * opens no device, writes no file and uses no network. The host enforces that where the system permits.
     *
     * Called between `create` and `destroy` of an instance that never awakes, in a separate process, which
     * is ended if the function does not return within a few seconds. jde_host.read returns the
     * modulations as the application sets them. No other port has a value; an import without a source is
     * JDE_UNBOUND. Any call that writes, wakes or puts to sleep is JDE_REFUSED.
     */
    int32_t (*inspect)(void *, jde_context *, const jde_problems *);
};

/** The list of problems; opaque to the plugin. */
struct jde_found;

/**
 * The functions with which a plugin reports problems. Valid only until its jde_inspect.inspect returns, and
 * on its thread.
 */
struct jde_problems {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** The first argument of the function below. */
    jde_found *found;
    /**
     * Adds a problem of the modulation `port`: what is wrong and what to do, as `length` bytes of UTF-8,
     * which are copied. `kind` is JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE. An export that is unavailable never
     * has a value, and `jde check` warns of what imports it. JDE_BAD_ARGUMENT for
     * another kind, a null text, and beyond JDE_PROBLEMS_MOST.
     */
    int32_t (*add)(jde_found *, uint32_t kind, uint32_t port, const char *text, uint64_t length);
};

/** The table that jde_schema.ability returns for JDE_ABILITY_GUARD. Only a perceptive schema has it. */
struct jde_guard {
    /** Bytes of this table. */
    uint32_t size;
    /** The number of the export by whose newest value the guard judges. */
    uint32_t state;
    /** The type of the commands that it judges. */
    const jde_type *command;
    /**
     * Judges a command. `state` is the newest value of the export, `age_ns` old; `command` is the command.
     * Both are readable for the length of the call.
     *
     * Called in the thread that commands, and in the guard's after its iteration for a command that is in force,
     * any number of times at once and without an instance. The result depends on the arguments alone. It changes
     * nothing that lasts beyond the call, waits for nothing, and returns within microseconds. One that does not
     * return is a hang of the guard. Any result but JDE_OK refuses the command.
     */
    int32_t (*judge)(const void *state, uint64_t age_ns, const void *command, jde_judgement *out);
};

/** The judgement of a command, which the host lends. */
struct jde_judgement {
    /** Bytes of this table. */
    uint32_t size;
    /** Whether the command may take effect: 0 or 1; or JDE_LIMITED. 0 when the call begins. */
    uint32_t accepted;
    /** Why it is refused or limited, as UTF-8 that ends with a NUL; ignored if it is accepted. */
    char reason[128];
    /**
     * Room for a command of the guard's type: what takes effect if the command is limited. Since minor version 8;
     * the size states whether the host has it.
     */
    void *command;
};

/**
 * The table that jde_schema.ability returns for JDE_ABILITY_LISTS. The type has at least one port
 * besides.
 */
struct jde_lists {
    /** Bytes of this table. */
    uint32_t size;
    /** The number of lists, at least 1. */
    uint32_t count;
    /** The lists. The stride is the `size` of the first. */
    const jde_port_list *lists;
    /** Receives the ports of all lists. Called once, after `create` and before any other function. What the tables point to stays unchanged until the process ends. */
    int32_t (*set)(void *, jde_context *, const jde_listed_port *, uint32_t count);
};

/**
 * A list of ports: a table of the application file whose entries are imports, exports or commands of any type, each
 * with settings.
 */
struct jde_port_list {
    /** Bytes of this table. */
    uint32_t size;
    /**
     * What the ports are: JDE_IMPORT, JDE_EXPORT, or of a driver JDE_COMMAND, whose neutral value is all
     * zeros and which lets the driver iterate at once. Commands exist since minor version 8.
     */
    uint32_t kind;
    /** Its name: that of the table in the application file. */
    const char *name;
    /** What it means. */
    const char *doc;
    /** The type of the settings of each entry: a structure whose fields are their keys. */
    const jde_type *settings;
    /** The settings that an entry does not state, `settings->bytes` bytes. */
    const void *initial;
    /**
     * How long a command is in force without being repeated, ns, at least 1, or how long a value of an export is
     * valid, as in jde_port. Since minor version 8.
     */
    uint64_t validity_ns;
};

/** A port of a list. */
struct jde_listed_port {
    /** Bytes of this table. */
    uint32_t size;
    /** The place of its list among the lists of the type. */
    uint32_t list;
    /** Its number in calls. */
    uint32_t port;
    /** 0. */
    uint32_t reserved;
    /** The entry's key in the application file: any text. */
    const char *label;
    /** The type of its value. */
    const jde_type *value_type;
    /** Its settings, in the type of the list. */
    const void *settings;
};

/** The table that jde_host.extension returns for JDE_EXTENSION_TURNS. It lives until the process ends. */
struct jde_turns {
    /** Bytes of this table. */
    uint32_t size;
    /** 0. */
    uint32_t reserved;
    /** Returns a handle of the instance whose call has this context. Give it to `close` once. */
    void *(*open)(jde_context *);
    /**
     * Requests a turn of the instance in addition to the periodic ones (R12), if the instance is awake. Requests before
     * that turn begins are one. Does not block. Any thread may call it, also after the instance or the application
     * has ended.
     */
    void (*request)(const void *);
    /** Frees a handle. */
    void (*close)(void *);
};

/*
 * The rest of this file is for authors in C and C++: macros that fill tables, and functions that call the host.
 */

#if defined(__GNUC__)
#define JDE_VISIBLE __attribute__((visibility("default")))
#else
#define JDE_VISIBLE
#endif

/** The number of elements of an array. */
#define JDE_COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
/** Milliseconds in ns. */
#define JDE_MS(number) ((uint64_t)(number) * UINT64_C(1000000))
/** No least or greatest value. */
#define JDE_UNBOUNDED ((double)NAN)

/** Exports the plugin: its name, its version, one sentence, and its array of jde_schema. Once in a library. */
#define JDE_PLUGIN(name, version, doc, schemas) JDE_PLUGIN_OF(0u, name, version, doc, schemas)
/** The same for a plugin in C++ all of whose functions run within jde_guarded. */
#define JDE_PLUGIN_GUARDED(name, version, doc, schemas) JDE_PLUGIN_OF(JDE_PLUGIN_CATCHES, name, version, doc, schemas)
/** The same, with its flags. */
#define JDE_PLUGIN_OF(flags, name, version, doc, schemas)                                                   \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), flags, name, version, doc,   \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port of a kind. Fields that a kind does not use are NULL, JDE_UNBOUNDED or 0. */
#define JDE_PORT(kind, name, doc, unit, type, initial, min, max, validity_ns, flags, child, choices, choice_count)      \
    {(uint32_t)sizeof(jde_port), kind, name, doc, unit, &(type), initial, min, max, validity_ns, flags, child, choices, \
     choice_count, 0u, 0}
/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    JDE_PORT(JDE_IMPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u, NULL, 0u)
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    JDE_PORT(JDE_EXPORT, name, doc, "", type, NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u, NULL, 0u)
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    JDE_PORT(JDE_MODULATION, name, doc, unit, type, &(initial), min, max, 0u, flags, 0u, NULL, 0u)
/** A jde_port that is a choice. `type` is a whole number, and `choices` is an array of the names of its values from 0 on. */
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
/** A jde_child that does not compete. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Returns whether this header supports a host. Call it in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= offsetof(jde_host, retract) && host->abi_major == JDE_ABI_MAJOR;
}

/** Whether a host has a function of a later minor version: `if (JDE_HOST_HAS(host, retract)) host->retract(...)`. */
#define JDE_HOST_HAS(host, function) \
    ((host)->size >= offsetof(jde_host, function) + sizeof((host)->function) && (host)->function != NULL)

/** Returns the value of an import, modulation or command of `bytes` bytes, or NULL if there is none. `sample` may be NULL. */
static inline const void *jde_get(const jde_host *host, jde_context *context, uint32_t port, size_t bytes,
                                  jde_sample *sample)
{
    jde_sample local;
    jde_sample *result = sample != NULL ? sample : &local;
    if (host->read(context, port, result) != JDE_OK || result->bytes != bytes) {
        return NULL;
    }
    return result->data;
}

/** Writes `bytes` bytes to an export, actuator or child's modulation. Returns the codes of jde_host.publish. */
static inline int32_t jde_put(const jde_host *host, jde_context *context, uint32_t port, const void *value,
                              size_t bytes)
{
    void *buffer = NULL;
    int32_t code = host->loan(context, port, &buffer);
    if (code != JDE_OK) {
        return code;
    }
    memcpy(buffer, value, bytes);
    return host->publish(context, port, 0u);
}

/** Writes a log message. */
static inline void jde_say(const jde_host *host, jde_context *context, uint32_t level, const char *text)
{
    host->log(context, level, text, strlen(text));
}

/** States the reason for a failure: `return jde_failed(host, context, "the cable is loose");`. */
static inline int32_t jde_failed(const jde_host *host, jde_context *context, const char *reason)
{
    host->fail(context, reason, strlen(reason));
    return JDE_FAILED;
}

/*
 * C++. An exception that leaves a function of the plugin ends the application: the host cannot catch an exception of
 * another language. Run the body of each function within jde_guarded:
 *
 *     static int32_t iterate(void *instance, jde_context *context)
 *     {
 *         my_schema *self = static_cast<my_schema *>(instance);
 *         return jde_guarded(self->host, context, JDE_PANICKED, [&]() -> int32_t { return self->iterate(context); });
 *     }
 *
 * and export the plugin with JDE_PLUGIN_GUARDED. Run any other C++ plugin with `isolate = "process"`: an exception then
 * ends only that process, and the schema is Faulted.
 */
#ifdef __cplusplus
} /* extern "C" */

#include <exception>

/** Returns the result of `body`. If it throws, passes the reason to jde_host.fail and returns `fallback`. Never throws. */
template <typename Result, typename Body>
static inline Result jde_guarded(const jde_host *host, jde_context *context, Result fallback, Body body) noexcept
{
    try {
        return body();
    } catch (const std::exception &thrown) {
        host->fail(context, thrown.what(), strlen(thrown.what()));
    } catch (...) {
        static const char reason[] = "it threw something that is not a std::exception";
        host->fail(context, reason, sizeof reason - 1u);
    }
    return fallback;
}

extern "C" {
#endif

/*
 * Reloading. A schema that passes its memory to its next build returns its jde_state from jde_schema.ability:
 *
 *     static const jde_state state = {(uint32_t)sizeof(jde_state), 1u, save, restore};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_STATE) == 0 ? &state : NULL; }
 */

/** Appends bytes to the saved memory. */
static inline int32_t jde_save(const jde_saver *saver, const void *bytes, size_t length)
{
    return saver->write(saver->saving, bytes, (uint64_t)length);
}

/*
 * Inspection. A schema that inspects what its modulations name before the application starts returns its jde_inspect
 * from jde_schema.ability:
 *
 *     static const jde_inspect inspection = {(uint32_t)sizeof(jde_inspect), 0u, inspect};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_INSPECT) == 0 ? &inspection : NULL; }
 */

/** Adds a problem of the modulation `port`. `kind` is JDE_PROBLEM_WRONG or JDE_PROBLEM_UNAVAILABLE. */
static inline int32_t jde_problem(const jde_problems *problems, uint32_t kind, uint32_t port, const char *text)
{
    return problems->add(problems->found, kind, port, text, (uint64_t)strlen(text));
}

/*
 * Guards. A perceptive schema that judges commands before they take effect returns its jde_guard from
 * jde_schema.ability:
 *
 *     static const jde_guard guard = {(uint32_t)sizeof(jde_guard), 0u, &jde_twist_type, judge};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_GUARD) == 0 ? &guard : NULL; }
 */

/** Accepts the command. */
static inline int32_t jde_accept(jde_judgement *out)
{
    out->accepted = 1u;
    return JDE_OK;
}

/** Refuses the command for this reason, which is cut after 127 bytes. */
static inline int32_t jde_refuse(jde_judgement *out, const char *reason)
{
    size_t length = strlen(reason);
    if (length >= sizeof out->reason)
        length = sizeof out->reason - 1u;
    memcpy(out->reason, reason, length);
    out->reason[length] = '\0';
    out->accepted = 0u;
    return JDE_OK;
}

/**
 * Lets this command of so many bytes take effect instead of the judged one, for this reason. A host before minor version 8
 * refuses the command.
 */
static inline int32_t jde_limit(jde_judgement *out, const void *command, size_t bytes, const char *reason)
{
    jde_refuse(out, reason);
    if (out->size >= (uint32_t)sizeof(jde_judgement)) {
        memcpy(out->command, command, bytes);
        out->accepted = JDE_LIMITED;
    }
    return JDE_OK;
}

/*
 * Panels. A schema with a panel returns its jde_panel from jde_schema.ability:
 *
 *     static const jde_panel panel = {(uint32_t)sizeof(jde_panel), 0u, draw, touch};
 *     static const void *ability(const char *id) { return strcmp(id, JDE_ABILITY_PANEL) == 0 ? &panel : NULL; }
 *
 * The functions below return the codes of the functions of jde_pen. The plugin may ignore them: the panel shows any mistake.
 */

/** Returns a widget of a kind. All other fields are 0. */
static inline jde_widget jde_widget_of(uint32_t kind)
{
    jde_widget widget;
    memset(&widget, 0, sizeof widget);
    widget.size = (uint32_t)sizeof widget;
    widget.kind = kind;
    return widget;
}

/** Returns a shape of a kind and a color. All other fields are 0. */
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

/** Closes the row, group, plot, canvas or scene that was opened last. */
static inline int32_t jde_end(const jde_pen *pen)
{
    return pen->end(pen->drawing);
}

/** Adds a text in the style `words`. */
static inline int32_t jde_add_text(const jde_pen *pen, uint32_t words, const char *text)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TEXT);
    widget.label = text;
    widget.number = words;
    return jde_add(pen, &widget);
}

/** Adds a number with its name and unit. */
static inline int32_t jde_add_value(const jde_pen *pen, const char *label, double value, const char *unit)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_VALUE);
    widget.label = label;
    widget.value = value;
    widget.unit = unit;
    return jde_add(pen, &widget);
}

/** Adds a button. `flags` is 0 or JDE_DISABLED. */
static inline int32_t jde_add_button(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_BUTTON);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Adds a toggle, which is on (1) or off (0). */
static inline int32_t jde_add_toggle(const jde_pen *pen, const char *id, const char *label, uint32_t on)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_TOGGLE);
    widget.id = id;
    widget.label = label;
    widget.number = on;
    return jde_add(pen, &widget);
}

/** Adds a slider. */
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

/** Adds a choice among texts. `chosen` is the index of the present one. */
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

/** Adds a table. `texts` are the headings of the columns and then the cells row by row, `count` in all. */
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

/** Adds an image. `pixels` are rows from the top, without gaps. */
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

/** Opens a row of widgets, up to jde_end. */
static inline int32_t jde_begin_row(const jde_pen *pen)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_ROW);
    return jde_add(pen, &widget);
}

/** Opens a group of widgets below a heading, up to jde_end. `flags` is 0 or JDE_FOLDED. */
static inline int32_t jde_begin_group(const jde_pen *pen, const char *id, const char *label, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_GROUP);
    widget.id = id;
    widget.label = label;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Opens a plot, up to jde_end. `axes` are the labels of the horizontal and the vertical axis. */
static inline int32_t jde_begin_plot(const jde_pen *pen, const char *id, const char *label, const char *const *axes)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_PLOT);
    widget.id = id;
    widget.label = label;
    widget.texts = axes;
    widget.text_count = 2u;
    return jde_add(pen, &widget);
}

/** Opens a plane in metres, up to jde_end. */
static inline int32_t jde_begin_canvas(const jde_pen *pen, const char *id, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_CANVAS);
    widget.id = id;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Opens a space in metres in a frame of REP-105, up to jde_end. */
static inline int32_t jde_begin_scene(const jde_pen *pen, const char *id, const char *frame, uint32_t flags)
{
    jde_widget widget = jde_widget_of(JDE_WIDGET_SCENE);
    widget.id = id;
    widget.label = frame;
    widget.flags = flags;
    return jde_add(pen, &widget);
}

/** Draws a shape of `count` points: JDE_SHAPE_LINE, _POINTS, _ARROW, _POLYGON or _MESH. */
static inline int32_t jde_draw_points(const jde_pen *pen, uint32_t kind, const double *points, uint32_t count,
                                      uint32_t color, uint32_t flags)
{
    jde_shape shape = jde_shape_of(kind, color);
    shape.points = points;
    shape.point_count = count;
    shape.flags = flags;
    return jde_draw(pen, &shape);
}

/** Draws a text at a point. */
static inline int32_t jde_draw_label(const jde_pen *pen, const double *at, const char *text, uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LABEL, color);
    shape.points = at;
    shape.point_count = 1u;
    shape.text = text;
    return jde_draw(pen, &shape);
}

/** Draws a curve of a plot, with its name. */
static inline int32_t jde_draw_curve(const jde_pen *pen, const char *name, const double *points, uint32_t count,
                                     uint32_t color)
{
    jde_shape shape = jde_shape_of(JDE_SHAPE_LINE, color);
    shape.points = points;
    shape.point_count = count;
    shape.text = name;
    return jde_draw(pen, &shape);
}

/** Draws JDE_SHAPE_CIRCLE or JDE_SHAPE_SPHERE about a point. */
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

/** Draws the outline of the robot that the application drives. */
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

/** Returns whether a gesture has this kind and is on this widget. */
static inline int jde_touched(const jde_gesture *gesture, uint32_t kind, const char *id)
{
    return gesture->kind == kind && gesture->widget != NULL && strcmp(gesture->widget, id) == 0;
}

#ifdef __cplusplus
}
#endif

#endif
