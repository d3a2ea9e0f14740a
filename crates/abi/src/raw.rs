//! The tables that cross the boundary, in C layout. Nothing of Rust's own layout (bool, enum, slice, String) appears here.
//!
//! Rules of this file, in the manner of CLAP:
//! - Tables only grow at the end; each begins with its `size`, which is also the stride of an array of such tables. A reader
//!   uses no field past the `size` it finds.
//! - A table given by a plugin, and all it points to, lives unchanged until the process ends (libraries are never unmapped).
//! - Texts are UTF-8 and end with a NUL. A null text pointer means an empty text.
//! - Whoever allocates frees. Nothing allocated on one side is freed by the other.
//! - No function unwinds: a panic or an exception is caught on the side where it arose.
//! - Calls for one instance never overlap, but may come from different threads one after another.

// A boundary is made of raw pointers; the checks live in `read`.
#![allow(unsafe_code)]

mod panel;
mod state;

use core::ffi::{c_char, c_void};

pub use panel::*;
pub use state::*;

/// The first eight bytes of a [`Plugin`]: "JDEPLUG1" read as a little-endian number.
pub const MAGIC: u64 = u64::from_le_bytes(*b"JDEPLUG1");
/// Changes when a table changes in a way that old readers would misread. Host and plugin must have the same.
pub const ABI_MAJOR: u32 = 1;
/// Grows when tables grow. A host accepts plugins of its own minor version and older.
pub const ABI_MINOR: u32 = 3;

/// The symbol of type [`Plugin`] that every plugin exports.
pub const ENTRY_SYMBOL: &str = "jde_plugin";

/// Plugin flag: built so that a panic aborts the process; the host refuses it.
pub const PLUGIN_ABORTS: u32 = 1;

/// It worked.
pub const OK: i32 = 0;
/// Nothing has been published on this port yet.
pub const NO_VALUE: i32 = 1;
/// The caller has no authority at this instant (R7), or an operator holds the child. Counted and shown; not a fault. Any function
/// that shows or changes something answers so, uncounted, to a call that hung and was given up: it should return.
pub const REFUSED: i32 = 2;
/// The value holds a NaN or an infinity where a finite number is required. Counted and shown; not a fault.
pub const NOT_FINITE: i32 = 3;
/// No such port, child or group, or a call that this port does not allow.
pub const BAD_ARGUMENT: i32 = 4;
/// An optional port or child that the application left unbound.
pub const UNBOUND: i32 = 5;
/// The schema failed; the reason was given to [`Host::fail`].
pub const FAILED: i32 = 6;
/// The schema panicked; the reason was given to [`Host::fail`].
pub const PANICKED: i32 = 7;

/// Schema kind: turns data into better data.
pub const PERCEPTIVE: u32 = 0;
/// Schema kind: has a precondition, competes, commands.
pub const MOTOR: u32 = 1;
/// Schema kind: exports sensors and takes commands.
pub const DRIVER: u32 = 2;

/// Schema state: costs no CPU; keeps its memory.
pub const SLEPT: u32 = 0;
/// Schema state: awake, precondition false at the last check.
pub const CHECKING: u32 = 1;
/// Schema state: awake, precondition true, not chosen.
pub const READY: u32 = 2;
/// Schema state: iterates; a motor schema may command and wake children.
pub const WINNER: u32 = 3;

/// Port kind: a variable of another schema that this one reads.
pub const IMPORT: u32 = 0;
/// Port kind: a variable that this schema writes and any may read.
pub const EXPORT: u32 = 1;
/// Port kind: an input that the father or an operator writes while the schema runs.
pub const MODULATION: u32 = 2;
/// Port kind: an input of a driver that reaches an actuator.
pub const COMMAND: u32 = 3;
/// Port kind: a driver's command that this motor schema writes.
pub const ACTUATOR: u32 = 4;
/// Port kind: a modulation of a child that this schema writes.
pub const CHILD_MODULATION: u32 = 5;

/// Port or child flag: the application may leave it unbound.
pub const OPTIONAL: u32 = 1;
/// Import flag: a new value re-evaluates the precondition at once (R12), unless the application says otherwise.
pub const TRIGGER: u32 = 2;
/// Modulation flag: read when the schema awakes; later writes count from the next awakening.
pub const FIXED: u32 = 4;

