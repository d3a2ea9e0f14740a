//! What a modulation may be: a value, a bool, or one of several. The last two are no values, for some patterns of their bytes mean
//! nothing; they cross the boundary as values that do.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::mem;

use crate::{Flag, Value};

/// What a modulation may be: every [`Value`], `bool`, and an enumeration with `#[derive(Choice)]`.
///
/// # Safety
/// It has as many bytes as its `Wire`, and the bytes of each of its values are those of the `Wire` that stands for it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a modulation",
    note = "use a number, `bool`, `Text<N>`, a structure that derives `Value`, or an enumeration with `#[derive(Clone, Copy, Choice)]` and `#[repr(u8)]`"
)]
pub unsafe trait Modulated: Copy + Send + Sync + 'static {
    /// The value that stands for it.
    type Wire: Value;

    /// Names of the numbers from 0 on, each ending with a NUL, if it is one of several.
    const CHOICES: &'static [*const c_char] = &[];

    /// What a value stands for; none if that is nothing.
    fn of(wire: &Self::Wire) -> Option<Self>;
}

// SAFETY: a value stands for itself.
unsafe impl<T: Value> Modulated for T {
    type Wire = T;

    fn of(wire: &T) -> Option<T> {
        Some(*wire)
    }
}

// SAFETY: both have one byte, which is 0 or 1 in a bool.
unsafe impl Modulated for bool {
    type Wire = Flag;

    fn of(wire: &Flag) -> Option<bool> {
        Some(wire.get())
    }
}

/// The value that stands for `it`.
#[must_use]
pub const fn wire<T: Modulated>(it: T) -> T::Wire {
    const { assert!(size_of::<T>() == size_of::<T::Wire>()) };
    // SAFETY: as many bytes, which are such a value by the contract of `Modulated`.
    unsafe { mem::transmute_copy(&it) }
}
