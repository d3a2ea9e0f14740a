//! The types of a modulation: a value, a bool, or an enumeration. The last two are not values, because some
//! byte patterns are invalid. They cross the boundary as values that represent them.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::mem;

use crate::{Flag, Value};

/// A type of modulation: every [`Value`], `bool`, and an enumeration with `#[derive(Choice)]`.
///
/// # Safety
/// It has as many bytes as its `Wire`, and the bytes of each of its values are those of the `Wire` that
/// represents it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a modulation",
    note = "use a number, `bool`, `Text<N>`, a structure that derives `Value`, or an enumeration with `#[derive(Clone, Copy, Choice)]` and `#[repr(u8)]`"
)]
pub unsafe trait Modulated: Copy + Send + Sync + 'static {
    /// The value that represents it.
    type Wire: Value;

    /// The names of the numbers from 0 on, each ending with a NUL, if it is an enumeration.
    const CHOICES: &'static [*const c_char] = &[];

    /// Returns the modulation that a value represents; `None` if it represents none.
    fn of(wire: &Self::Wire) -> Option<Self>;
}

// SAFETY: a value represents itself.
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

/// Returns the value that represents a modulation.
#[must_use]
pub const fn wire<T: Modulated>(modulation: T) -> T::Wire {
    const { assert!(size_of::<T>() == size_of::<T::Wire>()) };
    // SAFETY: the sizes are equal, and the bytes are such a value by the contract of `Modulated`.
    unsafe { mem::transmute_copy(&modulation) }
}
