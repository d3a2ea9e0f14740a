//! Reading a variable: latch the newest value, read it as often as needed, release it (R8). It never blocks a
//! writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::ptr::NonNull;
use std::sync::Arc;

use crate::cell::{Aligned, Pin, SlotStamp, VersionCheck};
use crate::store::Cell;
use crate::{Access, Nanos, Stamp, Variable};

/// Reads a variable. A drop releases its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    storage: Storage,
    value: LatchedValue,
    latch_state: LatchState,
    /// Size of a value in bytes.
    bytes: usize,
    /// Whether its values expire for this reader. A command that is no longer in force remains readable, except for a
    /// reader of what is in force.
    expires: bool,
    /// The age from which this reader takes no value.
    stale: Nanos,
}

/// The value that was taken last.
struct LatchedValue {
    /// Where it is, in the memory that `Storage` keeps. It stays there unchanged until another value is
    /// taken.
    bytes: NonNull<u8>,
    stamp: Stamp,
    /// Recognises that nothing newer was published.
    version_check: VersionCheck,
}

// SAFETY: the pointer is to the reader's own memory, or to memory that it has pinned.
unsafe impl Send for LatchedValue {}
// SAFETY: a shared reference allows reads only.
unsafe impl Sync for LatchedValue {}

/// A value that does not change until it is released.
#[derive(Clone, Copy, Debug)]
pub struct Latched<'a> {
    /// The value, on a 64-byte boundary.
    pub bytes: &'a [u8],
    /// Its time, number and writer.
    pub stamp: Stamp,
}

/// The result of the first latch after a release.
#[derive(Clone, Copy)]
enum LatchState {
    /// No latch since the release.
    NotLatched,
    /// There is no value.
    Empty,
    /// The value that is held.
    Value,
}

/// How the latched value is kept. It is kept beyond a release: as long as nothing newer is published, the
/// next latch uses it again, and reads a single word to know that.
enum Storage {
    /// For small values: a copy.
    Copy(Aligned),
    /// For readers of other values beyond the declared number: a copy made under a lock at each latch.
    LockedCopy(Aligned),
    /// For other values: a pin. A reader has at most one, and one slot is reserved for it.
    Pin(Option<Pin>),
}

impl Reader {
    pub(crate) fn new(variable: Arc<Variable>, ticket: usize) -> Self {
        let storage = match &variable.cell {
            Cell::Pinned(_) if ticket < variable.describe().readers => Storage::Pin(None),
            Cell::Pinned(_) => Storage::LockedCopy(Aligned::new(variable.bytes())),
            Cell::Ring(_) => Storage::Copy(Aligned::new(variable.bytes())),
        };
        Self {
            bytes: variable.bytes(),
            expires: variable.expires(),
            stale: Nanos::MAX,
            value: LatchedValue::empty(&variable.cell),
            variable,
            ticket,
            storage,
            latch_state: LatchState::NotLatched,
        }
    }

    /// Returns the variable that it reads.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// Returns another reader of the variable, under the same name, without a latched value.
    #[must_use]
    pub fn duplicate(&self) -> Self {
        let mut duplicate = self.variable.reader(&self.variable.reader_name(self.ticket));
        duplicate.expires = self.expires;
        duplicate.with_stale(self.stale)
    }

    /// Returns the reader, which from now on takes no value that was measured longer than `stale` nanoseconds ago.
    #[must_use]
    pub fn with_stale(mut self, stale: Nanos) -> Self {
        self.stale = stale;
        self
    }

    /// Returns the reader, which from now on takes no command whose validity is over. Whoever looks at an application
    /// from outside uses it. The driver reads the neutral value then.
    #[must_use]
    pub fn of_what_is_in_force(mut self) -> Self {
        self.expires |= matches!(self.variable.describe().access, Access::Command { .. });
        self
    }

    /// Returns whether the time matters to the next latch. Otherwise any time may be passed.
    #[inline]
    #[must_use]
    pub fn needs_time(&self) -> bool {
        matches!(self.latch_state, LatchState::NotLatched) && (self.expires || self.stale < Nanos::MAX)
    }

