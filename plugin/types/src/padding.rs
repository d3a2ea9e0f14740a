//! A bool for which every byte pattern is valid, and bytes without meaning.

#![allow(unsafe_code)]

use core::fmt;

use jde_abi::raw;

use crate::part::{FieldLayout, Part};

/// True or false in one byte: 0 is false, anything else true.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Flag(u8);

impl Flag {
    /// False.
    pub const FALSE: Self = Self(0);
    /// True.
    pub const TRUE: Self = Self(1);

    /// Returns a flag with this truth value.
    #[must_use]
    pub const fn new(truth: bool) -> Self {
        Self(truth as u8)
    }

    /// Returns its truth value.
    #[must_use]
    pub const fn get(self) -> bool {
        self.0 != 0
    }
}

impl From<bool> for Flag {
    fn from(truth: bool) -> Self {
        Self::new(truth)
    }
}

impl From<Flag> for bool {
    fn from(flag: Flag) -> Self {
        flag.get()
    }
}

impl PartialEq for Flag {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl Eq for Flag {}

impl fmt::Debug for Flag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

// SAFETY: one byte, for which every pattern is a truth value.
unsafe impl Part for Flag {
    const SHAPE: FieldLayout = FieldLayout::scalar(raw::BOOL);
}

/// Bytes without meaning, in place of a gap of C. No description contains them, and all are equal.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Padding<const N: usize>([u8; N]);

impl<const N: usize> Padding<N> {
    /// Padding of zeros.
    pub const ZERO: Self = Self([0; N]);
}

impl<const N: usize> Default for Padding<N> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const N: usize> PartialEq for Padding<N> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<const N: usize> fmt::Debug for Padding<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("_")
    }
}

// SAFETY: bytes, for which every pattern is valid.
unsafe impl<const N: usize> Part for Padding<N> {
    const SHAPE: FieldLayout = FieldLayout::scalar(raw::U8).repeated(raw::PADDING, N, 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_except_0_is_true() {
        assert!(Flag(0xff).get());
        assert_eq!(Flag(2), Flag::TRUE);
    }
}