/// Sample flag: no command is in force; the data is the neutral value.
pub const SAMPLE_NEUTRAL: u32 = 1;
/// Sample flag: nobody has written this modulation; the data is its default.
pub const SAMPLE_DEFAULT: u32 = 2;

/// Scalar kind: one byte, 0 or 1.
pub const BOOL: u32 = 0;
/// Scalar kind: unsigned 8 bits.
pub const U8: u32 = 1;
/// Scalar kind: unsigned 16 bits.
pub const U16: u32 = 2;
/// Scalar kind: unsigned 32 bits.
pub const U32: u32 = 3;
/// Scalar kind: unsigned 64 bits.
pub const U64: u32 = 4;
/// Scalar kind: signed 8 bits.
pub const I8: u32 = 5;
/// Scalar kind: signed 16 bits.
pub const I16: u32 = 6;
/// Scalar kind: signed 32 bits.
pub const I32: u32 = 7;
/// Scalar kind: signed 64 bits.
pub const I64: u32 = 8;
/// Scalar kind: IEEE 754, 32 bits.
pub const F32: u32 = 9;
/// Scalar kind: IEEE 754, 64 bits.
pub const F64: u32 = 10;
/// Field kind: a structure with a [`Type`] of its own.
pub const STRUCT: u32 = 11;

/// Field form: one element.
pub const ONE: u32 = 0;
/// Field form: exactly `capacity` elements.
pub const ARRAY: u32 = 1;
/// Field form: up to `capacity` elements, their number a `u32` at `length_offset`. Where the first element comes eight bytes
/// after that, the four bytes between belong to the number and mean nothing: so elements of any alignment leave no gap.
pub const SEQUENCE: u32 = 2;
/// Field form: UTF-8 of up to `capacity` bytes, their number a `u32` at `length_offset`.
pub const TEXT: u32 = 3;
/// Field form: `capacity` bytes ([`U8`]) that mean nothing, where C would leave a gap; no description shows them.
pub const PADDING: u32 = 4;

/// Log level: for the developer of this schema, in every iteration if need be.
pub const TRACE: u32 = 0;
/// Log level: for the developer of this schema.
pub const DEBUG: u32 = 1;
/// Log level: for whoever runs the application.
pub const INFO: u32 = 2;
/// Log level: something is off, the schema goes on.
pub const WARN: u32 = 3;
/// Log level: something failed.
pub const ERROR: u32 = 4;

/// Selection case: exactly one READY.
pub const ALONE: u32 = 0;
/// Selection case: two or more READY.
pub const COLLISION: u32 = 1;
/// Selection case: none READY.
pub const ABSENCE: u32 = 2;

/// Policy kind: the order in which the father names its children.
pub const POLICY_PRIORITY: u32 = 0;
/// Policy kind: the highest number that a candidate offers.
pub const POLICY_URGENCY: u32 = 1;
/// Policy kind: the winner stays for `dwell_ns` and until a rival is `hysteresis` more urgent.
pub const POLICY_STICKY: u32 = 2;
/// Policy kind: each READY child in turn, `dwell_ns` each.
pub const POLICY_ROUND_ROBIN: u32 = 3;
/// Policy kind: the father's own function.
pub const POLICY_FATHER: u32 = 4;

/// What the host knows of an instance; opaque to the plugin, and only valid inside a call of that instance.
#[repr(C)]
pub struct Context {
    _opaque: [u8; 0],
}

/// What a plugin exports under the name `jde_plugin`.
///
/// The host reads `magic`, `abi_major` and `abi_minor` before anything else; these three fields never move.
#[repr(C)]
#[derive(Debug)]
pub struct Plugin {
    /// [`MAGIC`].
    pub magic: u64,
    /// [`ABI_MAJOR`] of the header the plugin was built with.
    pub abi_major: u32,
    /// [`ABI_MINOR`] of the header the plugin was built with.
    pub abi_minor: u32,
    /// Bytes of this table.
    pub size: u32,
    /// [`PLUGIN_ABORTS`] or 0.
    pub flags: u32,
    /// Name of the plugin: lower-case letters, digits, `-`; the file is `lib<name>.so` with `-` written `_`.
    pub name: *const c_char,
    /// Version of the plugin, as its author counts.
    pub version: *const c_char,
    /// One sentence on what the plugin holds.
    pub doc: *const c_char,
    /// The schema types; stride is the first one's `size`.
    pub schemas: *const Schema,
    /// How many.
    pub schema_count: u32,
    /// 0.
    pub reserved: u32,
}

