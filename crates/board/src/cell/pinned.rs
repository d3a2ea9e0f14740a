//! Values of any size and number of writers: slots that readers pin and read in place.
//!
//! Words, by lines of eight:
//! ```text
//! line 0            head: epoch (20 bits) | low bits of the sequence (32) | slot (12)
//! next lines        seats, one word for each writer: 1 while it holds a grant
//! a line per slot   use: owned (bit 32) + number of pins (below) | sequence | time | writer | valid until
//! ```
//! A slot's bytes are the block of the same number.
//!
//! # Who may touch a slot
//! A slot has at most one owner: the writer that fills it, or the head while it is the newest value. A writer takes a slot
//! whose use is 0, which says no owner and no pin; publishing swaps it against the newest one, which the writer then lets go.
//! A reader pins the slot that the head names and looks at the head again: if that still names the slot, the slot holds a
//! whole value and keeps it. For suppose a writer took the slot before the pin. It found use 0, so it came after the release
//! by whoever had moved the head away, and all of that comes before the pin and before the second look (the changes of a use
//! word are one release sequence). So the second look cannot see the old head; it sees the slot only as that writer, or a
//! later one, published it. And who comes after the pin finds use not 0.
//!
//! # A writer always finds a slot
//! There are as many slots as pins and owners can be at once, and the writer that looks does not yet own one: at every
//! instant at least one is free. Without a second writer the head stands still while the writer looks, a reader can newly
//! pin the newest slot only, and so keeps at most one other slot from the writer: one pass finds a free one. With several
//! writers a pass may fail only if another published meanwhile.
//!
//! # The gate (R7)
//! A writer first reads the head, then its seat, then swaps the head if it is still the one it read. Withdrawing clears the
//! seat and then counts the epoch in the head up. A swap that comes after this must have read the counted head, and hence the
//! cleared seat; a swap that had read the head before fails. Nobody waits for anybody: a writer stopped at any place holds
//! up no withdrawal.
//!
//! # Numbers that wrap
//! The sequence is kept whole in the slot. The bits in the head only tell one head from another: a swap could be taken in if a
//! writer stood still between two instructions while, to the number, a multiple of 2^32 values and of 2^20 withdrawals
//! passed and the same slot became the newest again. Readers do not depend on it at all: any head that names the
//! slot will do.

#![allow(unsafe_code, reason = "the bytes of a slot are shared by the rules above")]

use crate::cell::{Glance, Mark, Region};
#[cfg(not(loom))]
use crate::shared::Shared;
use crate::sync::{AtomicU64, Ordering, relax};

const LINE_WORDS: usize = 8;
const HEAD: usize = 0;
const SEATS: usize = LINE_WORDS;

// Words of a slot's line.
const USE: usize = 0;
const SEQUENCE: usize = 1;
const TIME: usize = 2;
const WRITER: usize = 3;
const VALID_UNTIL: usize = 4;

const FREE: u64 = 0;
const OWNED: u64 = 1 << 32;
const PIN: u64 = 1;

const SLOT_BITS: u32 = 12;
const SEQUENCE_BITS: u32 = 32;
const SLOT_MASK: u64 = (1 << SLOT_BITS) - 1;
const SEQUENCE_MASK: u64 = (1 << SEQUENCE_BITS) - 1;
/// Added to the head, counts the epoch up; what it carries falls out at the top.
const NEXT_EPOCH: u64 = 1 << (SLOT_BITS + SEQUENCE_BITS);

/// A slot that a writer fills. To be given back to the cell it is of, by `publish` or `abandon`.
#[derive(Debug)]
#[must_use]
pub struct Claim(usize);

