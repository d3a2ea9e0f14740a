//! Values of any size and any number of writers: slots that readers pin and read in place.
//!
//! Words, by lines of eight:
//! ```text
//! line 0            head: epoch (20 bits) | low bits of the sequence (32) | slot (12)
//! next lines        grants, one word for each writer: 1 while it holds the grant
//! a line per slot   use: owned (bit 32) + number of pins (below) | sequence | time | writer | valid until
//! ```
//! A slot's bytes are the block of the same number.
//!
//! # Access to a slot
//! A slot has at most one owner: the writer that fills it, or the head while it is the newest value. A writer
//! takes a slot whose use is 0: no owner and no pin. A publication swaps it into the head in place of the
//! newest slot, which the writer then releases. A reader pins the slot that the head names and reads the head
//! again. If the head still names the slot, the slot holds a whole value and keeps it. Proof: suppose that a
//! writer took the slot before the pin. It found use 0, so it came after the release by the writer that had
//! moved the head away. All of that comes before the pin and before the second read of the head (the changes
//! of a use word are one release sequence). So the second read cannot return the old head. It finds the slot
//! only as that writer, or a later one, published it. A writer that comes after the pin finds a use that is
//! not 0.
//!
//! # A writer always finds a slot
//! There are as many slots as there can be pins and owners at once, and the searching writer does not own one
//! yet: at every instant at least one slot is free. Without a second writer the head does not move during the
//! search. A reader can then newly pin the newest slot only, and so withholds at most one other slot from the
//! writer: one pass finds a free slot. With several writers a pass may fail only if another one published
//! meanwhile.
//!
//! # The gate (R7)
//! A writer reads the head, then its grant, then swaps the head if it is still the one that it read. A
//! withdrawal clears the grant and then increments the epoch in the head. A swap after that must have read
//! the incremented head, and hence the cleared grant. A swap that read the head before fails. Neither side
//! waits: a writer that stops at any point delays no withdrawal.
//!
//! # Numbers that wrap
//! The slot stores the whole sequence. The bits in the head only distinguish one head from another. A swap
//! could succeed wrongly only if a writer stopped between two instructions while exactly a multiple of 2^32
//! values and of 2^20 withdrawals passed and the same slot became the newest again. Readers do not depend on
//! these bits: any head that names the slot is sufficient.

#![allow(unsafe_code, reason = "the bytes of a slot are shared by the rules above")]

use crate::cell::{Region, SlotStamp, VersionCheck};
#[cfg(not(loom))]
use crate::shared::Shared;
use crate::sync::{AtomicU64, Ordering, relax};

const LINE_WORDS: usize = 8;
const HEAD_WORD: usize = 0;
const GRANT_WORDS: usize = LINE_WORDS;

// Words of a slot's line.
const USE_WORD: usize = 0;
const SEQUENCE_WORD: usize = 1;
const TIME_WORD: usize = 2;
const WRITER_WORD: usize = 3;
const VALID_UNTIL: usize = 4;

const FREE_SLOT: u64 = 0;
const OWNED_SLOT: u64 = 1 << 32;
const ONE_PIN: u64 = 1;

const SLOT_BITS: u32 = 12;
const SEQUENCE_BITS: u32 = 32;
const SLOT_MASK: u64 = (1 << SLOT_BITS) - 1;
const SEQUENCE_MASK: u64 = (1 << SEQUENCE_BITS) - 1;
/// Increments the epoch when added to the head. The carry is lost at the top.
const NEXT_EPOCH: u64 = 1 << (SLOT_BITS + SEQUENCE_BITS);

/// A slot that a writer fills. It must return to its cell by `publish` or `abandon`.
#[derive(Debug)]
#[must_use]
pub struct Claim(usize);

/// A slot that a reader holds. It must return to its cell by `unpin`.
#[derive(Debug)]
#[must_use]
pub struct Pin(usize);

/// The writer does not hold a grant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Withdrawn;

/// A cell for values of any size and any number of writers.
pub struct Pinned {
    region: Region,
    first_slot: usize,
    slots: usize,
}

impl Pinned {
    /// The maximum number of slots that the head can name.
    pub const MAX_SLOTS: usize = 1 << SLOT_BITS;

    /// Returns a cell for values of `bytes` bytes, with `writers` grants, and room for `claims` and `pins` at
    /// once. Value number 0 is all zero.
    ///
    /// # Panics
    /// If it needs more than [`Self::MAX_SLOTS`] slots.
    pub fn new(bytes: usize, writers: usize, claims: usize, pins: usize) -> Self {
        let (first_slot, slots) = extent(writers, claims, pins);
        let region = Region::new(first_slot + slots * LINE_WORDS, slots, bytes);
        Self::within(region, first_slot, slots)
    }

    fn within(region: Region, first_slot: usize, slots: usize) -> Self {
        let cell = Self {
            region,
            first_slot,
            slots,
        };
        // The head is 0, so it names slot 0 and owns it.
        cell.line(0)[USE_WORD].store(OWNED_SLOT, Ordering::Relaxed);
        cell.line(0)[WRITER_WORD].store(u64::from(u32::MAX), Ordering::Relaxed);
        cell.line(0)[VALID_UNTIL].store(u64::MAX, Ordering::Relaxed);
        cell
    }

