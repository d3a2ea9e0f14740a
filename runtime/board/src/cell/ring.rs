//! Small values of one writer: a ring of copies in atomic words, similar to a sequence lock.
//!
//! Word 0 is the number of the newest value (0 at first). The value with number `s` is in slot `s % slots`. A
//! slot is three words of stamp, then the value. The writer fills the slot after the newest one and then
//! increments the number, so a writer that stops in the middle delays no reader. A reader copies the newest
//! slot, and retries only if the writer may have reached this slot again meanwhile. It supports only one
//! writer at a time.

use crate::cell::{Region, SlotStamp, VersionCheck};
use crate::sync::{AtomicU64, Ordering, fence, relax};

/// Index of the word with the newest value's number.
const NEWEST_WORD: usize = 0;
/// Slots begin on the second cache line, so the number has a line of its own.
const FIRST_SLOT_WORD: usize = 8;
/// Words of stamp before the value: time, writer and the end of its validity.
const STAMP_WORDS: usize = 3;

/// A cell for small values of one writer.
pub struct Ring {
    region: Region,
    slots: u64,
    value_words: usize,
    slot_words: usize,
}

impl Ring {
    /// Returns a cell for values of `value_words` words. `slots` is a power of two, at least 2. Value number
    /// 0 is `initial`.
    pub fn new(value_words: usize, slots: u64, initial: &[u64]) -> Self {
        assert!(slots.is_power_of_two() && slots >= 2);
        // Whole cache lines outside of models, so filling a slot does not disturb the readers of its
        // neighbour.
        let slot_words = if cfg!(loom) {
            STAMP_WORDS + value_words
        } else {
            (STAMP_WORDS + value_words).next_multiple_of(8)
        };
        let region = Region::new(FIRST_SLOT_WORD + slot_words * slots as usize, 0, 0);
        let ring = Self {
            region,
            slots,
            value_words,
            slot_words,
        };
        let slot = ring.slot(0);
        slot[1].store(u64::from(u32::MAX), Ordering::Relaxed);
        slot[2].store(u64::MAX, Ordering::Relaxed);
        for (word, value) in slot[STAMP_WORDS..].iter().zip(initial) {
            word.store(*value, Ordering::Relaxed);
        }
        ring
    }

    /// Returns the number of the newest value.
    #[inline]
    pub fn newest(&self) -> u64 {
        self.region.word(NEWEST_WORD).load(Ordering::Acquire)
    }

    /// Returns a check that recognises the value of that number as the newest.
    pub fn version_check(&self, sequence: u64) -> VersionCheck {
        VersionCheck::new(self.region.word(NEWEST_WORD), u64::MAX, sequence)
    }

    /// Returns a check that never recognises a value as the newest.
    pub fn never_matching(&self) -> VersionCheck {
        VersionCheck::never_matching(self.region.word(NEWEST_WORD))
    }

    /// Writes the next value and returns its number. Only one thread at a time may call this; wait-free.
    pub fn publish(&self, value: &[u64], time: u64, writer: u32, valid_until: u64) -> u64 {
        let newest = self.region.word(NEWEST_WORD);
        let next = newest.load(Ordering::Relaxed) + 1;
        // A reader that sees any word stored below also sees, after its own fence, the number from before:
        // see `read`.
        fence(Ordering::Release);
        let slot = self.slot(next);
        slot[0].store(time, Ordering::Relaxed);
        slot[1].store(u64::from(writer), Ordering::Relaxed);
        slot[2].store(valid_until, Ordering::Relaxed);
        for (word, value) in slot[STAMP_WORDS..].iter().zip(value) {
            word.store(*value, Ordering::Relaxed);
        }
        // A swap for its ordering only: sequentially consistent, for `Notifier::notify_all`, which then
        // checks for waiting threads.
        newest.swap(next, Ordering::SeqCst);
        next
    }

    /// Copies the newest value. It retries only if the writer has published `slots - 1` values during one
    /// copy.
    #[inline]
    pub fn read(&self, output: &mut [u64]) -> SlotStamp {
        debug_assert_eq!(output.len(), self.value_words);
        loop {
            let sequence = self.newest();
            let slot = self.slot(sequence);
            let time = slot[0].load(Ordering::Relaxed);
            let writer = slot[1].load(Ordering::Relaxed) as u32;
            let valid_until = slot[2].load(Ordering::Relaxed);
            for (value, word) in output.iter_mut().zip(&slot[STAMP_WORDS..]) {
                *value = word.load(Ordering::Relaxed);
            }
            // The writer reaches this slot again with value `sequence + slots`, after it has published
            // `sequence + slots - 1`. If a load above saw a word of that value, this fence and the writer's
            // make that number visible here.
            fence(Ordering::Acquire);
            let passed = self.region.word(NEWEST_WORD).load(Ordering::Relaxed) - sequence;
            if passed < self.slots - 1 {
                return SlotStamp {
                    sequence,
                    time,
                    writer,
                    valid_until,
                };
            }
            relax();
        }
    }

    /// Returns the number and the stamp of the newest value, without the value.
    pub fn stamp(&self) -> SlotStamp {
        loop {
            let sequence = self.newest();
            let slot = self.slot(sequence);
            let time = slot[0].load(Ordering::Relaxed);
            let writer = slot[1].load(Ordering::Relaxed) as u32;
            let valid_until = slot[2].load(Ordering::Relaxed);
            fence(Ordering::Acquire);
            if self.region.word(NEWEST_WORD).load(Ordering::Relaxed) - sequence < self.slots - 1 {
                return SlotStamp {
                    sequence,
                    time,
                    writer,
                    valid_until,
                };
            }
            relax();
        }
    }

    #[inline]
    fn slot(&self, sequence: u64) -> &[AtomicU64] {
        let first = FIRST_SLOT_WORD + (sequence & (self.slots - 1)) as usize * self.slot_words;
        self.region.words(first..first + STAMP_WORDS + self.value_words)
    }
}
