//! The tables of the ability [`ABILITY_INSPECT`]: a schema that looks at what its modulations name before anything starts: whether
//! a file is what it should be, a device is there, a name is known.

use core::ffi::{c_char, c_void};

use super::Context;

/// The id of the ability, whose table is an [`Inspect`]. Since minor version 5, as all that belongs to it.
pub const ABILITY_INSPECT: &str = "jde.inspect";

/// Problem: the schema would fail when it awakes, until a person changes something.
pub const PROBLEM_WRONG: u32 = 0;
/// Problem: something is not there or may not be used at present; the schema would start and wait for it.
pub const PROBLEM_UNAVAILABLE: u32 = 1;

/// Most problems of one inspection; the host takes no more.
pub const PROBLEMS_MOST: u32 = 64;

/// What [`super::Schema::ability`] gives for [`ABILITY_INSPECT`].
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Inspect {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Looks at what the modulations name, and adds a problem for each that cannot work. It reads and changes nothing: no device is
    /// opened, no file is written, nobody is called over a network; the host sees to that where the system lets it.
    ///
    /// Called between `create` and `destroy` of an instance that never awakes, in a process of its own, which is ended if the
    /// function does not return within a few seconds. [`super::Host::read`] gives the modulations as the application sets them; any
    /// other port has no value, and whatever writes, wakes or puts to sleep is [`super::REFUSED`].
    pub inspect: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Problems) -> i32>,
}

/// The list that problems are added to; opaque to the plugin.
#[repr(C)]
pub struct Found {
    _opaque: [u8; 0],
}

/// What a plugin reports with, only until its [`Inspect::inspect`] returns and on its thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Problems {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the function below.
    pub found: *mut Found,
    /// Adds a problem of the modulation `port`: what is wrong and what to do, as `length` bytes of UTF-8, which are copied.
    /// [`PROBLEM_WRONG`] or [`PROBLEM_UNAVAILABLE`]. [`super::BAD_ARGUMENT`] for another kind, a null text, and beyond
    /// [`PROBLEMS_MOST`].
    pub add: unsafe extern "C" fn(*mut Found, kind: u32, port: u32, text: *const c_char, length: u64) -> i32,
}
