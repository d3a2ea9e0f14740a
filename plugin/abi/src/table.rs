//! Reads and writes tables of different minor versions. A reader copies as many bytes as the shorter of the
//! two tables has. A writer fills in no more than the receiver's table has. Follows no pointer within a
//! table; [`crate::read`] does.

#![allow(unsafe_code)]

use core::ffi::c_char;
use core::fmt;
use core::mem::MaybeUninit;
use core::ptr;

use crate::raw;

/// A table that states its size.
///
/// # Safety
/// It is in C layout, and a `u32` at `SIZE_AT` is its size. A value whose bytes from `LEAST` on are all 0 is
/// valid.
pub unsafe trait Table: Copy {
    /// Its size in bytes in the minor version that introduced it. A shorter table is invalid.
    const LEAST: usize;
    /// The offset of its size. In a plugin, the magic number and the version precede the size.
    const SIZE_AT: usize = 0;
}

/// Why a table cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The pointer is null or not aligned.
    Pointer,
    /// It is shorter than in every version.
    Short {
        /// The size that it states, in bytes.
        stated: u32,
        /// The least size in any version, in bytes.
        least: usize,
    },
}

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pointer => write!(f, "the pointer to its table is null or not aligned"),
            Self::Short { stated, least } => {
                write!(
                    f,
                    "a table says it has {stated} bytes, and this ABI needs {least}"
                )
            }
        }
    }
}

impl core::error::Error for Unreadable {}

/// Returns a copy of a table in the layout of this version. What a shorter table lacks is 0, `None` or null.
/// What a longer table has beyond is ignored.
///
/// # Errors
/// [`Unreadable`].
///
/// # Safety
/// `table` is null, not aligned, or a table of as many bytes as it states.
pub unsafe fn read<T: Table>(table: *const T) -> Result<T, Unreadable> {
    if table.is_null() || !table.is_aligned() {
        return Err(Unreadable::Pointer);
    }
    // SAFETY: the caller's.
    let stated = unsafe { table.byte_add(T::SIZE_AT).cast::<u32>().read() };
    if (stated as usize) < T::LEAST {
        return Err(Unreadable::Short {
            stated,
            least: T::LEAST,
        });
    }
    let mut copy = MaybeUninit::<T>::zeroed();
    let bytes = size_of::<T>().min(stated as usize);
    // SAFETY: both have that many bytes. The bytes beyond may be 0 by the contract of `Table`.
    unsafe {
        ptr::copy_nonoverlapping(table.cast::<u8>(), copy.as_mut_ptr().cast::<u8>(), bytes);
        Ok(copy.assume_init())
    }
}

/// Fills in a table that the other side lent, up to the size that it states, and keeps that size. A size
/// below the least counts as the least.
///
/// # Safety
/// `out` points to a table of as many bytes as it states, or of the least size. Nothing else uses it
/// meanwhile.
pub unsafe fn write<T: Table>(out: *mut T, value: &T) {
    const SIZE: usize = size_of::<u32>();
    const { assert!(T::SIZE_AT == 0, "a table that is lent begins with its size") };
    let out = out.cast::<u8>();
    // SAFETY: the caller's.
    let stated = unsafe { out.cast::<u32>().read() } as usize;
    let value = ptr::from_ref(value).cast::<u8>();
    // SAFETY: the caller's. The bytes of a table are those of its fields, and the value has as many as are
    // copied.
    unsafe {
        if stated >= size_of::<T>() {
            ptr::copy_nonoverlapping(value.add(SIZE), out.add(SIZE), size_of::<T>() - SIZE);
        } else {
            ptr::copy_nonoverlapping(value.add(SIZE), out.add(SIZE), stated.max(T::LEAST) - SIZE);
        }
    }
}

/// Returns the table of an ability of a schema type, by its id. `None` if the type does not have the ability.
///
/// # Errors
/// [`Unreadable`].
///
/// # Safety
/// `schema` follows the rules of [`raw`], and `T` is the table of that ability.
pub unsafe fn ability<T: Table>(schema: &raw::Schema, id: &str) -> Result<Option<T>, Unreadable> {
    let Some(ability) = schema.ability else {
        return Ok(None);
    };
    let id = std::ffi::CString::new(id).expect("an id contains no NUL");
    // SAFETY: the caller's function, and a text that lives for the call.
    let table = unsafe { ability(id.as_ptr()) }.cast::<T>();
    if table.is_null() {
        return Ok(None);
    }
    // SAFETY: a plugin returns such a table for that id.
    unsafe { read(table) }.map(Some)
}