    /// Takes a slot to fill. Its bytes are those of some older value.
    pub fn claim(&self) -> Claim {
        loop {
            for slot in 0..self.slots {
                let word = &self.line(slot)[USE_WORD];
                // Acquire: accesses by readers and the last owner come before those of the new owner.
                if word.load(Ordering::Relaxed) == FREE_SLOT
                    && word
                        .compare_exchange(FREE_SLOT, OWNED_SLOT, Ordering::Acquire, Ordering::Relaxed)
                        .is_ok()
                {
                    return Claim(slot);
                }
            }
            relax();
        }
    }

    /// Makes a filled slot the newest value and returns its number. With a writer's index, only while that
    /// writer holds a grant.
    ///
    /// # Errors
    /// [`Withdrawn`]; the slot is returned to the cell.
    pub fn publish(
        &self,
        claim: Claim,
        writer_index: Option<usize>,
        time: u64,
        writer: u32,
        valid_until: u64,
    ) -> Result<u64, Withdrawn> {
        let slot = claim.0;
        // Release, for `newest`, which reads without a pin.
        let line = self.line(slot);
        line[TIME_WORD].store(time, Ordering::Release);
        line[WRITER_WORD].store(u64::from(writer), Ordering::Release);
        line[VALID_UNTIL].store(valid_until, Ordering::Release);
        let mut head = self.head().load(Ordering::Acquire);
        loop {
            // Must come after the read of the head: see "The gate".
            if writer_index.is_some_and(|writer_index| !self.is_granted(writer_index)) {
                self.abandon(claim);
                return Err(Withdrawn);
            }
            let newest = slot_of(head);
            // Correct if the swap succeeds: then the slot was the newest all the time, and its sequence did
            // not change.
            let sequence = self.line(newest)[SEQUENCE_WORD]
                .load(Ordering::Relaxed)
                .wrapping_add(1);
            line[SEQUENCE_WORD].store(sequence, Ordering::Release);
            // Sequentially consistent, for `Notifier::notify_all`, which then checks for waiting threads.
            match self.head().compare_exchange_weak(
                head,
                successor(head, slot),
                Ordering::SeqCst,
                Ordering::Acquire,
            ) {
                Ok(_) => {
                    self.release(newest);
                    return Ok(sequence);
                }
                Err(moved) => head = moved,
            }
        }
    }

    /// Returns a slot that will not be published to the cell.
    pub fn abandon(&self, claim: Claim) {
        self.release(claim.0);
    }

    /// Pins the newest value. It retries only after a writer has published.
    #[inline]
    pub fn pin(&self) -> Pin {
        // Relaxed: only a guess, which the second read confirms or corrects.
        let mut slot = slot_of(self.head().load(Ordering::Relaxed));
        loop {
            self.line(slot)[USE_WORD].fetch_add(ONE_PIN, Ordering::Acquire);
            let newest = slot_of(self.head().load(Ordering::Acquire));
            if newest == slot {
                return Pin(slot);
            }
            self.unpin(Pin(slot));
            slot = newest;
        }
    }

    /// Returns a check that recognises a pinned value as the newest. While it is pinned no writer takes its
    /// slot, so a head that names the slot names this very value.
    pub fn version_check(&self, pin: &Pin) -> VersionCheck {
        VersionCheck::new(self.head(), SLOT_MASK, pin.0 as u64)
    }

    /// Returns a check that never recognises a value as the newest.
    pub fn never_matching(&self) -> VersionCheck {
        VersionCheck::never_matching(self.head())
    }

    /// Releases a value.
    #[inline]
    pub fn unpin(&self, pin: Pin) {
        self.line(pin.0)[USE_WORD].fetch_sub(ONE_PIN, Ordering::Release);
    }

    /// Returns the number and the stamp of a pinned value.
    #[inline]
    pub fn stamp(&self, pin: &Pin) -> SlotStamp {
        self.stamp_of(pin.0)
    }

    /// Returns the number and the stamp of the newest value, without pinning it.
    pub fn newest(&self) -> SlotStamp {
        let mut head = self.head().load(Ordering::Acquire);
        loop {
            let stamp = self.stamp_of(slot_of(head));
            // If a word of the stamp is already overwritten, a writer took the slot after the head had moved.
            // Reading that word makes the moved head visible to this second read.
            let current = self.head().load(Ordering::Acquire);
            if current == head {
                return stamp;
            }
            head = current;
        }
    }

    /// Grants a writer the right to publish. Only one thread at a time may call this or `withdraw`.
    pub fn grant(&self, writer_index: usize) {
        self.region
            .word(GRANT_WORDS + writer_index)
            .store(1, Ordering::Release);
    }