    /// Latches and returns the newest value, if it is valid at `now`. Further calls return the same value at the
    /// same address until `release` or `latch_newest`. Returns `None` if the newest value has ended (R19), or if
    /// nothing was published and there is no initial value. That result lasts equally long. The newest command is
    /// returned whether it is in force or not, except to a [reader of what is in force](Self::of_what_is_in_force).
    #[inline(always)]
    pub fn latch(&mut self, now: Nanos) -> Option<Latched<'_>> {
        if let LatchState::NotLatched = self.latch_state {
            self.latch_state = self.latch_current(now);
        }
        self.latched()
    }

    /// Releases the latched value and latches the newest.
    #[inline(always)]
    pub fn latch_newest(&mut self, now: Nanos) -> Option<Latched<'_>> {
        self.latch_state = self.latch_current(now);
        self.latched()
    }

    /// Returns the latched value, if there is one.
    #[inline(always)]
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        matches!(self.latch_state, LatchState::Value).then(|| Latched {
            // SAFETY: it was taken, so this many bytes exist. Only `fetch` writes to them, with this
            // reader borrowed exclusively.
            bytes: unsafe { std::slice::from_raw_parts(self.value.bytes.as_ptr(), self.bytes) },
            stamp: self.value.stamp,
        })
    }

    /// Releases the latched value, so the next latch takes the newest.
    #[inline]
    pub fn release(&mut self) {
        self.latch_state = LatchState::NotLatched;
    }

    /// Returns the number of the newest value, without latching it; 0 before the first.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.variable.newest()
    }

    /// Latches the newest value, if it is valid.
    #[inline(always)]
    fn latch_current(&mut self, now: Nanos) -> LatchState {
        // SAFETY: this reader keeps the variable, and with it the cell and its own pin, if it has one.
        if unsafe { self.value.version_check.is_unchanged() } {
            self.current_state(now)
        } else {
            self.fetch(now)
        }
    }

    /// Fetches the newest value from the cell.
    #[inline(never)]
    fn fetch(&mut self, now: Nanos) -> LatchState {
        self.value = match (&mut self.storage, &self.variable.cell) {
            (Storage::Copy(copy), Cell::Ring(ring)) => {
                let stamp = ring.read(copy.words_mut(self.bytes.div_ceil(8)));
                LatchedValue::new(copy.base(), stamp, ring.version_check(stamp.sequence))
            }
            (Storage::Pin(held), Cell::Pinned(pinned)) => {
                if let Some(older) = held.take() {
                    pinned.unpin(older);
                }
                let pin = held.insert(pinned.pin());
                // SAFETY: pinned in this cell.
                let bytes = unsafe { pinned.bytes(pin) };
                LatchedValue::new(
                    bytes.as_ptr().cast_mut(),
                    pinned.stamp(pin),
                    pinned.version_check(pin),
                )
            }
            (Storage::LockedCopy(copy), Cell::Pinned(pinned)) => {
                let _guard = self.variable.copy_lock.lock();
                let pin = pinned.pin();
                // SAFETY: pinned in this cell.
                let newest = unsafe { pinned.bytes(&pin) };
                let value_type = &self.variable.describe().value_type;
                value_type.copy_into(newest, copy.bytes_mut(self.bytes));
                let stamp = pinned.stamp(&pin);
                pinned.unpin(pin);
                LatchedValue::new(copy.base(), stamp, pinned.never_matching())
            }
            (Storage::Copy(_), Cell::Pinned(_))
            | (Storage::LockedCopy(_) | Storage::Pin(_), Cell::Ring(_)) => {
                unreachable!("a reader's storage is made for its variable's cell")
            }
        };
        self.current_state(now)
    }

    #[inline(always)]
    fn is_stale(&self, now: Nanos) -> bool {
        self.stale < now.saturating_sub(self.value.stamp.time)
    }

    /// Returns `Value` if the value that is held is valid, or `Empty` if it has ended or does not exist.
    #[inline(always)]
    fn current_state(&self, now: Nanos) -> LatchState {
        let stamp = &self.value.stamp;
        let has_expired = self.expires && stamp.valid_until < now || self.is_stale(now);
        if !has_expired && self.variable.is_visible(stamp.sequence) {
            LatchState::Value
        } else {
            LatchState::Empty
        }
    }
}

impl LatchedValue {
    /// Returns no value. The first latch takes one.
    fn empty(cell: &Cell) -> Self {
        Self {
            bytes: NonNull::dangling(),
            stamp: SlotStamp::default().into(),
            version_check: cell.never_matching(),
        }
    }

    fn new(bytes: *mut u8, stamp: SlotStamp, version_check: VersionCheck) -> Self {
        Self {
            bytes: NonNull::new(bytes).expect("a value has an address"),
            stamp: stamp.into(),
            version_check,
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        if let (Storage::Pin(held), Cell::Pinned(pinned)) = (&mut self.storage, &self.variable.cell)
            && let Some(pin) = held.take()
        {
            pinned.unpin(pin);
        }
        self.variable.close_reader(self.ticket);
    }
}
