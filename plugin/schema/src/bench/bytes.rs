//! The bytes of a value with the largest alignment that a value may need.

#![allow(unsafe_code)]

use core::slice;

use jde_abi::describe::Type;
use jde_types::Value;

/// The bytes of one value, aligned to 16.
#[derive(Clone, Debug)]
pub(super) struct Bytes {
    words: Vec<u128>,
    length: usize,
}

impl Bytes {
    pub(super) fn zeros(length: usize) -> Self {
        Self {
            words: vec![0; length.div_ceil(16)],
            length,
        }
    }

    pub(super) fn copy(ty: &Type, value: &[u8]) -> Self {
        let mut this = Self::zeros(ty.bytes);
        // SAFETY: the words hold at least as many bytes.
        let room = unsafe { slice::from_raw_parts_mut(this.as_mut_ptr(), this.length) };
        ty.copy_into(value, room);
        this
    }

    /// Returns the value. The caller has compared the type.
    pub(super) fn as_value<T: Value>(&self) -> &T {
        assert_eq!(self.length, size_of::<T>(), "the caller compares types first");
        const {
            assert!(
                align_of::<T>() <= align_of::<u128>(),
                "a value is aligned to 16 at most"
            )
        };
        // SAFETY: as many bytes, initialised and aligned, of which every pattern is a valid value. They are
        // borrowed as long as the reference lives.
        unsafe { &*self.words.as_ptr().cast::<T>() }
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        // SAFETY: the words hold at least `length` bytes.
        unsafe { slice::from_raw_parts(self.words.as_ptr().cast(), self.length) }
    }

    pub(super) fn as_ptr(&self) -> *const u8 {
        self.words.as_ptr().cast()
    }

    pub(super) fn as_mut_ptr(&mut self) -> *mut u8 {
        self.words.as_mut_ptr().cast()
    }
}
