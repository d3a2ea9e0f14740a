//! The tables that cross the boundary, in C layout. They contain nothing of Rust's own layout (bool, enum,
//! slice, String).
//!
//! Rules of this file, in the manner of CLAP:
//! - Tables grow only at the end. Each begins with its `size`, which is also the stride of an array of such
//!   tables.
//! - A reader uses as many bytes of a table as the shorter layout has: its `size`, or the reader's own.
//!   Missing fields count as 0 or null, and further bytes are ignored. A table that is shorter than in the
//!   minor version that introduced it is refused.
//! - A writer of a table that the other side lent ([`Precondition`], [`Verdict`], [`ChildStatus`]) fills in
//!   no more than its `size`, and does not change that `size`.
//! - A function of a later minor version is beyond the `size` of an older host, or null: check before use.
//! - A host accepts plugins of every minor version of its major one, older and newer. It ignores unknown
//!   fields and flags, and refuses unknown kinds with a message.
//! - Only [`Sample`] states no size, because it is filled in at every read. Its 40 bytes never change.
//!   Further data of a value would have a function of its own.
//! - A table of a plugin, and all it points to, stays unchanged until the process ends (libraries are never
//!   unmapped).
//! - Texts are UTF-8 and end with a NUL; a null one is empty. The side that allocates memory frees it.
//! - No function unwinds: a panic or an exception is caught on the side where it arose.
//! - Calls of one instance never overlap, but may come from different threads one after another.

// The boundary consists of raw pointers; `read` checks them.
#![allow(unsafe_code)]

mod guard;
mod host;
mod inspect;
mod lists;
mod panel;
mod state;
mod turns;

use core::ffi::{c_char, c_void};

pub use guard::*;
pub use host::*;
pub use inspect::*;
pub use lists::*;
pub use panel::*;
pub use state::*;
pub use turns::*;

/// The first eight bytes of a [`Plugin`]: "JDEPLUG1" read as a little-endian number.
pub const MAGIC: u64 = u64::from_le_bytes(*b"JDEPLUG1");
/// Changes when older readers would misread a table. Host and plugin must have the same.
pub const ABI_MAJOR: u32 = 1;
/// Increases when tables grow or an ability is added. Hosts up to 1.3 accept plugins of their own minor
/// version and older; later ones accept all.
pub const ABI_MINOR: u32 = 9;

/// The symbol of type [`Plugin`] that every plugin exports.
pub const ENTRY_SYMBOL: &str = "jde_plugin";

/// Plugin flag: built so that a panic aborts the process. The host refuses it.
pub const PLUGIN_ABORTS: u32 = 1;
/// Plugin flag: no C++ exception leaves any of its functions. Since minor version 4.
pub const PLUGIN_CATCHES: u32 = 2;

/// Success.
pub const OK: i32 = 0;
/// This import has no value: nothing has been published yet, or the value has ended. A check or an iteration that returns
/// it ends there without a fault, and a motor schema is not READY (R19); hosts before minor version 8 call it a fault.
pub const NO_VALUE: i32 = 1;
/// The caller has no authority at this instant (R7), a guard refuses the command (R18), or an operator holds
/// the child. Counted and shown; not a
/// fault. Every function that reads or changes something also returns this, uncounted, to a call that hung
/// and was given up. Such a call should return.
pub const REFUSED: i32 = 2;
/// The value contains a NaN or an infinity where a finite number is required. Counted and shown; not a fault.
pub const NOT_FINITE: i32 = 3;
/// No such port, child or group, or a call that this port does not allow.
pub const BAD_ARGUMENT: i32 = 4;
/// An optional port or child that the application left unbound.
pub const UNBOUND: i32 = 5;
/// The schema failed. The reason was passed to [`Host::fail`].
pub const FAILED: i32 = 6;
/// The schema panicked. The reason was passed to [`Host::fail`].
pub const PANICKED: i32 = 7;

/// The number is outside the limits of the child's modulation (R8). Counted and shown; not a fault. Since
/// minor version 4: older plugins get [`NOT_FINITE`].
pub const OUT_OF_RANGE: i32 = 8;

