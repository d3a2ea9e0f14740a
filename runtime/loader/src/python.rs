//! Plugins in Python: files `NAME.py`, whose schemas run in processes of Python. This process has their tables
//! alone, written from the description that such a process returns: they state which functions exist, and the
//! functions fail.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::path::Path;
use std::ptr::null_mut;

use jde_abi::raw;
use jde_abi::write::Functions;

/// Whether a file, or a plugin's name in an application, is one of Python.
#[must_use]
pub fn is_python(file: impl AsRef<Path>) -> bool {
    file.as_ref()
        .extension()
        .is_some_and(|extension| extension == "py")
}

/// The functions of schemas that run elsewhere.
pub(crate) struct Elsewhere;

impl Functions for Elsewhere {
    unsafe extern "C" fn create(
        _: *const raw::Schema,
        host: *const raw::Host,
        context: *mut raw::Context,
    ) -> *mut c_void {
        let reason = "a schema in Python runs in a process of its own alone";
        // SAFETY: the host's table and the context of this call.
        unsafe { ((*host).fail)(context, reason.as_ptr().cast(), reason.len() as u64) };
        null_mut()
    }
}
