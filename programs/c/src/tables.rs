//! Programs that run applications: libjde.so. docs/embedding.md explains it, and examples/embed shows it.
//!
//! Rules of this file:
//! - A function returns a status: `JDE_OK`, or another number of this file or of `jde.h`; then jde_error() states in words
//!   what was wrong, with the file and the line if there is one.
//! - Every function may be called from any thread, several at once, and in any order. Nothing of the program runs on a
//!   thread of the robot, and no thread of a robot waits for the program. A function that blocks says so.
//! - A handle is a number, not an address. A call with one that was closed returns [`NO_HANDLE`].
//! - Texts are UTF-8 and end with a NUL. A text that the library returns is freed by jde_free_text().
//! - Pointers to what a function fills in are not null, unless it says so, and are not kept. A `jde_type` that a program
//!   passes stays unchanged until the process ends, as those of `jde_types.h` do.
//! - Times are in seconds since the application's start.
//! - Options grow only at the end, and state their own size; what a program does not know is zero, and what the library does
//!   not know must be. Functions are only added: a program runs with every newer library of the same name.
//! - The library installs no handler of signals, prints nothing, and never ends the process.

use core::ffi::c_char;

/// Increases when functions or options are added.
pub const LIBRARY_MINOR: u32 = 1;

/// Status: the application has ended, and time passes no more.
pub const ENDED: i32 = 32;
/// Status: the time was reached before the condition was true, or nothing is due any more.
pub const NOT_REACHED: i32 = 33;
/// Status: the handle was closed, or is none.
pub const NO_HANDLE: i32 = 34;

/// Start flag: time passes only in jde_run_step() and in the functions jde_run_until..., and a seed gives one run. Without
/// it, the application runs in real time on threads of its own.
pub const LOCKSTEP: u32 = 1;
/// Start flag: [`StartOptions::seed`] takes the place of the seed of the file.
pub const WITH_SEED: u32 = 2;
/// Start flag: records and conditions are not available, and time passes faster in lockstep.
pub const WITHOUT_RECORDS: u32 = 4;

/// Record: a selection, with its reason.
pub const RECORD_DECISION: u32 = 1;
/// Record: a schema changed its state.
pub const RECORD_STATE: u32 = 2;
/// Record: any other event.
pub const RECORD_EVENT: u32 = 3;

/// An application that was loaded and checked; a handle.
#[repr(C)]
pub struct Application {
    _opaque: [u8; 0],
}

/// A started application; a handle.
#[repr(C)]
pub struct Run {
    _opaque: [u8; 0],
}

/// How to load an application. Without it, the file alone counts.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct LoadOptions {
    /// Bytes of this structure.
    pub size: u32,
    /// The number of `values`.
    pub value_count: u32,
    /// Values in place of those of the file, as `jde run --set` takes them: "goon.fast=30 cm/s". A path in one starts in
    /// the working directory.
    pub values: *const *const c_char,
    /// Schemas that are not called: the program writes what they export and command.
    pub mocks: *const *const c_char,
    /// The number of `mocks`.
    pub mock_count: u32,
    /// Zero.
    pub reserved: u32,
    /// The executable `jde`, which inspects plugins and runs isolated schemas, or null: then `bin/jde` of the library's
    /// prefix, the one beside the library, or that of the `PATH`, whichever is found first.
    pub executable: *const c_char,
}

/// How to start an application. Without it, it starts in real time.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct StartOptions {
    /// Bytes of this structure.
    pub size: u32,
    /// [`LOCKSTEP`], [`WITH_SEED`], [`WITHOUT_RECORDS`].
    pub flags: u32,
    /// The seed of all random generators.
    pub seed: u64,
    /// The time at which the application ends, s; 0 for none.
    pub limit: f64,
    /// Seconds of the application per second of the machine, in real time; 0 for 1.
    pub speed: f64,
    /// The name under which the program acts as an operator, in records; null for "program".
    pub name: *const c_char,
}
