//! A sequence of a fixed capacity, by value. It never grows: an element that does not fit is returned.

#![allow(unsafe_code)]

use core::fmt;
use core::mem::offset_of;
use core::ops::{Deref, DerefMut};

use jde_abi::raw;

use crate::part::{FieldLayout, Part};
use crate::text::TooLong;

/// Up to `N` elements of type `T`; dereferences to a slice of the present ones.
///
/// Bytes from other writers may be wrong: a length above the capacity counts as the capacity.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Seq<T, const N: usize> {
    length: u32,
    /// Aligns the first element to a multiple of 8, so that no alignment of `T` leaves a gap.
    spare: u32,
    items: [T; N],
}

impl<T: Part, const N: usize> Seq<T, N> {
    /// The maximum number of elements.
    pub const CAPACITY: usize = N;

    /// Returns an empty sequence.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            length: 0,
            spare: 0,
            // SAFETY: every byte pattern is a valid `T`, because it is a `Part`.
            items: unsafe { core::mem::zeroed() },
        }
    }

    /// Returns a copy of `items`.
    ///
    /// # Errors
    /// If there are more than `N`.
    pub fn from_slice(items: &[T]) -> Result<Self, TooLong> {
        let mut this = Self::new();
        this.extend_from_slice(items)?;
        Ok(this)
    }

    /// Returns the number of elements.
    #[must_use]
    pub const fn len(&self) -> usize {
        if self.length as usize > N {
            N
        } else {
            self.length as usize
        }
    }

    /// Returns whether it has no elements.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the elements.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.items[..self.len()]
    }

    /// Returns the elements for writing.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        let length = self.len();
        &mut self.items[..length]
    }

    /// Appends `item`.
    ///
    /// # Errors
    /// Returns `item` if the sequence is full.
    pub fn push(&mut self, item: T) -> Result<(), T> {
        let length = self.len();
        let Some(place) = self.items.get_mut(length) else {
            return Err(item);
        };
        *place = item;
        self.length = length as u32 + 1;
        Ok(())
    }

    /// Appends a copy of `items`, all or none.
    ///
    /// # Errors
    /// If they do not fit.
    pub fn extend_from_slice(&mut self, items: &[T]) -> Result<(), TooLong> {
        let (length, total) = (self.len(), self.len() + items.len());
        let Some(free) = self.items.get_mut(length..total) else {
            return Err(TooLong {
                length: total,
                capacity: N,
            });
        };
        free.copy_from_slice(items);
        self.length = total as u32;
        Ok(())
    }

    /// Sets the number of elements to `length`, at most `N`, and returns them for writing. The contents of
    /// new elements are arbitrary.
    pub fn resize(&mut self, length: usize) -> &mut [T] {
        self.length = length.min(N) as u32;
        self.as_mut_slice()
    }

    /// Removes all elements.
    pub fn clear(&mut self) {
        self.length = 0;
    }
}

impl<T: Part, const N: usize> Default for Seq<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Part, const N: usize> Deref for Seq<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T: Part, const N: usize> DerefMut for Seq<T, N> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.as_mut_slice()
    }
}

impl<T: Part, const N: usize> TryFrom<&[T]> for Seq<T, N> {
    type Error = TooLong;

    fn try_from(items: &[T]) -> Result<Self, TooLong> {
        Self::from_slice(items)
    }
}

/// Keeps the first `N` elements.
impl<T: Part, const N: usize> FromIterator<T> for Seq<T, N> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut this = Self::new();
        for item in items.into_iter().take(N) {
            let _ = this.push(item);
        }
        this
    }
}

impl<'a, T: Part, const N: usize> IntoIterator for &'a Seq<T, N> {
    type Item = &'a T;
    type IntoIter = core::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Part + PartialEq, const N: usize> PartialEq for Seq<T, N> {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl<T: Part + fmt::Debug, const N: usize> fmt::Debug for Seq<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.as_slice()).finish()
    }
}

// SAFETY: two numbers and elements, for which every byte pattern is valid, without a gap by the two
// assertions.
unsafe impl<T: Part, const N: usize> Part for Seq<T, N> {
    const SHAPE: FieldLayout = {
        assert!(
            align_of::<T>() <= 8,
            "elements of a sequence are aligned to 8 bytes at most"
        );
        assert!(
            size_of::<Self>() == 8 + N * size_of::<T>(),
            "the elements of a sequence fill a multiple of 4 bytes; choose another capacity"
        );
        T::SHAPE.repeated(raw::SEQUENCE, N, offset_of!(Self, items))
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_above_the_capacity_counts_as_the_capacity() {
        let mut seq = Seq {
            length: u32::MAX,
            spare: u32::MAX,
            items: [1.0_f32; 8],
        };
        assert_eq!((seq.len(), seq.as_slice().len(), seq.iter().count()), (8, 8, 8));
        assert_eq!(seq.push(2.0), Err(2.0), "the sequence is full");
        assert!(seq.extend_from_slice(&[2.0]).is_err());
        seq.as_mut_slice()[7] = 3.0;
        assert_eq!(seq[7], 3.0);
    }
}