/// A slot that a reader holds. To be given back to the cell it is of, by `unpin`.
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
    /// Most slots that the head can name.
    pub const MOST_SLOTS: usize = 1 << SLOT_BITS;

    /// A cell for values of `bytes` bytes, with `seats` grants, and room for `claims` and `pins` at once. The value number 0
    /// is all zero.
    ///
    /// # Panics
    /// If it needs more than [`Self::MOST_SLOTS`] slots.
    pub fn new(bytes: usize, seats: usize, claims: usize, pins: usize) -> Self {
        let (first_slot, slots) = extent(seats, claims, pins);
        let region = Region::new(first_slot + slots * LINE_WORDS, slots, bytes);
        Self::within(region, first_slot, slots)
    }

    fn within(region: Region, first_slot: usize, slots: usize) -> Self {
        let cell = Self {
            region,
            first_slot,
            slots,
        };
        // The head, which is 0, names slot 0 and owns it.
        cell.line(0)[USE].store(OWNED, Ordering::Relaxed);
        cell.line(0)[WRITER].store(u64::from(u32::MAX), Ordering::Relaxed);
        cell.line(0)[VALID_UNTIL].store(u64::MAX, Ordering::Relaxed);
        cell
    }

    /// Takes a slot to fill. Its bytes hold what some older value left.
    pub fn claim(&self) -> Claim {
        loop {
            for slot in 0..self.slots {
                let word = &self.line(slot)[USE];
                // Acquire: what readers and the last owner did with the slot comes before what the new owner does.
                if word.load(Ordering::Relaxed) == FREE
                    && word
                        .compare_exchange(FREE, OWNED, Ordering::Acquire, Ordering::Relaxed)
                        .is_ok()
                {
                    return Claim(slot);
                }
            }
            relax();
        }
    }

    /// Makes a filled slot the newest value and answers its number. With a seat, only while that holds a grant.
    ///
    /// # Errors
    /// [`Withdrawn`]; the slot is given back.
    pub fn publish(
        &self,
        claim: Claim,
        seat: Option<usize>,
        time: u64,
        writer: u32,
        valid_until: u64,
    ) -> Result<u64, Withdrawn> {
        let slot = claim.0;
        // Release, for `newest`, which looks without a pin.
        let line = self.line(slot);
        line[TIME].store(time, Ordering::Release);
        line[WRITER].store(u64::from(writer), Ordering::Release);
        line[VALID_UNTIL].store(valid_until, Ordering::Release);
        let mut head = self.head().load(Ordering::Acquire);
        loop {
            // After the head was read: see "The gate".
            if seat.is_some_and(|seat| !self.granted(seat)) {
                self.abandon(claim);
                return Err(Withdrawn);
            }
            let newest = slot_of(head);
            // Right if the swap succeeds: then the slot was the newest all the time, and its sequence stood.
            let sequence = self.line(newest)[SEQUENCE]
                .load(Ordering::Relaxed)
                .wrapping_add(1);
            line[SEQUENCE].store(sequence, Ordering::Release);
            // Sequentially consistent, for `Bell::ring`, which then asks whether anybody waits.
            match self.head().compare_exchange_weak(
                head,
                successor(head, slot),
                Ordering::SeqCst,
                Ordering::Acquire,
            ) {
                Ok(_) => {
                    self.let_go(newest);
                    return Ok(sequence);
                }
                Err(moved) => head = moved,
            }
        }
    }

    /// Gives back a slot that will not be published.
    pub fn abandon(&self, claim: Claim) {
        self.let_go(claim.0);
    }

    /// Pins the newest value. Tries again only after a writer has published.
    #[inline]
    pub fn pin(&self) -> Pin {
        // Relaxed: only a guess, which the second look confirms or corrects.
        let mut slot = slot_of(self.head().load(Ordering::Relaxed));
        loop {
            self.line(slot)[USE].fetch_add(PIN, Ordering::Acquire);
            let newest = slot_of(self.head().load(Ordering::Acquire));
            if newest == slot {
                return Pin(slot);
            }
            self.unpin(Pin(slot));
            slot = newest;
        }
    }

    /// What tells that a pinned value is the newest. While it is pinned no writer takes its slot, so a head that names the slot names
    /// this very value.
    pub fn glance(&self, pin: &Pin) -> Glance {
        Glance::new(self.head(), SLOT_MASK, pin.0 as u64)
    }

    /// What never tells.
    pub fn blind(&self) -> Glance {
        Glance::blind(self.head())
    }

    /// Lets go of a value.
    #[inline]
    pub fn unpin(&self, pin: Pin) {
        self.line(pin.0)[USE].fetch_sub(PIN, Ordering::Release);
    }

    /// Number and stamp of a pinned value.
    #[inline]
    pub fn mark(&self, pin: &Pin) -> Mark {
        self.mark_of(pin.0)
    }

    /// Number and stamp of the newest value, without pinning it.
    pub fn newest(&self) -> Mark {
        let mut head = self.head().load(Ordering::Acquire);
        loop {
            let mark = self.mark_of(slot_of(head));
            // A stamp word that is already overwritten is one of a writer that took the slot after the head had moved; reading
            // it makes the moved head visible to this second look.
            let again = self.head().load(Ordering::Acquire);
            if again == head {
                return mark;
            }
            head = again;
        }
    }

    /// Gives a seat the grant to publish. For one thread at a time with `withdraw`.
    pub fn grant(&self, seat: usize) {
        self.region.word(SEATS + seat).store(1, Ordering::Release);
    }

    /// Takes the grant away. When this returns, no publish of that seat takes effect any more, whenever it began.
    pub fn withdraw(&self, seat: usize) {
        self.region.word(SEATS + seat).store(0, Ordering::Relaxed);
        self.head().fetch_add(NEXT_EPOCH, Ordering::AcqRel);
    }

    /// Whether a seat holds a grant.
    pub fn granted(&self, seat: usize) -> bool {
        self.region.word(SEATS + seat).load(Ordering::Acquire) == 1
    }

    #[inline]
    fn head(&self) -> &AtomicU64 {
        self.region.word(HEAD)
    }

    #[inline]
    fn line(&self, slot: usize) -> &[AtomicU64; LINE_WORDS] {
        let first = self.first_slot + slot * LINE_WORDS;
        let line = self.region.words(first..first + LINE_WORDS).first_chunk();
        line.expect("a line has so many words")
    }

    fn let_go(&self, slot: usize) {
        self.line(slot)[USE].fetch_sub(OWNED, Ordering::Release);
    }

    #[inline]
    fn mark_of(&self, slot: usize) -> Mark {
        let line = self.line(slot);
        Mark {
            sequence: line[SEQUENCE].load(Ordering::Acquire),
            time: line[TIME].load(Ordering::Acquire),
            writer: line[WRITER].load(Ordering::Acquire) as u32,
            valid_until: line[VALID_UNTIL].load(Ordering::Acquire),
        }
    }
}