/// A type of schema: what it is, what it reads and writes, and the functions of its instances.
#[repr(C)]
pub struct Schema {
    /// Bytes of this table.
    pub size: u32,
    /// [`PERCEPTIVE`], [`MOTOR`] or [`DRIVER`].
    pub kind: u32,
    /// Name of the type: lower-case letters, digits, `-`, `_`.
    pub name: *const c_char,
    /// What it does; the first line is a sentence of its own.
    pub doc: *const c_char,
    /// Default period of its iterations, ns; at least 1.
    pub period_ns: u64,
    /// Longest an iteration may take, ns; 0 means the period.
    pub budget_ns: u64,
    /// Its ports; a port is named in calls by its place here. Stride is the first one's `size`.
    pub ports: *const Port,
    /// The roles of its children; a child is named in calls by its place here. Stride is the first one's `size`.
    pub children: *const Child,
    /// How many ports.
    pub port_count: u32,
    /// How many children.
    pub child_count: u32,

    /// Makes an instance, SLEPT. Called once, before any other. Null on failure, with the reason given to [`Host::fail`].
    pub create: Option<unsafe extern "C" fn(*const Schema, *const Host, *mut Context) -> *mut c_void>,
    /// Ends an instance that is SLEPT. Called once, after any other. May be null.
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
    /// It leaves SLEPT: before its first check or iteration. May be null.
    pub awake: Option<unsafe extern "C" fn(*mut c_void, *mut Context) -> i32>,
    /// Evaluates the precondition of a motor schema. Null: always READY.
    pub check: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *mut Precondition) -> i32>,
    /// One iteration, as WINNER. Must return within the budget.
    pub iterate: Option<unsafe extern "C" fn(*mut c_void, *mut Context) -> i32>,
    /// The father's own arbitration (R4). Null: the schema has none.
    pub arbitrate: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Level, *mut Verdict) -> i32>,
    /// It goes to SLEPT: after its last iteration. A driver stops its actuators here. May be null.
    pub sleep: Option<unsafe extern "C" fn(*mut c_void, *mut Context)>,
    /// An optional ability by its id, such as "jde.panel"; null where it has none. May be null.
    pub ability: Option<unsafe extern "C" fn(*const c_char) -> *const c_void>,
}

/// An input or output of a schema type.
#[repr(C)]
pub struct Port {
    /// Bytes of this table.
    pub size: u32,
    /// [`IMPORT`], [`EXPORT`], [`MODULATION`], [`COMMAND`], [`ACTUATOR`] or [`CHILD_MODULATION`].
    pub kind: u32,
    /// Its name, unique among ports of this kind (and child); for [`CHILD_MODULATION`] that of the child's modulation.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Unit of a plain number ("m", "rad/s"); empty for none, or where the type's fields have their own.
    pub unit: *const c_char,
    /// Type of its value.
    pub value_type: *const Type,
    /// Default of a modulation or neutral value of a command, `value_type->bytes` bytes; else null.
    pub initial: *const c_void,
    /// Least allowed value of a number given as a modulation; NaN for none.
    pub min: f64,
    /// Greatest allowed value of a number given as a modulation; NaN for none.
    pub max: f64,
    /// How long a command is in force without being repeated, ns; for [`COMMAND`] only, at least 1.
    pub validity_ns: u64,
    /// [`OPTIONAL`], [`TRIGGER`], [`FIXED`].
    pub flags: u32,
    /// The child whose modulation this is; for [`CHILD_MODULATION`] only.
    pub child: u32,
}