/// Schema kind: turns data into better data.
pub const PERCEPTIVE: u32 = 0;
/// Schema kind: has a precondition, competes, commands.
pub const MOTOR: u32 = 1;
/// Schema kind: exports sensors and takes commands.
pub const DRIVER: u32 = 2;

/// Schema state: uses no processor time; keeps its memory.
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
/// Import flag: a new value re-evaluates the precondition at once, or lets a schema without one iterate at once (R12),
/// unless the application sets other triggers. Command flag: a new command lets the driver iterate at once.
pub const TRIGGER: u32 = 2;
/// Modulation flag: read when the schema awakes, and kept until it sleeps. Later writes take effect at the
/// next awakening (R8).
pub const FIXED: u32 = 4;
/// Modulation flag: where the sensor of the imports of measurements is on the base. All that read a sensor state the same.
pub const MOUNT: u32 = 16;
/// Modulation flag: a distance kept from obstacles, where that of a guard is the least, or a zone around the base.
pub const MARGIN: u32 = 32;
/// Modulation flag: the greatest speed (m/s), turn rate (rad/s), or change of one (m/s2, rad/s2), that the schema asks of the
/// base, or by which its guard expects the base to brake. No schema asks for more than its driver and its guard state.
pub const LIMIT: u32 = 64;
/// Child flag, only for the last child: any number of motor children, which the application names and groups,
/// numbered from this one on.
pub const MANY: u32 = 8;

/// Validity of an export whose values are valid until they are replaced or retracted. Since minor version 8.
pub const LASTING: u64 = 18_446_744_073_709_551_615;

/// Sample flag: no command is in force; the data is the neutral value.
pub const SAMPLE_NEUTRAL: u32 = 1;
/// Sample flag: this modulation was never written; the data is its default.
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
/// Field kind: a structure with its own [`Type`].
pub const STRUCT: u32 = 11;

/// Field form: one element.
pub const ONE: u32 = 0;
/// Field form: exactly `capacity` elements.
pub const ARRAY: u32 = 1;
/// Field form: up to `capacity` elements, their number a `u32` at `length_offset`. If the first element is
/// eight bytes after that offset, the four bytes between belong to the number and are unused, so that
/// elements of any alignment leave no gap.
pub const SEQUENCE: u32 = 2;
/// Field form: UTF-8 of up to `capacity` bytes, their number a `u32` at `length_offset`.
pub const TEXT: u32 = 3;
/// Field form: `capacity` unused bytes ([`U8`]), where C would leave a gap. Descriptions omit them.
pub const PADDING: u32 = 4;

/// Field flag: its elements are a `byte` in ROS 2. Only the hash of the type (REP-2016) distinguishes it from [`U8`].
pub const BYTE: u32 = 1;
/// Field flag: the capacity is a bound in ROS 2 too. Otherwise a text or a sequence has none there. Only the hash depends
/// on it.
pub const BOUNDED: u32 = 2;

/// Log level: for the developer of this schema; may occur in every iteration.
pub const TRACE: u32 = 0;
/// Log level: for the developer of this schema.
pub const DEBUG: u32 = 1;
/// Log level: for the operator of the application.
pub const INFO: u32 = 2;
/// Log level: a problem after which the schema continues.
pub const WARN: u32 = 3;
/// Log level: a failure.
pub const ERROR: u32 = 4;

/// Selection case: exactly one READY.
pub const ALONE: u32 = 0;
/// Selection case: two or more READY.
pub const COLLISION: u32 = 1;
/// Selection case: none READY.
pub const ABSENCE: u32 = 2;

/// The host's data of an instance; opaque to the plugin, and valid only inside a call of that instance.
#[repr(C)]
pub struct Context {
    _opaque: [u8; 0],
}

