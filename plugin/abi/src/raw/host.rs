//! The table of the host's functions.

use core::ffi::{c_char, c_void};

use super::{ChildStatus, Context, Sample};

/// The functions that the host offers to an instance. Call each with the [`Context`] of the present call, on
/// its thread, and only until that call returns. None blocks.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Host {
    /// Bytes of this table.
    pub size: u32,
    /// [`super::ABI_MAJOR`] of the host.
    pub abi_major: u32,
    /// [`super::ABI_MINOR`] of the host.
    pub abi_minor: u32,
    /// 0.
    pub reserved: u32,
    /// Reads an import, modulation or command. The value is the same throughout a check and the iteration
    /// that follows it (R8). [`super::NO_VALUE`], [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub read: unsafe extern "C" fn(*mut Context, port: u32, *mut Sample) -> i32,
    /// Returns a buffer for the next value of an export, actuator or child's modulation, aligned for its
    /// type. Its bytes are arbitrary. The value is not visible before `publish`. A loan that is not published
    /// by the end of the call is dropped. [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub loan: unsafe extern "C" fn(*mut Context, port: u32, *mut *mut c_void) -> i32,
    /// Publishes the loaned value as measured at `time_ns` (0: now). [`super::REFUSED`] and
    /// [`super::NOT_FINITE`] for commands and a child's modulations, [`super::OUT_OF_RANGE`] for the latter,
    /// [`super::BAD_ARGUMENT`].
    pub publish: unsafe extern "C" fn(*mut Context, port: u32, time_ns: u64) -> i32,
    /// Wakes a child (R7). Has no effect on a child that is awake. [`super::REFUSED`], [`super::UNBOUND`],
    /// [`super::BAD_ARGUMENT`].
    pub wake: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// Puts a child and its subtree to sleep. [`super::REFUSED`], [`super::UNBOUND`],
    /// [`super::BAD_ARGUMENT`].
    pub sleep: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// Returns the status of a child. [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub child: unsafe extern "C" fn(*mut Context, child: u32, *mut ChildStatus) -> i32,
    /// Changes the policy of the group in which a child competes: a number `JDE_POLICY_...`, its time and its
    /// number.
    pub set_policy:
        unsafe extern "C" fn(*mut Context, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> i32,
    /// Returns the time since the application's start, ns. In lockstep it is constant during a call.
    pub now: unsafe extern "C" fn(*mut Context) -> u64,
    /// Returns a seed that depends only on the application's seed and the instance's name.
    pub seed: unsafe extern "C" fn(*mut Context) -> u64,
    /// Returns a number that identifies the running application within this process. All its instances share
    /// it.
    pub application: unsafe extern "C" fn(*mut Context) -> u64,
    /// Returns the instance's name in the application. The text lives as long as the instance.
    pub name: unsafe extern "C" fn(*mut Context) -> *const c_char,
    /// Writes a log message. `text` is `length` bytes of UTF-8.
    pub log: unsafe extern "C" fn(*mut Context, level: u32, text: *const c_char, length: u64),
    /// States the reason for the error that this call is about to return. `text` is `length` bytes of UTF-8.
    pub fail: unsafe extern "C" fn(*mut Context, text: *const c_char, length: u64),
    /// Returns an extension of the host by its id; null if the host does not have it.
    pub extension: unsafe extern "C" fn(*mut Context, id: *const c_char) -> *const c_void,
    /// Retracts the newest value of an export because it is no longer valid. Until the next value is
    /// published, readers get [`super::NO_VALUE`]. Schemas with a trigger on it check again (R12).
    /// [`super::BAD_ARGUMENT`]. Since minor version 1.
    pub retract: Option<unsafe extern "C" fn(*mut Context, port: u32) -> i32>,
    /// Returns 1 if the application runs in real time; 0 in lockstep and at another speed, which no device
    /// can follow. Since minor version 1.
    pub real_time: Option<unsafe extern "C" fn(*mut Context) -> u32>,
}
