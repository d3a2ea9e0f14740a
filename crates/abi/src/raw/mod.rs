//! The tables that cross the boundary, in C layout. Nothing of Rust's own layout (bool, enum, slice, String) appears here.
//!
//! Rules of this file, in the manner of CLAP:
//! - Tables only grow at the end; each begins with its `size`, which is also the stride of an array of such tables.
//! - Whoever reads a table takes what the shorter of the two has, its `size` or the reader's own: what is missing counts as 0 or
//!   null, what is beyond means nothing. One that is shorter than in the minor version that brought it is refused.
//! - Whoever fills in a table that the other side lent ([`Precondition`], [`Verdict`], [`ChildStatus`]) fills in no more than its
//!   `size` says, and leaves that as it is.
//! - A function that a minor version brought is beyond the `size`, or null, in a host that has it not: look before use.
//! - A host takes plugins of every minor version of its major one, older and newer. What it does not know it ignores where that is
//!   a field or a flag, and refuses by name where it is a kind.
//! - [`Sample`] alone states no size, for it is filled in at every read: its 40 bytes never change, and whatever else there
//!   may be to say of a value is asked for by a function of its own.
//! - A table given by a plugin, and all it points to, lives unchanged until the process ends (libraries are never unmapped).
//! - Texts are UTF-8 and end with a NUL. A null text pointer means an empty text.
//! - Whoever allocates frees. Nothing allocated on one side is freed by the other.
//! - No function unwinds: a panic or an exception is caught on the side where it arose.
//! - Calls for one instance never overlap, but may come from different threads one after another.

// A boundary is made of raw pointers; the checks live in `read`.
#![allow(unsafe_code)]

mod host;
mod inspect;
mod panel;
mod state;

use core::ffi::{c_char, c_void};

pub use host::*;
pub use inspect::*;
pub use panel::*;
pub use state::*;

/// The first eight bytes of a [`Plugin`]: "JDEPLUG1" read as a little-endian number.
pub const MAGIC: u64 = u64::from_le_bytes(*b"JDEPLUG1");
/// Changes when a table changes in a way that old readers would misread. Host and plugin must have the same.
pub const ABI_MAJOR: u32 = 1;
/// Grows when tables grow or an ability comes. Hosts up to 1.3 took plugins of their own minor version and older; later ones take
/// all.
pub const ABI_MINOR: u32 = 5;

/// The symbol of type [`Plugin`] that every plugin exports.
pub const ENTRY_SYMBOL: &str = "jde_plugin";

/// Plugin flag: built so that a panic aborts the process; the host refuses it.
pub const PLUGIN_ABORTS: u32 = 1;
/// Plugin flag: none of its functions lets an exception of C++ out. Since minor version 4.
pub const PLUGIN_CATCHES: u32 = 2;

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

/// The number is outside of what the child's modulation takes (R8). Counted and shown; not a fault. Since minor version 4: whoever
/// was built before is told [`NOT_FINITE`].
pub const OUT_OF_RANGE: i32 = 8;

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
/// Modulation flag: taken when the schema awakes, and kept until it sleeps; later writes count from the next awakening (R8).
pub const FIXED: u32 = 4;
/// Child flag, of the last child only: any number of motor children, named and grouped by the application, numbered from here on.
pub const MANY: u32 = 8;

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

/// What the host knows of an instance; opaque to the plugin, and only valid inside a call of that instance.
#[repr(C)]
pub struct Context {
    _opaque: [u8; 0],
}

/// What a plugin exports under the name `jde_plugin`.
///
/// The host reads `magic`, `abi_major` and `abi_minor` before anything else; these three fields never move.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Plugin {
    /// [`MAGIC`].
    pub magic: u64,
    /// [`ABI_MAJOR`] of the header the plugin was built with.
    pub abi_major: u32,
    /// [`ABI_MINOR`] of the header the plugin was built with.
    pub abi_minor: u32,
    /// Bytes of this table.
    pub size: u32,
    /// [`PLUGIN_ABORTS`], [`PLUGIN_CATCHES`].
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
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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
    /// Names of the numbers from 0 on, of a modulation that is one of several; `min` is 0 then and `max` the last. Since minor
    /// version 4.
    pub choices: *const *const c_char,
    /// How many; 0 for a plain number. Since minor version 4.
    pub choice_count: u32,
    /// 0.
    pub reserved: u32,
}

/// A role that a schema type has for a child; the application says which instance plays it.
#[repr(C)]
#[derive(Clone, Copy)]
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
    /// [`OPTIONAL`], [`MANY`].
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

/// A type of value: plain data of fixed size, every bit pattern valid, every byte described.
#[repr(C)]
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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

/// A value as a port shows it; the data stays as it is until the present call of the instance returns. It never grows.
#[repr(C)]
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
pub struct ChildStatus {
    /// Bytes of this table. Whoever asks states them before.
    pub size: u32,
    /// [`SLEPT`], [`CHECKING`], [`READY`] or [`WINNER`].
    pub state: u32,
    /// 1 while it is Faulted.
    pub faulted: u32,
    /// 0.
    pub reserved: u32,
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
