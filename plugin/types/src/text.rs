//! UTF-8 text of a fixed capacity, by value. It never grows: the caller chooses whether a text that does not
//! fit is refused or cut.

#![allow(unsafe_code)]

use core::fmt;
use core::mem::offset_of;

use jde_abi::raw;

use crate::part::{FieldLayout, Part};

/// A text of up to `N` bytes of UTF-8; `N` is a multiple of 4.
///
/// Bytes from other writers may be wrong: a length above the capacity counts as the capacity, and reading
/// stops before the first byte that is not UTF-8.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Text<const N: usize> {
    length: u32,
    bytes: [u8; N],
}

impl<const N: usize> Text<N> {
    /// The empty text.
    pub const EMPTY: Self = Self {
        length: 0,
        bytes: [0; N],
    };

    /// Returns a copy of `text`. In a constant, a text that is too long is a compile error.
    ///
    /// # Panics
    /// If `text` has more than `N` bytes; [`Self::truncated`] cuts instead, and `try_from` refuses.
    #[must_use]
    pub const fn new(text: &str) -> Self {
        assert!(text.len() <= N, "the text is longer than its capacity");
        let mut this = Self::EMPTY;
        let mut at = 0;
        while at < text.len() {
            this.bytes[at] = text.as_bytes()[at];
            at += 1;
        }
        this.length = text.len() as u32;
        this
    }

    /// Returns as much of `text` as fits, in whole characters.
    #[must_use]
    pub fn truncated(text: &str) -> Self {
        Self::new(&text[..text.floor_char_boundary(N)])
    }

    /// Returns the text, up to the first byte that is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = &self.bytes[..self.len()];
        match core::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => core::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
        }
    }

    /// Returns the length of the text in bytes.
    #[must_use]
    pub fn len(&self) -> usize {
        (self.length as usize).min(N)
    }

    /// Returns whether the text is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl<const N: usize> TryFrom<&str> for Text<N> {
    type Error = TooLong;

    fn try_from(text: &str) -> Result<Self, TooLong> {
        if text.len() > N {
            return Err(TooLong {
                length: text.len(),
                capacity: N,
            });
        }
        Ok(Self::new(text))
    }
}

impl<const N: usize> PartialEq for Text<N> {
    fn eq(&self, other: &Self) -> bool {
        self.as_str() == other.as_str()
    }
}

impl<const N: usize> Eq for Text<N> {}

impl<const N: usize> PartialEq<str> for Text<N> {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl<const N: usize> PartialEq<&str> for Text<N> {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl<const N: usize> fmt::Display for Text<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl<const N: usize> fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

// SAFETY: a number and bytes, for which every byte pattern is valid, without a gap because `N` is a multiple
// of the number's size.
unsafe impl<const N: usize> Part for Text<N> {
    const SHAPE: FieldLayout = {
        assert!(N.is_multiple_of(4), "the capacity of a text is a multiple of 4");
        FieldLayout::scalar(raw::U8).repeated(raw::TEXT, N, offset_of!(Self, bytes))
    };
}

/// More elements or bytes than the capacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong {
    /// The number of elements or bytes.
    pub length: usize,
    /// The capacity.
    pub capacity: usize,
}

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} do not fit into a capacity of {}",
            self.length, self.capacity
        )
    }
}

impl core::error::Error for TooLong {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_length_is_the_capacity_and_invalid_utf8_ends_the_text() {
        let text = Text {
            length: u32::MAX,
            bytes: *b"ab\xffd",
        };
        assert_eq!((text.len(), text.as_str()), (4, "ab"));
    }
}
