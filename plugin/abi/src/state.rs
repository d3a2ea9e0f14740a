//! The host's side of the ability to save a schema's memory: its table, and the saver that collects the
//! bytes. Calls no schema.

#![allow(unsafe_code)]

use core::ffi::c_void;
use core::ptr;

use crate::{raw, table};

/// More bytes than a schema may save.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany {
    /// The number of bytes, at least.
    pub bytes: u64,
}

impl core::fmt::Display for TooMany {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "it saves {} bytes or more, and at most {} are saved",
            self.bytes,
            raw::STATE_MOST
        )
    }
}

impl core::error::Error for TooMany {}

/// Returns the table of a schema type's memory, if it has one.
///
/// # Errors
/// A message that states what is wrong with its table.
///
/// # Safety
/// [`crate::read::plugin`] has accepted `schema`, and its functions follow the rules of [`raw`].
pub unsafe fn of(schema: &raw::Schema) -> Result<Option<raw::State>, String> {
    // SAFETY: the caller's.
    let state = unsafe { table::ability::<raw::State>(schema, raw::ABILITY_STATE) };
    match state.map_err(|unreadable| unreadable.to_string())? {
        Some(state) if state.save.is_none() || state.restore.is_none() => {
            Err(String::from("its `save` or its `restore` is null"))
        }
        state => Ok(state),
    }
}

/// Lends a saver to one call. Returns the result of the call, and the bytes that it saved.
pub fn lend<R>(save: impl FnOnce(*const raw::Saver) -> R) -> (R, Result<Vec<u8>, TooMany>) {
    let mut saved: Result<Vec<u8>, TooMany> = Ok(Vec::new());
    let saver = raw::Saver {
        size: size_of::<raw::Saver>() as u32,
        reserved: 0,
        saving: ptr::from_mut(&mut saved).cast(),
        write,
    };
    let result = save(&raw const saver);
    (result, saved)
}

unsafe extern "C" fn write(saving: *mut raw::Saving, bytes: *const c_void, length: u64) -> i32 {
    // SAFETY: the buffer of `lend`, which nothing else uses until the call to which it was lent has returned.
    let saved = unsafe { &mut *saving.cast::<Result<Vec<u8>, TooMany>>() };
    let Ok(buffer) = saved else {
        return raw::BAD_ARGUMENT;
    };
    let total = (buffer.len() as u64).saturating_add(length);
    if total > raw::STATE_MOST {
        *saved = Err(TooMany { bytes: total });
        return raw::BAD_ARGUMENT;
    }
    if length == 0 {
        return raw::OK;
    }
    if bytes.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the plugin guarantees the length.
    buffer.extend_from_slice(unsafe { core::slice::from_raw_parts(bytes.cast::<u8>(), length as usize) });
    raw::OK
}

#[cfg(test)]
mod tests {
    use super::*;

    fn save_parts(parts: &[&[u8]]) -> (Vec<i32>, Result<Vec<u8>, TooMany>) {
        lend(|saver| {
            let write = |part: &&[u8]| {
                // SAFETY: the saver that was lent, and bytes of that length.
                unsafe { ((*saver).write)((*saver).saving, part.as_ptr().cast(), part.len() as u64) }
            };
            parts.iter().map(write).collect()
        })
    }

    #[test]
    fn parts_are_saved_in_their_order() {
        let (codes, saved) = save_parts(&[b"one", b"", b"two"]);
        assert_eq!(codes, [raw::OK; 3]);
        assert_eq!(saved.as_deref(), Ok(&b"onetwo"[..]));
        assert_eq!(save_parts(&[]).1.as_deref(), Ok(&[][..]));
    }

    #[test]
    fn nothing_is_kept_beyond_the_limit() {
        let most = vec![7; raw::STATE_MOST as usize];
        assert_eq!(
            save_parts(&[&most]).1.map(|saved| saved.len() as u64),
            Ok(raw::STATE_MOST)
        );
        let (codes, saved) = save_parts(&[&most, b"x", b"y"]);
        assert_eq!(codes, [raw::OK, raw::BAD_ARGUMENT, raw::BAD_ARGUMENT]);
        let too_many = saved.expect_err("too many");
        assert_eq!(too_many.bytes, raw::STATE_MOST + 1);
        assert!(too_many.to_string().contains("16777216"));
    }

    #[test]
    fn a_null_pointer_is_refused_and_earlier_bytes_are_kept() {
        let (code, saved) = lend(|saver| {
            // SAFETY: the saver that was lent; null is checked.
            unsafe {
                ((*saver).write)((*saver).saving, c"a".as_ptr().cast(), 1);
                ((*saver).write)((*saver).saving, ptr::null(), 4)
            }
        });
        assert_eq!((code, saved.as_deref()), (raw::BAD_ARGUMENT, Ok(&b"a"[..])));
    }
}
