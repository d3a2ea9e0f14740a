//! One contiguous region: atomic words first, then blocks of plain bytes. Each part and each block begins on
//! its own cache line.
//!
//! ```text
//! 0                     words * 8, rounded up to 64          + block * stride
//! | word 0 | word 1 | … | block 0                            | block 1 | …
//! ```
//! In memory that other processes map, the blocks begin on a page of their own: those processes map the
//! blocks alone. A region defines the layout only: the cells control
//! access to the blocks.

#![allow(unsafe_code, reason = "words and blocks are views of one piece of memory")]

#[cfg(not(loom))]
pub use machine::Region;
#[cfg(loom)]
pub use model::Region;

#[cfg(not(loom))]
mod machine {
    use std::ops::Range;

    use crate::cell::aligned::{Aligned, LINE};
    use crate::shared::{PAGE, Shared, memory_file};
    use crate::sync::AtomicU64;

    /// Words and blocks in one piece of memory.
    pub struct Region {
        memory: Aligned,
        shared: Option<Shared>,
        words: usize,
        blocks: usize,
        block_bytes: usize,
        first_block: usize,
        stride: usize,
    }

    impl Region {
        /// Returns a region of zeros. With `block_bytes` 0 there are no blocks.
        ///
        /// # Panics
        /// If it exceeds the address space.
        pub fn new(words: usize, blocks: usize, block_bytes: usize) -> Self {
            let first_block = (words * size_of::<AtomicU64>()).next_multiple_of(LINE);
            let bytes = first_block + blocks_size(blocks, block_bytes);
            Self {
                memory: Aligned::new(bytes),
                shared: None,
                words,
                blocks,
                block_bytes,
                first_block,
                stride: block_bytes.next_multiple_of(LINE),
            }
        }

        /// Returns such a region whose blocks other processes can map.
        ///
        /// # Errors
        /// Errors of the system, which may have no memory or no file descriptor left.
        pub fn in_file(words: usize, blocks: usize, block_bytes: usize) -> std::io::Result<Self> {
            let first_block = (words * size_of::<AtomicU64>()).next_multiple_of(PAGE);
            let blocks_size = blocks_size(blocks, block_bytes);
            let file = memory_file(first_block + blocks_size)?;
            Ok(Self {
                memory: Aligned::of_file(&file, first_block + blocks_size)?,
                shared: Some(Shared::new(file, first_block, blocks_size)),
                words,
                blocks,
                block_bytes,
                first_block,
                stride: block_bytes.next_multiple_of(LINE),
            })
        }

        /// Returns the blocks as other processes can map them, if they can.
        pub fn shared(&self) -> Option<&Shared> {
            self.shared.as_ref()
        }

        /// Returns where the bytes begin among the blocks, if they are there.
        pub fn offset_of(&self, bytes: &[u8]) -> Option<usize> {
            let blocks = self.memory.base() as usize + self.first_block;
            let offset = (bytes.as_ptr() as usize).checked_sub(blocks)?;
            (offset + bytes.len() <= self.stride * self.blocks).then_some(offset)
        }

        /// Returns word number `index`.
        #[inline]
        pub fn word(&self, index: usize) -> &AtomicU64 {
            &self.all()[index]
        }

        /// Returns the words of a range.
        #[inline]
        pub fn words(&self, range: Range<usize>) -> &[AtomicU64] {
            &self.all()[range]
        }

        #[inline]
        fn all(&self) -> &[AtomicU64] {
            // SAFETY: the words are inside the memory, aligned, initialised, and accessed as atomics only.
            unsafe { std::slice::from_raw_parts(self.memory.base().cast(), self.words) }
        }

        /// Returns the size of a block in bytes.
        #[inline]
        pub fn block_bytes(&self) -> usize {
            self.block_bytes
        }

        /// Returns the address of block number `index`, on a cache line boundary.
        #[inline]
        pub fn block(&self, index: usize) -> *mut u8 {
            assert!(index < self.blocks, "block {index} of {}", self.blocks);
            // SAFETY: inside the memory, by the assertion and the size of the region.
            unsafe { self.memory.base().add(self.first_block + index * self.stride) }
        }
    }

    /// Returns the size of all blocks in bytes.
    fn blocks_size(blocks: usize, block_bytes: usize) -> usize {
        let stride = block_bytes.next_multiple_of(LINE);
        let blocks_size = stride
            .checked_mul(blocks)
            .filter(|blocks_size| *blocks_size < isize::MAX as usize / 2);
        blocks_size.expect("the region fits the address space")
    }
}

#[cfg(loom)]
mod model {
    use std::ops::Range;

    use loom::cell::UnsafeCell;

    use crate::sync::AtomicU64;

    /// Words and blocks as loom tracks them; a block is one word, whatever its stated size.
    pub struct Region {
        words: Box<[AtomicU64]>,
        blocks: Box<[UnsafeCell<u64>]>,
    }

    // SAFETY: loom detects every unordered access to a block.
    unsafe impl Sync for Region {}

    impl Region {
        /// Returns a region of zeros.
        pub fn new(words: usize, blocks: usize, _block_bytes: usize) -> Self {
            Self {
                words: (0..words).map(|_| AtomicU64::new(0)).collect(),
                blocks: (0..blocks).map(|_| UnsafeCell::new(0)).collect(),
            }
        }

        /// Returns word number `index`.
        pub fn word(&self, index: usize) -> &AtomicU64 {
            &self.words[index]
        }

        /// Returns the words of a range.
        pub fn words(&self, range: Range<usize>) -> &[AtomicU64] {
            &self.words[range]
        }

        /// Returns block number `index`.
        pub fn block(&self, index: usize) -> &UnsafeCell<u64> {
            &self.blocks[index]
        }
    }
}
