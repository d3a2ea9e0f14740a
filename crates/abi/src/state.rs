//! Both ends of the ability to save what a schema remembers, as hosts use them: its table, and a saver to lend to it. Calls no
//! schema.

#![allow(unsafe_code)]

use core::ffi::c_void;
use core::ptr;

use crate::{raw, table};

/// Why bytes were not kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany {
    /// How many there were at least.
    pub bytes: u64,
}

impl core::fmt::Display for TooMany {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "it saves {} bytes or more, and at most {} are kept",
            self.bytes,
            raw::STATE_MOST
        )
    }
}

impl core::error::Error for TooMany {}

/// How a type of schema saves and restores what it remembers.
///
/// # Errors
/// What is wrong with its table, in words.
///
/// # Safety
/// `schema` was read by [`crate::read::plugin`] and found right, and its functions follow the rules of [`raw`].
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

/// Lends a saver for one call; answers with what the call did, and with what was saved by it.
pub fn lend<R>(save: impl FnOnce(*const raw::Saver) -> R) -> (R, Result<Vec<u8>, TooMany>) {
    let mut kept: Result<Vec<u8>, TooMany> = Ok(Vec::new());
    let saver = raw::Saver {
        size: size_of::<raw::Saver>() as u32,
        reserved: 0,
        saving: ptr::from_mut(&mut kept).cast(),
        write,
    };
    let result = save(&raw const saver);
    (result, kept)
}

unsafe extern "C" fn write(saving: *mut raw::Saving, bytes: *const c_void, length: u64) -> i32 {
    // SAFETY: what `lend` put there, which nothing else uses until the call for which it was lent has returned.
    let kept = unsafe { &mut *saving.cast::<Result<Vec<u8>, TooMany>>() };
    let Ok(before) = kept else {
        return raw::BAD_ARGUMENT;
    };
    let bytes_then = (before.len() as u64).saturating_add(length);
    if bytes_then > raw::STATE_MOST {
        *kept = Err(TooMany { bytes: bytes_then });
        return raw::BAD_ARGUMENT;
    }
    if length == 0 {
        return raw::OK;
    }
    if bytes.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the plugin vouches for the length.
    before.extend_from_slice(unsafe { core::slice::from_raw_parts(bytes.cast::<u8>(), length as usize) });
    raw::OK
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved(parts: &[&[u8]]) -> (Vec<i32>, Result<Vec<u8>, TooMany>) {
        lend(|saver| {
            let write = |part: &&[u8]| {
                // SAFETY: the saver that was lent, and bytes of that length.
                unsafe { ((*saver).write)((*saver).saving, part.as_ptr().cast(), part.len() as u64) }
            };
            parts.iter().map(write).collect()
        })
    }

    #[test]
    fn what_is_saved_in_parts_is_kept_in_their_order() {
        let (codes, kept) = saved(&[b"one", b"", b"two"]);
        assert_eq!(codes, [raw::OK; 3]);
        assert_eq!(kept.as_deref(), Ok(&b"onetwo"[..]));
        assert_eq!(saved(&[]).1.as_deref(), Ok(&[][..]));
    }

    #[test]
    fn beyond_the_limit_nothing_is_kept() {
        let most = vec![7; raw::STATE_MOST as usize];
        assert_eq!(
            saved(&[&most]).1.map(|kept| kept.len() as u64),
            Ok(raw::STATE_MOST)
        );
        let (codes, kept) = saved(&[&most, b"x", b"y"]);
        assert_eq!(codes, [raw::OK, raw::BAD_ARGUMENT, raw::BAD_ARGUMENT]);
        let too_many = kept.expect_err("too many");
        assert_eq!(too_many.bytes, raw::STATE_MOST + 1);
        assert!(too_many.to_string().contains("16777216"));
    }

    #[test]
    fn a_null_pointer_to_bytes_is_refused_and_what_was_saved_stays() {
        let (code, kept) = lend(|saver| {
            // SAFETY: the saver that was lent; null is looked at.
            unsafe {
                ((*saver).write)((*saver).saving, c"a".as_ptr().cast(), 1);
                ((*saver).write)((*saver).saving, ptr::null(), 4)
            }
        });
        assert_eq!((code, kept.as_deref()), (raw::BAD_ARGUMENT, Ok(&b"a"[..])));
    }
}
