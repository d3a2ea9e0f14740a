//! The types of a value's fields: numbers, [`Flag`](crate::Flag)s, texts, sequences, arrays, and other
//! structures.
//!
//! It refuses bool, enum, char and references: some of their byte patterns are invalid.

#![allow(unsafe_code)]

use core::ffi::CStr;
use core::ptr;

use jde_abi::raw;

/// A type that a field of a value can have.
///
/// # Safety
/// `SHAPE` describes every byte of the type, and every byte pattern is valid.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a field of a value",
    note = "a field is a number, `Flag` (for a bool), `Text<N>` (for a string), `Seq<T, N>` (for a vector), an array of numbers or structures, or a structure that derives `Value`"
)]
pub unsafe trait Part: Copy + Send + Sync + 'static {
    /// Its memory layout.
    const SHAPE: FieldLayout;
}

/// The memory layout of a field.
#[derive(Clone, Copy, Debug)]
pub struct FieldLayout {
    pub(crate) kind: u32,
    pub(crate) form: u32,
    pub(crate) capacity: u32,
    pub(crate) offset: usize,
    pub(crate) length_offset: usize,
    pub(crate) value_type: *const raw::Type,
}

impl FieldLayout {
    /// Returns the shape of one number.
    pub(crate) const fn scalar(kind: u32) -> Self {
        Self {
            kind,
            form: raw::ONE,
            capacity: 1,
            offset: 0,
            length_offset: 0,
            value_type: ptr::null(),
        }
    }

    /// Returns the shape of one structure.
    #[must_use]
    pub const fn structure(value_type: &'static raw::Type) -> Self {
        Self {
            value_type,
            ..Self::scalar(raw::STRUCT)
        }
    }

    /// Returns the shape of several elements of the shape `self`, the first at `offset` bytes from the start
    /// of the field.
    pub(crate) const fn repeated(self, form: u32, capacity: usize, offset: usize) -> Self {
        assert!(
            self.form == raw::ONE,
            "elements of arrays and sequences are single numbers or structures, not texts, arrays or sequences themselves"
        );
        assert!(
            0 < capacity && capacity <= u32::MAX as usize,
            "the capacity is 1 to 2^32 - 1"
        );
        Self {
            form,
            capacity: capacity as u32,
            offset,
            ..self
        }
    }
}

// SAFETY: as its elements, which follow each other without gaps.
unsafe impl<T: Part, const N: usize> Part for [T; N] {
    const SHAPE: FieldLayout = T::SHAPE.repeated(raw::ARRAY, N, 0);
}

/// Returns the table of the field of type `T` that begins `at` bytes into its structure.
#[must_use]
pub const fn field<T: Part>(
    at: usize,
    name: &'static CStr,
    doc: &'static CStr,
    unit: &'static CStr,
) -> raw::Field {
    let shape = T::SHAPE;
    raw::Field {
        size: size_of::<raw::Field>() as u32,
        kind: shape.kind,
        form: shape.form,
        capacity: shape.capacity,
        name: name.as_ptr(),
        doc: doc.as_ptr(),
        unit: unit.as_ptr(),
        offset: (at + shape.offset) as u64,
        length_offset: (at + shape.length_offset) as u64,
        value_type: shape.value_type,
        flags: 0,
        reserved: 0,
    }
}
