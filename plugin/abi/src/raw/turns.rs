//! The extension [`EXTENSION_TURNS`] of the host: an instance requests turns in addition to the periodic ones.

use core::ffi::c_void;

use super::Context;

/// The id of the extension, whose table is a [`Turns`]. [`super::Host::extension`] returns null in lockstep, at another
/// speed than real time, in a replay, in a process of its own, and in a host that does not know it.
pub const EXTENSION_TURNS: &str = "jde.turns";

/// The table that [`super::Host::extension`] returns for [`EXTENSION_TURNS`]. It lives until the process ends.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Turns {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Returns a handle of the instance whose call has this context. Give it to `close` once.
    pub open: unsafe extern "C" fn(*mut Context) -> *mut c_void,
    /// Requests a turn of the instance in addition to the periodic ones (R12), if the instance is awake. Requests before
    /// that turn begins are one. Does not block. Any thread may call it, also after the instance or the application
    /// has ended.
    pub request: unsafe extern "C" fn(*const c_void),
    /// Frees a handle.
    pub close: unsafe extern "C" fn(*mut c_void),
}
