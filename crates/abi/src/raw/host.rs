//! The table of the host's functions.

use core::ffi::{c_char, c_void};

use super::{ChildStatus, Context, Sample};

/// What the host offers to an instance. Every function is called with the [`Context`] of the present call, on its thread,
/// and only until that call returns. None blocks.
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
    /// The value of an import, modulation or command. The same value throughout a check and the iteration that follows it (R8).
    /// [`super::NO_VALUE`], [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub read: unsafe extern "C" fn(*mut Context, port: u32, *mut Sample) -> i32,
    /// Room to write the next value of an export, actuator or child's modulation, aligned for its type; its bytes hold
    /// anything. Nobody sees it before `publish`; a loan that is not published by the end of the call is dropped.
    /// [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub loan: unsafe extern "C" fn(*mut Context, port: u32, *mut *mut c_void) -> i32,
    /// Publishes what was loaned, measured at `time_ns` (0: now). [`super::REFUSED`] and [`super::NOT_FINITE`] for
    /// commands and a child's modulations, [`super::OUT_OF_RANGE`] for the latter, [`super::BAD_ARGUMENT`].
    pub publish: unsafe extern "C" fn(*mut Context, port: u32, time_ns: u64) -> i32,
    /// Wakes a child (R7). Waking one that is awake changes nothing. [`super::REFUSED`], [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub wake: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// Puts a child and its subtree to sleep. [`super::REFUSED`], [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub sleep: unsafe extern "C" fn(*mut Context, child: u32) -> i32,
    /// What a child is doing. [`super::UNBOUND`], [`super::BAD_ARGUMENT`].
    pub child: unsafe extern "C" fn(*mut Context, child: u32, *mut ChildStatus) -> i32,
    /// Changes the policy of a group of children, named by one of them: a number `JDE_POLICY_...`,
    /// its time and its number.
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
    /// who read it are answered [`super::NO_VALUE`], and who is triggered by it looks again (R12). [`super::BAD_ARGUMENT`]. Since minor version 1.
    pub retract: Option<unsafe extern "C" fn(*mut Context, port: u32) -> i32>,
    /// 1 if the application's time passes as fast as everybody's; 0 in lockstep and at another speed, which no device follows.
    /// Since minor version 1.
    pub real_time: Option<unsafe extern "C" fn(*mut Context) -> u32>,
}
