//! Lists and gestures on their way through the C ABI, for the callers of a plugin: a pen that builds a list,
//! and gestures as tables. All input of a plugin is checked before it is used, and then copied.

#![allow(unsafe_code)]

mod codes;
mod gesture;
mod pen;
mod shapes;
mod widgets;

pub use gesture::{lend_gesture, read_gesture};
pub use pen::lend_pen;

use core::ffi::{CStr, c_char};

use jde_abi::table::Table;

use crate::Broken;
use crate::limits::wrong;

/// Returns a text; null is an empty one.
///
/// # Safety
/// `text` is null or ends with a NUL.
unsafe fn text(widget: &str, text: *const c_char) -> Result<String, Broken> {
    if text.is_null() {
        return Ok(String::new());
    }
    // SAFETY: the caller's contract.
    match unsafe { CStr::from_ptr(text) }.to_str() {
        Ok(text) => Ok(text.to_owned()),
        Err(_) => wrong(widget, "a text is not UTF-8"),
    }
}

/// Returns an array of the plugin; an empty one if it has no elements.
///
/// # Safety
/// `first` is null, not aligned, or points to `count` elements.
unsafe fn array<'a, T>(widget: &str, first: *const T, count: usize) -> Result<&'a [T], Broken> {
    if count == 0 {
        return Ok(&[]);
    }
    if first.is_null() || !first.is_aligned() {
        return wrong(
            widget,
            format!("a pointer to {count} elements is null or not aligned"),
        );
    }
    // SAFETY: the caller's contract.
    Ok(unsafe { core::slice::from_raw_parts(first, count) })
}

/// Returns a table of the plugin in the form of this version of the ABI.
///
/// # Safety
/// `table` is null, not aligned, or begins with its correct size.
unsafe fn table<T: Table>(widget: &str, table: *const T) -> Result<T, Broken> {
    // SAFETY: the caller's contract.
    unsafe { jde_abi::table::read(table) }.or_else(|unreadable| wrong(widget, unreadable.to_string()))
}