macro_rules! tables {
    ($($table:ident $least:literal),* $(,)?) => { $(
        // SAFETY: it is in C layout and states its size there. Its fields are numbers, pointers and optional
        // functions; functions that are not optional are within the least size.
        unsafe impl Table for raw::$table {
            const SIZE_AT: usize = core::mem::offset_of!(raw::$table, size);
            const LEAST: usize = {
                assert!($least <= size_of::<raw::$table>(), "tables only grow");
                $least
            };
        }
    )* };
}

// The sizes are those of a 64-bit machine. A new table is entered with its size. None of these numbers ever
// changes.
tables! {
    Plugin 64, Schema 128, Port 80, Child 40, Type 48, Field 64,
    Precondition 16, Level 32, Candidate 24, Verdict 136, ChildStatus 16, Host 128,
    Panel 24, Pen 40, Widget 128, Shape 104, Gesture 104,
    State 24, Saver 24,
    Inspect 16, Problems 24,
    Guard 24, Judgement 136,
    Lists 24, PortList 40, ListedPort 40,
}

const _: () = assert!(
    size_of::<raw::Sample>() == 40,
    "a sample states no size, so its layout never changes"
);

/// The longest text that is accepted from a plugin, bytes.
const MAX_TEXT_BYTES: u64 = 64 << 10;

/// Copies a text of a plugin, at most 64 KiB of it.
///
/// # Safety
/// `text` is null, or has that length.
#[must_use]
pub unsafe fn text_of(text: *const c_char, length: u64) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: the caller guarantees the length.
    let bytes =
        unsafe { core::slice::from_raw_parts(text.cast::<u8>(), length.min(MAX_TEXT_BYTES) as usize) };
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table in the layout of a later version.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Later {
        size: u32,
        first: u32,
        second: u64,
    }

    // SAFETY: numbers in C layout, the size first.
    unsafe impl Table for Later {
        const LEAST: usize = 8;
    }

    fn later(size: u32) -> Later {
        Later {
            size,
            first: 1,
            second: 2,
        }
    }

    #[test]
    fn fields_that_a_shorter_table_lacks_are_0() {
        // SAFETY: it has at least the bytes that it states.
        let read = |size| unsafe { read(&raw const *Box::new(later(size))) };
        let second = |size| read(size).map(|table| (table.first, table.second));
        assert_eq!(second(8), Ok((1, 0)));
        assert_eq!(second(16), Ok((1, 2)));
        assert_eq!(second(7), Err(Unreadable::Short { stated: 7, least: 8 }));
    }

    #[test]
    fn bytes_beyond_the_own_layout_of_a_longer_table_are_ignored() {
        let longer = (later(24), 3_u64);
        // SAFETY: it has the bytes that it states.
        assert_eq!(unsafe { read(&raw const longer.0) }, Ok(later(24)));
    }

    #[test]
    fn a_null_or_misaligned_pointer_is_refused() {
        // SAFETY: null and alignment are checked.
        unsafe {
            assert_eq!(read::<Later>(ptr::null()), Err(Unreadable::Pointer));
            assert_eq!(
                read::<Later>(ptr::without_provenance(9)),
                Err(Unreadable::Pointer)
            );
        }
    }

    #[test]
    fn nothing_is_written_beyond_the_stated_size() {
        for (stated, second) in [(0, 9), (8, 9), (12, 0xF_0000_0002), (16, 2), (99, 2)] {
            let mut out = Later {
                size: stated,
                first: 9,
                second: if stated == 12 { 0xF_0000_0009 } else { 9 },
            };
            // SAFETY: it has room for all bytes that may be written.
            unsafe { write(&raw mut out, &later(16)) };
            assert_eq!((out.size, out.first, out.second), (stated, 1, second));
        }
    }
}
