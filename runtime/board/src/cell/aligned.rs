//! Zeroed memory on a cache line boundary: the process's own, or that of a file that other processes map too.
//! It never grows.

#![allow(
    unsafe_code,
    reason = "memory of a given alignment is only available as raw memory"
)]

use std::alloc::{Layout, alloc_zeroed, dealloc, handle_alloc_error};
#[cfg(not(loom))]
use std::os::fd::AsFd;
use std::ptr::NonNull;

#[cfg(not(loom))]
use crate::shared::{map, unmap};

/// Bytes of a cache line, and the alignment of all memory in this module.
pub(super) const LINE: usize = 64;

/// Owned bytes, zero at first, 64-byte aligned, a whole number of cache lines.
pub struct Aligned {
    base: NonNull<u8>,
    bytes: usize,
    from: From,
}

/// The origin of the memory, to which it returns.
enum From {
    Heap {
        start: NonNull<u8>,
        layout: Layout,
    },
    #[cfg(not(loom))]
    File,
}

// SAFETY: it owns its memory as a `Box<[u8]>` does.
unsafe impl Send for Aligned {}
// SAFETY: through a shared reference it only gives out shared bytes and a raw pointer.
unsafe impl Sync for Aligned {}

impl Aligned {
    /// Returns at least `bytes` bytes.
    ///
    /// # Panics
    /// If that exceeds the address space.
    pub fn new(bytes: usize) -> Self {
        let rounded = bytes.max(1).next_multiple_of(LINE);
        // With its own alignment, the system returns large memory that is zero without writing to it: what is never
        // used costs nothing.
        let layout = Layout::from_size_align(rounded + LINE, align_of::<u128>());
        let layout = layout.expect("a value fits the address space");
        // SAFETY: the layout is not empty.
        let Some(start) = NonNull::new(unsafe { alloc_zeroed(layout) }) else {
            handle_alloc_error(layout)
        };
        Self {
            // SAFETY: less than a line, by which the memory is longer.
            base: unsafe { start.add(start.align_offset(LINE)) },
            bytes: rounded,
            from: From::Heap { start, layout },
        }
    }

    /// Maps the first `bytes` bytes of a file, shared with every process that maps them.
    ///
    /// # Errors
    /// Errors of the system.
    #[cfg(not(loom))]
    pub fn of_file(file: impl AsFd, bytes: usize) -> std::io::Result<Self> {
        let base = map(file.as_fd(), 0, bytes, true)?;
        Ok(Self {
            base,
            bytes,
            from: From::File,
        })
    }

    /// Returns the address of the first byte. It stays valid when this owner moves.
    #[inline]
    pub fn base(&self) -> *mut u8 {
        self.base.as_ptr()
    }

    /// Returns the first `bytes` bytes.
    #[inline]
    pub fn bytes_mut(&mut self, bytes: usize) -> &mut [u8] {
        assert!(bytes <= self.bytes);
        // SAFETY: inside the allocation, initialised since its creation, and borrowed exclusively.
        unsafe { std::slice::from_raw_parts_mut(self.base(), bytes) }
    }

    /// Returns the first `words` words.
    #[inline]
    pub fn words(&self, words: usize) -> &[u64] {
        assert!(words <= self.bytes / 8);
        // SAFETY: as in `bytes_mut`; a line is aligned for words, and any bit pattern is a word.
        unsafe { std::slice::from_raw_parts(self.base().cast(), words) }
    }

    /// Returns the first `words` words.
    #[inline]
    pub fn words_mut(&mut self, words: usize) -> &mut [u64] {
        assert!(words <= self.bytes / 8);
        // SAFETY: as in `words`, and borrowed exclusively.
        unsafe { std::slice::from_raw_parts_mut(self.base().cast(), words) }
    }
}

impl Drop for Aligned {
    fn drop(&mut self) {
        match self.from {
            // SAFETY: allocated in `new` with this layout, and owned.
            From::Heap { start, layout } => unsafe { dealloc(start.as_ptr(), layout) },
            #[cfg(not(loom))]
            From::File => {
                // SAFETY: mapped in `of_file` with this size, and owned.
                unsafe { unmap(self.base, self.bytes) };
            }
        }
    }
}