/// A role that a schema type has for a child; the application says which instance plays it.
#[repr(C)]
pub struct Child {
    /// Bytes of this table.
    pub size: u32,
    /// [`PERCEPTIVE`] or [`MOTOR`].
    pub kind: u32,
    /// Name of the role.
    pub name: *const c_char,
    /// Name of the group in which a motor child competes; children of one group have one winner.
    pub group: *const c_char,
    /// What the child is for.
    pub doc: *const c_char,
    /// [`OPTIONAL`].
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

/// A type of value: plain data of fixed size, every bit pattern valid, every byte described.
#[repr(C)]
pub struct Type {
    /// Bytes of this table.
    pub size: u32,
    /// How many fields.
    pub field_count: u32,
    /// Name, as ROS 2 writes it: "sensor_msgs/msg/LaserScan". Types are the same when names and layouts are the same.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Bytes of a value.
    pub bytes: u64,
    /// Alignment of a value, at most 16.
    pub align: u64,
    /// The fields, in the order of their ROS interface; stride is the first one's `size`.
    pub fields: *const Field,
}

/// A field of a [`Type`].
#[repr(C)]
pub struct Field {
    /// Bytes of this table.
    pub size: u32,
    /// [`BOOL`] to [`F64`], or [`STRUCT`].
    pub kind: u32,
    /// [`ONE`], [`ARRAY`], [`SEQUENCE`], [`TEXT`] or [`PADDING`].
    pub form: u32,
    /// Most elements; 1 for [`ONE`].
    pub capacity: u32,
    /// Name of the field.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Unit ("m", "rad"); empty for none.
    pub unit: *const c_char,
    /// Bytes from the start of the value to the first element.
    pub offset: u64,
    /// Bytes from the start of the value to the number of elements; for [`SEQUENCE`] and [`TEXT`] only.
    pub length_offset: u64,
    /// Type of the elements; for [`STRUCT`] only.
    pub value_type: *const Type,
}

/// A value as a port shows it; the data stays as it is until the present call of the instance returns.
#[repr(C)]
pub struct Sample {
    /// The value.
    pub data: *const c_void,
    /// Its size.
    pub bytes: u64,
    /// When it was measured or written, ns since the application's start.
    pub time_ns: u64,
    /// Counts the values of this variable from 1.
    pub sequence: u64,
    /// Who wrote it: the number of an instance in this application.
    pub writer: u32,
    /// [`SAMPLE_NEUTRAL`], [`SAMPLE_DEFAULT`].
    pub flags: u32,
}

/// The answer to a check.
#[repr(C)]
pub struct Precondition {
    /// Bytes of this table.
    pub size: u32,
    /// 1 if the precondition holds, else 0.
    pub ready: u32,
    /// How urgent it is to win, for policies that ask; any finite number, 0 by default.
    pub urgency: f64,
}

/// The snapshot of a group given to the father's own arbitration.
#[repr(C)]
pub struct Level {
    /// Bytes of this table.
    pub size: u32,
    /// [`COLLISION`] or [`ABSENCE`].
    pub case: u32,
    /// Name of the group.
    pub group: *const c_char,
    /// Awake children of the group, in the father's order; stride is the first one's `size`.
    pub candidates: *const Candidate,
    /// How many.
    pub candidate_count: u32,
    /// The child that is WINNER now, -1 for none.
    pub winner: i32,
}

/// A child that competes.
#[repr(C)]
pub struct Candidate {
    /// Bytes of this table.
    pub size: u32,
    /// Its role: its place in [`Schema::children`].
    pub child: u32,
    /// [`CHECKING`], [`READY`] or [`WINNER`].
    pub state: u32,
    /// 1 if its precondition held at its last check.
    pub ready: u32,
    /// What it offered at its last check.
    pub urgency: f64,
}

/// The father's answer.
#[repr(C)]
pub struct Verdict {
    /// Bytes of this table.
    pub size: u32,
    /// The chosen child, -1 for nobody.
    pub child: i32,
    /// Why, in words; ends with a NUL.
    pub reason: [c_char; 128],
}

/// What a father sees of a child.
#[repr(C)]
pub struct ChildStatus {
    /// Bytes of this table.
    pub size: u32,
    /// [`SLEPT`], [`CHECKING`], [`READY`] or [`WINNER`].
    pub state: u32,
    /// 1 while it is Faulted.
    pub faulted: u32,
    /// 0.
    pub reserved: u32,
}

/// What the host offers to an instance. Every function is called with the [`Context`] of the present call, on its thread,
/// and only until that call returns. None blocks.
#[repr(C)]
pub struct Host {
    /// Bytes of this table.
    pub size: u32,
    /// [`ABI_MAJOR`] of the host.
    pub abi_major: u32,
    /// [`ABI_MINOR`] of the host.
    pub abi_minor: u32,
    /// 0.
    pub reserved: u32,
    /// The value of an import, modulation or command. The same value throughout a check and the iteration that follows it (R8).
    /// [`NO_VALUE`], [`UNBOUND`], [`BAD_ARGUMENT`].
    pub read: unsafe extern "C" fn(*mut Context, port: u32, *mut Sample) -> i32,
    /// Room to write the next value of an export, actuator or child's modulation, aligned for its type; its bytes hold
    /// anything. Nobody sees it before `publish`; a loan that is not published by the end of the call is dropped.
    /// [`UNBOUND`], [`BAD_ARGUMENT`].
    pub loan: unsafe extern "C" fn(*mut Context, port: u32, *mut *mut c_void) -> i32,
    /// Publishes what was loaned, measured at `time_ns` (0: now). [`REFUSED`] and [`NOT_FINITE`] for commands, [`BAD_ARGUMENT`].
    pub publish: unsafe extern "C" fn(*mut Context, port: u32, time_ns: u64) -> i32,
    /// Wakes a child (R7). Waking one that is awake changes nothing. [`REFUSED`], [`UNBOUND`], [`BAD_ARGUMENT`].
    pub wake: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// Puts a child and its subtree to sleep. [`REFUSED`], [`UNBOUND`], [`BAD_ARGUMENT`].
    pub sleep: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// What a child is doing. [`UNBOUND`], [`BAD_ARGUMENT`].
    pub child: unsafe extern "C" fn(*mut Context, child: u32, *mut ChildStatus) -> i32,
    /// Changes the policy of a group of children, named by one of them: [`POLICY_PRIORITY`] to [`POLICY_FATHER`],
    /// with its dwell or turn and its hysteresis.
    pub set_policy:
        unsafe extern "C" fn(*mut Context, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> i32,
    /// ns since the application's start; stands still during a call in lockstep.
    pub now: unsafe extern "C" fn(*mut Context) -> u64,
    /// A number that depends on the application's seed and the instance's name alone.
    pub seed: unsafe extern "C" fn(*mut Context) -> u64,
    /// A number that instances of one running application share and no other application of this process has.
    pub application: unsafe extern "C" fn(*mut Context) -> u64,
    /// The instance's name in the application; lives as long as the instance.
    pub name: unsafe extern "C" fn(*mut Context) -> *const c_char,
    /// Says something to whoever listens; `text` is `length` bytes of UTF-8.
    pub log: unsafe extern "C" fn(*mut Context, level: u32, text: *const c_char, length: u64),
    /// Gives the reason for the error that this call is about to return; `text` is `length` bytes of UTF-8.
    pub fail: unsafe extern "C" fn(*mut Context, text: *const c_char, length: u64),
    /// An extension of the host by its id; null where it has none.
    pub extension: unsafe extern "C" fn(*mut Context, id: *const c_char) -> *const c_void,
    /// Takes back the newest value of an export, because it no longer tells how things are: until the next is published, all
    /// who read it are answered [`NO_VALUE`], and who is triggered by it looks again (R12). [`BAD_ARGUMENT`]. Since minor version 1.
    pub retract: unsafe extern "C" fn(*mut Context, port: u32) -> i32,
    /// 1 if the application's time passes as fast as everybody's; 0 in lockstep and at another speed, which no device follows.
    /// Since minor version 1.
    pub real_time: unsafe extern "C" fn(*mut Context) -> u32,
}

macro_rules! shareable {
    ($($table:ty),*) => { $(
        // SAFETY: the tables are immutable after they are made and hold no interior mutability; what they point to lives
        // unchanged until the process ends, by the rules at the head of this file.
        unsafe impl Sync for $table {}
        // SAFETY: as above; nothing in them belongs to a thread.
        unsafe impl Send for $table {}
    )* };
}
shareable!(Plugin, Schema, Port, Child, Type, Field);
