//! Small values of one writer: a ring of copies over atomic words, in the manner of a sequence lock.
//!
//! Word 0 is the number of the newest value (0 at first); the value with number `s` is in slot `s % slots`. A slot is two
//! words of stamp, then the value. The writer fills the slot after the newest one and then counts up, so a writer that is
//! stopped in the middle holds up nobody. A reader copies the newest slot and tries again only if, meanwhile, the writer got
//! so far that it may have come round to this slot. Never for two writers at once.

use crate::cell::{Glance, Mark, Region};
use crate::sync::{AtomicU64, Ordering, fence, relax};

/// Word of the newest value's number.
const NEWEST: usize = 0;
/// Slots begin on the second line, so that the count has a line of its own.
const SLOTS: usize = 8;
/// Words of stamp before the value: time, writer.
const STAMP: usize = 2;

/// A cell for small values of one writer.
pub struct Ring {
    region: Region,
    slots: u64,
    value_words: usize,
    slot_words: usize,
}

impl Ring {
    /// A cell for values of `value_words` words, with a power of two of slots, at least 2. The value number 0 is `initial`.
    pub fn new(value_words: usize, slots: u64, initial: &[u64]) -> Self {
        assert!(slots.is_power_of_two() && slots >= 2);
        // Whole lines outside of models, so that filling a slot does not disturb the readers of its neighbour.
        let slot_words = if cfg!(loom) {
            STAMP + value_words
        } else {
            (STAMP + value_words).next_multiple_of(8)
        };
        let region = Region::new(SLOTS + slot_words * slots as usize, 0, 0);
        let ring = Self {
            region,
            slots,
            value_words,
            slot_words,
        };
        let slot = ring.slot(0);
        slot[1].store(u64::from(u32::MAX), Ordering::Relaxed);
        for (word, value) in slot[STAMP..].iter().zip(initial) {
            word.store(*value, Ordering::Relaxed);
        }
        ring
    }

    /// Number of the newest value.
    #[inline]
    pub fn newest(&self) -> u64 {
        self.region.word(NEWEST).load(Ordering::Acquire)
    }

    /// What tells that the value of that number is the newest.
    pub fn glance(&self, sequence: u64) -> Glance {
        Glance::new(self.region.word(NEWEST), u64::MAX, sequence)
    }

    /// What never tells.
    pub fn blind(&self) -> Glance {
        Glance::blind(self.region.word(NEWEST))
    }

    /// Writes the next value and answers its number. For one thread at a time; wait-free.
    pub fn publish(&self, value: &[u64], time: u64, writer: u32) -> u64 {
        let newest = self.region.word(NEWEST);
        let next = newest.load(Ordering::Relaxed) + 1;
        // A reader that sees any word stored below also sees, after its own fence, the count from before: see `read`.
        fence(Ordering::Release);
        let slot = self.slot(next);
        slot[0].store(time, Ordering::Relaxed);
        slot[1].store(u64::from(writer), Ordering::Relaxed);
        for (word, value) in slot[STAMP..].iter().zip(value) {
            word.store(*value, Ordering::Relaxed);
        }
        // A swap for its order only: sequentially consistent, for `Bell::ring`, which then asks whether anybody waits.
        newest.swap(next, Ordering::SeqCst);
        next
    }

    /// Copies the newest value. Tries again only after the writer has published `slots - 1` values during one copy.
    #[inline]
    pub fn read(&self, into: &mut [u64]) -> Mark {
        debug_assert_eq!(into.len(), self.value_words);
        loop {
            let sequence = self.newest();
            let slot = self.slot(sequence);
            let time = slot[0].load(Ordering::Relaxed);
            let writer = slot[1].load(Ordering::Relaxed) as u32;
            for (value, word) in into.iter_mut().zip(&slot[STAMP..]) {
                *value = word.load(Ordering::Relaxed);
            }
            // The writer comes to this slot again with value `sequence + slots`, after it counted `sequence + slots - 1`.
            // Had a load above seen a word of that value, this fence and the writer's would make that count visible here.
            fence(Ordering::Acquire);
            let passed = self.region.word(NEWEST).load(Ordering::Relaxed) - sequence;
            if passed < self.slots - 1 {
                return Mark {
                    sequence,
                    time,
                    writer,
                    valid_until: u64::MAX,
                };
            }
            relax();
        }
    }

    /// Number and stamp of the newest value, without the value.
    pub fn mark(&self) -> Mark {
        loop {
            let sequence = self.newest();
            let slot = self.slot(sequence);
            let time = slot[0].load(Ordering::Relaxed);
            let writer = slot[1].load(Ordering::Relaxed) as u32;
            fence(Ordering::Acquire);
            if self.region.word(NEWEST).load(Ordering::Relaxed) - sequence < self.slots - 1 {
                return Mark {
                    sequence,
                    time,
                    writer,
                    valid_until: u64::MAX,
                };
            }
            relax();
        }
    }

    #[inline]
    fn slot(&self, sequence: u64) -> &[AtomicU64] {
        let first = SLOTS + (sequence & (self.slots - 1)) as usize * self.slot_words;
        self.region.words(first..first + STAMP + self.value_words)
    }
}