/// The table that a plugin exports under the name `jde_plugin`.
///
/// The host reads `magic`, `abi_major` and `abi_minor` before anything else; the offsets of these three
/// fields never change.
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
    /// Version of the plugin, in the author's own numbering.
    pub version: *const c_char,
    /// One sentence about the plugin.
    pub doc: *const c_char,
    /// The schema types. The stride is the `size` of the first.
    pub schemas: *const Schema,
    /// The number of schema types.
    pub schema_count: u32,
    /// 0.
    pub reserved: u32,
}

/// A type of schema: its description, its ports and children, and the functions of its instances.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Schema {
    /// Bytes of this table.
    pub size: u32,
    /// [`PERCEPTIVE`], [`MOTOR`] or [`DRIVER`].
    pub kind: u32,
    /// Name of the type: lower-case letters, digits, `-`, `_`.
    pub name: *const c_char,
    /// What it does. The first line is a complete sentence.
    pub doc: *const c_char,
    /// Default period of its iterations, ns; at least 1.
    pub period_ns: u64,
    /// The longest that an iteration may take, ns; 0 means the period.
    pub budget_ns: u64,
    /// Its ports. Calls identify a port by its index. The stride is the `size` of the first.
    pub ports: *const Port,
    /// The roles of its children. Calls identify a child by its index. The stride is the `size` of the first.
    pub children: *const Child,
    /// The number of ports.
    pub port_count: u32,
    /// The number of children.
    pub child_count: u32,

    /// Creates an instance in the state SLEPT. Called once, before any other function. Returns null on
    /// failure, with the reason passed to [`Host::fail`].
    pub create: Option<unsafe extern "C" fn(*const Schema, *const Host, *mut Context) -> *mut c_void>,
    /// Destroys an instance that is SLEPT. Called once, after every other function. May be null.
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
    /// The instance leaves SLEPT. Called before its first check or iteration. May be null.
    pub awake: Option<unsafe extern "C" fn(*mut c_void, *mut Context) -> i32>,
    /// Evaluates the precondition of a motor schema. Null: always READY.
    pub check: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *mut Precondition) -> i32>,
    /// One iteration, as WINNER. Must return within the budget.
    pub iterate: Option<unsafe extern "C" fn(*mut c_void, *mut Context) -> i32>,
    /// The father's own arbitration (R4). Null if the schema has none.
    pub arbitrate: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Level, *mut Verdict) -> i32>,
    /// The instance enters SLEPT. Called after its last iteration. A driver stops its actuators in this call.
    /// May be null.
    pub sleep: Option<unsafe extern "C" fn(*mut c_void, *mut Context)>,
    /// Returns the table of an optional ability by its id, such as "jde.panel", or null if the type does not
    /// have it. The function may be null.
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
    /// Its name, unique among the ports of this kind (and child). For [`CHILD_MODULATION`], the name of the
    /// child's modulation.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Unit of a plain number ("m", "rad/s"); empty for none, or if the fields of the type have units.
    pub unit: *const c_char,
    /// Type of its value.
    pub value_type: *const Type,
    /// Default of a modulation or neutral value of a command, `value_type->bytes` bytes; otherwise null.
    pub initial: *const c_void,
    /// The least allowed number of a modulation; NaN for none.
    pub min: f64,
    /// The greatest allowed number of a modulation; NaN for none.
    pub max: f64,
    /// How long a command is in force without being repeated, ns, at least 1. Since minor version 8 also how long a
    /// value of an export is valid without a newer one ([`EXPORT`]): 0 for some of the periods that the application states,
    /// or [`LASTING`]. Otherwise 0.
    pub validity_ns: u64,
    /// [`OPTIONAL`], [`TRIGGER`], [`FIXED`].
    pub flags: u32,
    /// The child whose modulation this is. Only for [`CHILD_MODULATION`].
    pub child: u32,
    /// The names of the numbers from 0 on, if the modulation is a choice. `min` is then 0, and `max` is the
    /// last number. Since minor version 4.
    pub choices: *const *const c_char,
    /// The number of choices; 0 for a plain number. Since minor version 4.
    pub choice_count: u32,
    /// 0.
    pub reserved: u32,
    /// The name that a modulation had before, by which application files and options are still read, with a warning; no
    /// other port of the type has it. Null for none. Since minor version 9.
    pub former_name: *const c_char,
}