#[cfg(not(loom))]
impl Pinned {
    /// As [`Self::new`], and other processes can map the values.
    ///
    /// # Errors
    /// Those of the system.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn in_file(bytes: usize, seats: usize, claims: usize, pins: usize) -> std::io::Result<Self> {
        let (first_slot, slots) = extent(seats, claims, pins);
        let region = Region::in_file(first_slot + slots * LINE_WORDS, slots, bytes)?;
        Ok(Self::within(region, first_slot, slots))
    }

    /// The memory of the values, if other processes can map it.
    pub fn shared(&self) -> Option<&Shared> {
        self.region.shared()
    }

    /// Where those bytes begin in the memory of the values, if they are there.
    pub fn place_of(&self, bytes: &[u8]) -> Option<usize> {
        self.region.place_of(bytes)
    }

    /// Writes the value number 0, while nobody shares the cell yet.
    pub fn set_initial(&mut self, value: &[u8]) {
        assert_eq!(value.len(), self.region.block_bytes());
        // SAFETY: the block has this many bytes, and `&mut self` says that nobody holds the slot.
        unsafe { std::slice::from_raw_parts_mut(self.region.block(0), self.region.block_bytes()) }
            .copy_from_slice(value);
    }

    /// The bytes of a claimed slot.
    ///
    /// # Safety
    /// The claim is of this cell, and no other slice of its bytes is alive.
    pub unsafe fn bytes_mut<'a>(&'a self, claim: &'a mut Claim) -> &'a mut [u8] {
        // SAFETY: the block has this many initialised bytes; its owner alone touches it, and the claim says who that is.
        unsafe { std::slice::from_raw_parts_mut(self.region.block(claim.0), self.region.block_bytes()) }
    }

    /// The bytes of a pinned value.
    ///
    /// # Safety
    /// The pin is of this cell.
    #[inline]
    pub unsafe fn bytes<'a>(&'a self, pin: &'a Pin) -> &'a [u8] {
        // SAFETY: the block has this many initialised bytes; nobody writes to it while it is pinned.
        unsafe { std::slice::from_raw_parts(self.region.block(pin.0), self.region.block_bytes()) }
    }
}

#[cfg(loom)]
impl Pinned {
    /// The one word that stands for a claimed slot's bytes.
    pub fn block(&self, claim: &Claim) -> loom::cell::MutPtr<u64> {
        self.region.block(claim.0).get_mut()
    }

    /// The one word that stands for a pinned value's bytes.
    pub fn pinned_block(&self, pin: &Pin) -> loom::cell::ConstPtr<u64> {
        self.region.block(pin.0).get()
    }
}

/// The word at which slots begin, and how many there are.
fn extent(seats: usize, claims: usize, pins: usize) -> (usize, usize) {
    let slots = claims + pins + 1;
    assert!(slots <= Pinned::MOST_SLOTS, "{slots} slots");
    (SEATS + seats.next_multiple_of(LINE_WORDS), slots)
}

#[inline]
fn slot_of(head: u64) -> usize {
    (head & SLOT_MASK) as usize
}

/// The head after `head` in the same epoch, with another slot.
fn successor(head: u64, slot: usize) -> u64 {
    let sequence = ((head >> SLOT_BITS).wrapping_add(1)) & SEQUENCE_MASK;
    let epoch = head & !(NEXT_EPOCH - 1);
    epoch | (sequence << SLOT_BITS) | slot as u64
}
