//! The tables of the ability [`ABILITY_INSPECT`]: a schema inspects what its modulations name before the
//! application starts: whether a file is valid, a device is present, a name is known.

use core::ffi::{c_char, c_void};

use super::Context;

/// The id of the ability, whose table is an [`Inspect`]. It and all that belongs to it exist since minor
/// version 5.
pub const ABILITY_INSPECT: &str = "jde.inspect";

/// Problem: the schema would fail when it awakes, until a user changes something.
pub const PROBLEM_WRONG: u32 = 0;
/// Problem: something is missing or may not be used at present. The schema would start and wait for it.
pub const PROBLEM_UNAVAILABLE: u32 = 1;

/// The largest number of problems of one inspection.
pub const PROBLEMS_MOST: u32 = 64;

/// The table that [`super::Schema::ability`] returns for [`ABILITY_INSPECT`].
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Inspect {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Inspects what the modulations name, and adds a problem for each that cannot work. It only reads: it
    /// opens no device, writes no file and uses no network. The host enforces that where the system permits.
    ///
    /// Called between `create` and `destroy` of an instance that never awakes, in a separate process, which
    /// is ended if the function does not return within a few seconds. [`super::Host::read`] returns the
    /// modulations as the application sets them. No other port has a value; an import without a source is
    /// [`super::UNBOUND`]. Any call that writes, wakes or puts to sleep is [`super::REFUSED`].
    pub inspect: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Problems) -> i32>,
}

/// The list of problems; opaque to the plugin.
#[repr(C)]
pub struct Found {
    _opaque: [u8; 0],
}

/// The functions with which a plugin reports problems. Valid only until its [`Inspect::inspect`] returns, and
/// on its thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Problems {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the function below.
    pub found: *mut Found,
    /// Adds a problem of the modulation `port`: what is wrong and what to do, as `length` bytes of UTF-8,
    /// which are copied. `kind` is [`PROBLEM_WRONG`] or [`PROBLEM_UNAVAILABLE`]. An export that is unavailable never
    /// has a value, and `jde check` warns of what imports it. [`super::BAD_ARGUMENT`] for
    /// another kind, a null text, and beyond [`PROBLEMS_MOST`].
    pub add: unsafe extern "C" fn(*mut Found, kind: u32, port: u32, text: *const c_char, length: u64) -> i32,
}
