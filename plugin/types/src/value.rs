//! Values: plain data that any thread, process, tool or language can read by its description.
//!
//! A value owns no memory and contains no pointers, so it can cross every boundary as bytes.

#![allow(unsafe_code)]

use core::ffi::CStr;
use core::{ptr, slice};

use jde_abi::{describe, raw, read};

/// Plain data of fixed size that describes itself; implemented by `#[derive(Value)]`.
///
/// ```
/// use jde_types::{Pose2D, Seq, Text, Value};
///
/// /// Landmarks as seen from the robot.
/// #[derive(Clone, Copy, Value)]
/// #[repr(C)]
/// #[value(name = "my_msgs/msg/Landmarks")]
/// pub struct Landmarks {
///     /// The pose of each landmark, in the frame of the base.
///     pub places: Seq<Pose2D, 16>,
///     /// The distance of the farthest landmark.
///     #[value(unit = "m")]
///     pub farthest: f64,
///     /// The kind of landmarks.
///     pub kind: Text<24>,
///     /// The number of landmarks lost since the last value.
///     pub lost: u32,
/// }
///
/// assert_eq!(Landmarks::describe().name, "my_msgs/msg/Landmarks");
/// ```
///
/// A field type with invalid byte patterns, and a gap that no field describes, do not compile:
///
/// ```compile_fail
/// #[derive(Clone, Copy, jde_types::Value)]
/// #[repr(C)]
/// struct Seen {
///     seen: bool, // two of 256 patterns: use `Flag`
/// }
/// ```
///
/// ```compile_fail
/// #[derive(Clone, Copy, jde_types::Value)]
/// #[repr(C)]
/// struct Gap {
///     small: u8, // followed by three bytes of alignment: add a `Padding<3>`
///     large: u32,
/// }
/// ```
///
/// # Safety
/// `TYPE` describes every byte of the type, and every pattern of bytes is a valid value of it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a value that schemas can share",
    note = "use a standard type, a number, `Flag`, `Text<N>`, or a `#[repr(C)]` structure with `#[derive(Clone, Copy, Value)]`"
)]
pub unsafe trait Value: Copy + Send + Sync + 'static {
    /// The table that describes the type.
    const TYPE: &'static raw::Type;

    /// Returns the description of the type, owned.
    ///
    /// # Panics
    /// Only if the table is invalid, which `#[derive(Value)]` excludes.
    #[must_use]
    fn describe() -> describe::Type {
        // SAFETY: a type's table follows the rules of `raw` by the contract of this trait.
        match unsafe { read::value_type(Self::TYPE) } {
            Ok(description) => description,
            Err(refusal) => panic!("{refusal}"),
        }
    }

    /// Returns the value with these bytes; `None` if their number differs from its size.
    #[must_use]
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        // SAFETY: there are as many bytes as the value has, and every pattern is valid by the contract of
        // this trait.
        (bytes.len() == size_of::<Self>()).then(|| unsafe { bytes.as_ptr().cast::<Self>().read_unaligned() })
    }

    /// Returns the value of these bytes in place; `None` if their number or alignment is another one.
    #[must_use]
    fn view(bytes: &[u8]) -> Option<&Self> {
        let value = bytes.as_ptr().cast::<Self>();
        // SAFETY: there are as many bytes as the value has, aligned as it is and borrowed for as long, and every pattern
        // is valid by the contract of this trait.
        (bytes.len() == size_of::<Self>() && value.is_aligned()).then(|| unsafe { &*value })
    }

    /// As [`Self::view`], for writing.
    #[must_use]
    fn view_mut(bytes: &mut [u8]) -> Option<&mut Self> {
        let value = bytes.as_mut_ptr().cast::<Self>();
        // SAFETY: as above, borrowed exclusively for as long.
        (bytes.len() == size_of::<Self>() && value.is_aligned()).then(|| unsafe { &mut *value })
    }

    /// Returns its bytes, as in its description.
    #[must_use]
    fn as_bytes(&self) -> &[u8] {
        // SAFETY: the value has this many bytes. All are initialised, because each belongs to a field by the
        // contract of this trait.
        unsafe { slice::from_raw_parts(ptr::from_ref(self).cast(), size_of::<Self>()) }
    }

    /// Returns its bytes for writing. Any bytes are a valid value.
    #[must_use]
    fn as_bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, borrowed exclusively for as long, and every pattern is valid.
        unsafe { slice::from_raw_parts_mut(ptr::from_mut(self).cast(), size_of::<Self>()) }
    }

    /// Returns the value whose bytes are all 0.
    #[must_use]
    fn zeroed() -> Self {
        // SAFETY: every pattern of bytes is a valid value by the contract of this trait.
        unsafe { core::mem::zeroed() }
    }

    /// Returns the value whose bytes are all 0 on the heap, for values that are too large for a stack.
    #[must_use]
    fn boxed() -> Box<Self> {
        // SAFETY: as above.
        unsafe { Box::new_zeroed().assume_init() }
    }
}

/// Returns the table of a structure with these fields.
#[must_use]
pub const fn structure<T>(
    name: &'static CStr,
    doc: &'static CStr,
    fields: &'static [raw::Field],
) -> raw::Type {
    assert!(align_of::<T>() <= 16, "a value is aligned to 16 bytes at most");
    assert!(size_of::<T>() > 0, "a value has at least one byte");
    raw::Type {
        size: size_of::<raw::Type>() as u32,
        field_count: fields.len() as u32,
        name: name.as_ptr(),
        doc: doc.as_ptr(),
        bytes: size_of::<T>() as u64,
        align: align_of::<T>() as u64,
        fields: fields.as_ptr(),
    }
}
