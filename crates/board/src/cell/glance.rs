//! Telling by one word that a value is the newest still, for who asks far more often than there is anything new.

#![allow(
    unsafe_code,
    reason = "the word's address is kept beside the value, so that a look follows no other pointer"
)]

use std::ptr::NonNull;

use crate::sync::{AtomicU64, Ordering};

/// What a cell's first word says while a value is its newest.
#[derive(Clone, Copy)]
pub struct Glance {
    word: NonNull<AtomicU64>,
    mask: u64,
    expected: u64,
}

// SAFETY: it is a shared reference to an atomic, for whose life the caller of `unchanged` vouches.
unsafe impl Send for Glance {}
// SAFETY: as above.
unsafe impl Sync for Glance {}

impl Glance {
    /// The value is the newest while the bits of `mask` are `expected`.
    pub(super) fn new(word: &AtomicU64, mask: u64, expected: u64) -> Self {
        Self {
            word: NonNull::from(word),
            mask,
            expected,
        }
    }

    /// One that never tells, so that the value has to be fetched at each look.
    pub(super) fn blind(word: &AtomicU64) -> Self {
        Self::new(word, 0, 1)
    }

    /// Whether the value is the newest still.
    ///
    /// # Safety
    /// The cell lives; it may have been moved. A value that was pinned is pinned.
    #[inline(always)]
    pub unsafe fn unchanged(self) -> bool {
        // SAFETY: the cell lives, says the caller, and its words stay where they are.
        let word = unsafe { self.word.as_ref() };
        word.load(Ordering::Acquire) & self.mask == self.expected
    }
}