    /// Withdraws the grant. When this has returned, no publication of that writer takes effect, even if it
    /// began before.
    pub fn withdraw(&self, writer_index: usize) {
        self.region
            .word(GRANT_WORDS + writer_index)
            .store(0, Ordering::Relaxed);
        self.head().fetch_add(NEXT_EPOCH, Ordering::AcqRel);
    }

    /// Returns whether a writer holds a grant.
    pub fn is_granted(&self, writer_index: usize) -> bool {
        self.region
            .word(GRANT_WORDS + writer_index)
            .load(Ordering::Acquire)
            == 1
    }

    #[inline]
    fn head(&self) -> &AtomicU64 {
        self.region.word(HEAD_WORD)
    }

    #[inline]
    fn line(&self, slot: usize) -> &[AtomicU64; LINE_WORDS] {
        let first = self.first_slot + slot * LINE_WORDS;
        let line = self.region.words(first..first + LINE_WORDS).first_chunk();
        line.expect("a line has this many words")
    }

    fn release(&self, slot: usize) {
        self.line(slot)[USE_WORD].fetch_sub(OWNED_SLOT, Ordering::Release);
    }

    #[inline]
    fn stamp_of(&self, slot: usize) -> SlotStamp {
        let line = self.line(slot);
        SlotStamp {
            sequence: line[SEQUENCE_WORD].load(Ordering::Acquire),
            time: line[TIME_WORD].load(Ordering::Acquire),
            writer: line[WRITER_WORD].load(Ordering::Acquire) as u32,
            valid_until: line[VALID_UNTIL].load(Ordering::Acquire),
        }
    }
}

#[cfg(not(loom))]
impl Pinned {
    /// Returns a cell as [`Self::new`] does, whose values other processes can map.
    ///
    /// # Errors
    /// Errors of the system.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn in_file(bytes: usize, writers: usize, claims: usize, pins: usize) -> std::io::Result<Self> {
        let (first_slot, slots) = extent(writers, claims, pins);
        let region = Region::in_file(first_slot + slots * LINE_WORDS, slots, bytes)?;
        Ok(Self::within(region, first_slot, slots))
    }

    /// Returns the memory of the values, if other processes can map it.
    pub fn shared(&self) -> Option<&Shared> {
        self.region.shared()
    }

    /// Returns where the bytes begin in the memory of the values, if they are there.
    pub fn offset_of(&self, bytes: &[u8]) -> Option<usize> {
        self.region.offset_of(bytes)
    }

    /// Writes value number 0, before the cell is shared.
    pub fn set_initial(&mut self, value: &[u8]) {
        assert_eq!(value.len(), self.region.block_bytes());
        // SAFETY: the block has this many bytes, and `&mut self` proves that no other thread holds the slot.
        unsafe { std::slice::from_raw_parts_mut(self.region.block(0), self.region.block_bytes()) }
            .copy_from_slice(value);
    }

    /// Returns the bytes of a claimed slot.
    ///
    /// # Safety
    /// The claim is of this cell, and no other slice of its bytes is alive.
    pub unsafe fn bytes_mut<'a>(&'a self, claim: &'a mut Claim) -> &'a mut [u8] {
        // SAFETY: the block has this many initialised bytes. Only its owner accesses it, and the claim is the
        // proof of ownership.
        unsafe { std::slice::from_raw_parts_mut(self.region.block(claim.0), self.region.block_bytes()) }
    }

    /// Returns the bytes of a pinned value.
    ///
    /// # Safety
    /// The pin is of this cell.
    #[inline]
    pub unsafe fn bytes<'a>(&'a self, pin: &'a Pin) -> &'a [u8] {
        // SAFETY: the block has this many initialised bytes; no writer changes it while it is pinned.
        unsafe { std::slice::from_raw_parts(self.region.block(pin.0), self.region.block_bytes()) }
    }
}

#[cfg(loom)]
impl Pinned {
    /// Returns the one word that represents a claimed slot's bytes.
    pub fn block(&self, claim: &Claim) -> loom::cell::MutPtr<u64> {
        self.region.block(claim.0).get_mut()
    }

    /// Returns the one word that represents a pinned value's bytes.
    pub fn pinned_block(&self, pin: &Pin) -> loom::cell::ConstPtr<u64> {
        self.region.block(pin.0).get()
    }
}

/// Returns the word at which slots begin, and the number of slots.
fn extent(writers: usize, claims: usize, pins: usize) -> (usize, usize) {
    let slots = claims + pins + 1;
    assert!(slots <= Pinned::MAX_SLOTS, "{slots} slots");
    (GRANT_WORDS + writers.next_multiple_of(LINE_WORDS), slots)
}

#[inline]
fn slot_of(head: u64) -> usize {
    (head & SLOT_MASK) as usize
}

/// Returns the next head in the same epoch, with another slot.
fn successor(head: u64, slot: usize) -> u64 {
    let sequence = ((head >> SLOT_BITS).wrapping_add(1)) & SEQUENCE_MASK;
    let epoch = head & !(NEXT_EPOCH - 1);
    epoch | (sequence << SLOT_BITS) | slot as u64
}