/// A role that a schema type has for a child. The application binds an instance to it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Child {
    /// Bytes of this table.
    pub size: u32,
    /// [`PERCEPTIVE`] or [`MOTOR`].
    pub kind: u32,
    /// Name of the role.
    pub name: *const c_char,
    /// Name of the group in which a motor child competes. A group has at most one winner.
    pub group: *const c_char,
    /// What the child is for.
    pub doc: *const c_char,
    /// [`OPTIONAL`], [`MANY`].
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

/// A type of value: plain data of fixed size. Every bit pattern is valid, and a field describes every byte.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Type {
    /// Bytes of this table.
    pub size: u32,
    /// The number of fields.
    pub field_count: u32,
    /// Name, in the notation of ROS 2: "sensor_msgs/msg/LaserScan". Types are equal if their names and
    /// layouts are.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Bytes of a value.
    pub bytes: u64,
    /// Alignment of a value, at most 16.
    pub align: u64,
    /// The fields, in the order of their ROS interface. The stride is the `size` of the first.
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
    /// The largest number of elements; 1 for [`ONE`].
    pub capacity: u32,
    /// Name of the field.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// Unit ("m", "rad"); empty for none.
    pub unit: *const c_char,
    /// Bytes from the start of the value to the first element.
    pub offset: u64,
    /// Bytes from the start of the value to the number of elements. Only for [`SEQUENCE`] and [`TEXT`].
    pub length_offset: u64,
    /// Type of the elements. Only for [`STRUCT`].
    pub value_type: *const Type,
    /// [`BYTE`] and [`BOUNDED`], or 0. Since minor version 8.
    pub flags: u32,
    /// 0.
    pub reserved: u32,
}

/// A value of a port. The data does not change until the present call of the instance returns. This table
/// never grows.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Sample {
    /// The value.
    pub data: *const c_void,
    /// Its size.
    pub bytes: u64,
    /// When it was measured or written, ns since the application's start.
    pub time_ns: u64,
    /// The sequence number of the value, from 1.
    pub sequence: u64,
    /// The writer: the number of an instance in this application.
    pub writer: u32,
    /// [`SAMPLE_NEUTRAL`], [`SAMPLE_DEFAULT`].
    pub flags: u32,
}

/// The result of a check.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Precondition {
    /// Bytes of this table.
    pub size: u32,
    /// 1 if the precondition holds, otherwise 0.
    pub ready: u32,
    /// The urgency, for policies that use it: any finite number, 0 by default.
    pub urgency: f64,
}

/// The snapshot of a group for the father's own arbitration.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Level {
    /// Bytes of this table.
    pub size: u32,
    /// [`COLLISION`] or [`ABSENCE`].
    pub case: u32,
    /// Name of the group.
    pub group: *const c_char,
    /// The awake children of the group, in the father's order. The stride is the `size` of the first.
    pub candidates: *const Candidate,
    /// The number of candidates.
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
    /// Its role: its index in [`Schema::children`].
    pub child: u32,
    /// [`CHECKING`], [`READY`] or [`WINNER`].
    pub state: u32,
    /// 1 if its precondition held at its last check.
    pub ready: u32,
    /// The urgency that its last check returned.
    pub urgency: f64,
}

/// The father's choice.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Verdict {
    /// Bytes of this table.
    pub size: u32,
    /// The chosen child, -1 for none.
    pub child: i32,
    /// The reason for the choice; ends with a NUL.
    pub reason: [c_char; 128],
}

/// The status of a child, for its father.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ChildStatus {
    /// Bytes of this table. The caller sets it before the call.
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
        // SAFETY: the tables are immutable after their creation and have no interior mutability. What they
        // point to stays unchanged until the process ends, by the rules at the head of this file.
        unsafe impl Sync for $table {}
        // SAFETY: as above. Nothing in them belongs to a thread.
        unsafe impl Send for $table {}
    )* };
}
shareable!(Plugin, Schema, Port, Child, Type, Field, PortList);
