//! Recognises by one word that a value is still the newest, for readers that poll far more often than values
//! arrive.

#![allow(
    unsafe_code,
    reason = "the word's address is kept beside the value, so that a check follows no other pointer"
)]

use std::ptr::NonNull;

use crate::sync::{AtomicU64, Ordering};

/// The word of a cell, and the bits that it has while a value is the newest.
#[derive(Clone, Copy)]
pub struct VersionCheck {
    word: NonNull<AtomicU64>,
    mask: u64,
    expected: u64,
}

// SAFETY: it is a shared reference to an atomic, whose lifetime the caller of `is_unchanged` guarantees.
unsafe impl Send for VersionCheck {}
// SAFETY: as above.
unsafe impl Sync for VersionCheck {}

impl VersionCheck {
    /// Returns a check of a value that is the newest while the bits of `mask` are `expected`.
    pub(super) fn new(word: &AtomicU64, mask: u64, expected: u64) -> Self {
        Self {
            word: NonNull::from(word),
            mask,
            expected,
        }
    }

    /// Returns a check that never recognises a value, so the value is fetched at each latch.
    pub(super) fn never_matching(word: &AtomicU64) -> Self {
        Self::new(word, 0, 1)
    }

    /// Returns whether the value is still the newest.
    ///
    /// # Safety
    /// The cell is alive; it may have moved. If the value was pinned, it still is.
    #[inline(always)]
    pub unsafe fn is_unchanged(self) -> bool {
        // SAFETY: the caller guarantees that the cell is alive, and its words do not move.
        let word = unsafe { self.word.as_ref() };
        word.load(Ordering::Acquire) & self.mask == self.expected
    }
}
