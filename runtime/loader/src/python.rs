//! Plugins in Python: files `NAME.py`, whose schemas run in processes of Python. This process has their tables
//! alone, written from the description that such a process returns: they state which functions exist, and the
//! functions fail.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::path::Path;
use std::ptr::null_mut;

use jde_abi::raw::{self, Context};
use jde_abi::write::{Abilities, Functions};

/// Whether a file, or a plugin's name in an application, is one of Python.
#[must_use]
pub fn is_python(file: impl AsRef<Path>) -> bool {
    file.as_ref()
        .extension()
        .is_some_and(|extension| extension == "py")
}

/// The functions of schemas that run elsewhere.
pub(crate) const FUNCTIONS: Functions = Functions {
    create,
    destroy,
    awake: call,
    check,
    iterate: call,
    arbitrate,
    sleep,
};

/// The abilities of schemas that run elsewhere.
pub(crate) struct Elsewhere;

impl Abilities for Elsewhere {
    const PANEL: raw::Panel = raw::Panel {
        size: size_of::<raw::Panel>() as u32,
        reserved: 0,
        draw: Some(draw),
        touch: Some(touch),
    };
    const STATE: raw::State = raw::State {
        size: size_of::<raw::State>() as u32,
        version: 1,
        save: Some(save),
        restore: Some(restore),
    };
    const INSPECT: raw::Inspect = raw::Inspect {
        size: size_of::<raw::Inspect>() as u32,
        reserved: 0,
        inspect: Some(inspect),
    };
}

unsafe extern "C" fn create(
    _: *const raw::Schema,
    host: *const raw::Host,
    context: *mut Context,
) -> *mut c_void {
    let reason = "a schema in Python runs in a process of its own alone";
    // SAFETY: the host's table and the context of this call.
    unsafe { ((*host).fail)(context, reason.as_ptr().cast(), reason.len() as u64) };
    null_mut()
}

unsafe extern "C" fn destroy(_: *mut c_void) {}

unsafe extern "C" fn call(_: *mut c_void, _: *mut Context) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn check(_: *mut c_void, _: *mut Context, _: *mut raw::Precondition) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn arbitrate(
    _: *mut c_void,
    _: *mut Context,
    _: *const raw::Level,
    _: *mut raw::Verdict,
) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn sleep(_: *mut c_void, _: *mut Context) {}

unsafe extern "C" fn draw(_: *mut c_void, _: *mut Context, _: *const raw::Pen) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn touch(_: *mut c_void, _: *mut Context, _: *const raw::Gesture) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn save(_: *mut c_void, _: *mut Context, _: *const raw::Saver) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn restore(_: *mut c_void, _: *mut Context, _: u32, _: *const c_void, _: u64) -> i32 {
    raw::FAILED
}

unsafe extern "C" fn inspect(_: *mut c_void, _: *mut Context, _: *const raw::Problems) -> i32 {
    raw::FAILED
}
