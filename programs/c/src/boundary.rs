//! The boundary: statuses, the text of the last error, texts both ways, and panics.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::Once;

use jde_abi::raw;
use jde_embed::Error;

use crate::tables;

thread_local! {
    /// The text of the last call of this thread that did not return `JDE_OK`.
    static ERROR: RefCell<CString> = RefCell::default();
    /// The place and the message of the last panic of this thread.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Why a function does not return `JDE_OK`.
pub(crate) struct Failure {
    status: i32,
    text: String,
}

impl Failure {
    pub(crate) fn new(status: i32, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { status, text }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match error {
            Error::Unknown(_) | Error::Invalid(_) => raw::BAD_ARGUMENT,
            Error::Refused(_) => raw::REFUSED,
            Error::Failed(_) => raw::FAILED,
        };
        Self::new(status, error.to_string())
    }
}

/// Carries out a call of the program. Returns its status, and keeps the text of a failure.
pub(crate) fn call(body: impl FnOnce() -> Result<(), Failure>) -> i32 {
    static QUIET: Once = Once::new();
    // The hook of this library's own standard library, which by default prints.
    QUIET.call_once(|| std::panic::set_hook(Box::new(note_panic)));
    let failure = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return raw::OK,
        Ok(Err(failure)) => failure,
        Err(_) => {
            let panic = PANIC.try_with(|kept| kept.borrow().clone()).unwrap_or_default();
            Failure::new(raw::PANICKED, format!("a defect of libjde: {panic}"))
        }
    };
    // A thread that ends keeps no text any more.
    let _ = ERROR.try_with(|kept| kept.replace(c_text(failure.text)));
    failure.status
}

fn note_panic(panic: &PanicHookInfo<'_>) {
    let message = panic.payload_as_str().unwrap_or("a panic");
    let place = panic
        .location()
        .map(|place| format!(" at {place}"))
        .unwrap_or_default();
    let _ = PANIC.try_with(|kept| kept.replace(format!("{message}{place}")));
}

/// Returns what was wrong with the last call of this thread that did not return `JDE_OK`. The text is valid until
/// this thread makes another call. In a destructor of a thread that ends, it is empty.
#[unsafe(no_mangle)]
pub extern "C" fn jde_error() -> *const c_char {
    let text = ERROR.try_with(|text| text.borrow().as_ptr());
    text.unwrap_or(c"".as_ptr())
}

/// Frees a text that the library returned. Null is nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_free_text(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: the library returned it, from `give_text`.
        drop(unsafe { CString::from_raw(text) });
    }
}

/// Returns the version of the library: the number in its name times 65536, plus `JDE_LIBRARY_MINOR` of its header. A
/// function or an option of a later header than the library's does not exist.
#[unsafe(no_mangle)]
pub extern "C" fn jde_library_version() -> u32 {
    tables::LIBRARY_MINOR
}

/// Reads a text of the program.
pub(crate) unsafe fn text<'t>(what: &str, text: *const c_char) -> Result<&'t str, Failure> {
    // SAFETY: the caller's.
    let text = unsafe { optional_text(what, text) }?;
    text.ok_or_else(|| Failure::new(raw::BAD_ARGUMENT, format!("`{what}` is null")))
}

/// Reads a text of the program that may be null.
pub(crate) unsafe fn optional_text<'t>(what: &str, text: *const c_char) -> Result<Option<&'t str>, Failure> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: texts of the program end with a NUL, and stay unchanged during the call.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map(Some)
        .map_err(|error| Failure::new(raw::BAD_ARGUMENT, format!("`{what}` is not UTF-8: {error}")))
}

/// Refuses a place of the program that is none.
pub(crate) fn check_place<T>(what: &str, place: *mut T) -> Result<(), Failure> {
    if place.is_null() {
        return Err(Failure::new(raw::BAD_ARGUMENT, format!("`{what}` is null")));
    }
    Ok(())
}

/// Writes a result of the program's.
pub(crate) unsafe fn give<T>(what: &str, place: *mut T, value: T) -> Result<(), Failure> {
    check_place(what, place)?;
    // SAFETY: a place of the program for this type.
    unsafe { place.write(value) };
    Ok(())
}

/// Writes a text that the program then owns.
pub(crate) unsafe fn give_text(place: *mut *mut c_char, text: impl Into<String>) -> Result<(), Failure> {
    let text = c_text(text.into()).into_raw();
    // SAFETY: as above.
    unsafe { give("text", place, text) }.inspect_err(|_| {
        // SAFETY: it is from `into_raw`.
        drop(unsafe { CString::from_raw(text) });
    })
}

fn c_text(text: String) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}
