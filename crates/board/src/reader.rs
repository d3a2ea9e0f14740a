//! Reading a variable: latch the newest value, read it as often as needed, release it (R8). It never blocks a
//! writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::ptr::NonNull;
use std::sync::Arc;

use crate::cell::{Aligned, Glance, Mark, Pin};
use crate::store::Cell;
use crate::variable::lock;
use crate::{Stamp, Variable};

/// Reads a variable. A drop releases its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    hold: Hold,
    held: Held,
    seen: Seen,
    /// Size of a value in bytes.
    bytes: usize,
}

/// The value that was taken last.
struct Held {
    /// Where it is, in the memory that `Hold` keeps. It stays there unchanged until another value is taken.
    bytes: NonNull<u8>,
    stamp: Stamp,
    /// Recognises that nothing newer was published.
    glance: Glance,
}

// SAFETY: the pointer is to the reader's own memory, or to memory that it has pinned.
unsafe impl Send for Held {}
// SAFETY: a shared reference allows reads only.
unsafe impl Sync for Held {}

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
enum Seen {
    /// No latch since the release.
    NotLooked,
    /// There is no value.
    Nothing,
    /// The value that is held.
    Held,
}

/// How the latched value is kept. It is kept beyond a release: as long as nothing newer is published, the
/// next latch uses it again, and reads a single word to know that.
enum Hold {
    /// For small values: a copy.
    Copy(Aligned),
    /// For readers of other values beyond the declared number: a copy that is made at each latch.
    Crowded(Aligned),
    /// For other values: a pin. A reader has at most one, and one slot is reserved for it.
    Pin(Option<Pin>),
}

impl Reader {
    pub(crate) fn new(variable: Arc<Variable>, ticket: usize) -> Self {
        let hold = match &variable.cell {
            Cell::Pinned(_) if ticket < variable.describe().readers => Hold::Pin(None),
            Cell::Pinned(_) => Hold::Crowded(Aligned::new(variable.bytes())),
            Cell::Ring(_) => Hold::Copy(Aligned::new(variable.bytes())),
        };
        Self {
            bytes: variable.bytes(),
            held: Held::nothing(&variable.cell),
            variable,
            ticket,
            hold,
            seen: Seen::NotLooked,
        }
    }

    /// Returns the variable that it reads.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// Returns another reader of the variable, under the same name, without a latched value.
    #[must_use]
    pub fn another(&self) -> Self {
        self.variable.reader(&self.variable.reader_name(self.ticket))
    }

    /// Latches and returns the newest value. Further calls return the same value at the same address until
    /// `release` or `latch_newest`. Returns `None` if the newest value was retracted, or if nothing was
    /// published and there is no initial value. That result stays equally long.
    #[inline(always)]
    pub fn latch(&mut self) -> Option<Latched<'_>> {
        if let Seen::NotLooked = self.seen {
            self.seen = self.look();
        }
        self.latched()
    }

    /// Releases the latched value and latches the newest.
    #[inline(always)]
    pub fn latch_newest(&mut self) -> Option<Latched<'_>> {
        self.seen = self.look();
        self.latched()
    }

    /// Returns the latched value, if there is one.
    #[inline(always)]
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        matches!(self.seen, Seen::Held).then(|| Latched {
            // SAFETY: it was taken, so this many bytes are there. Only `take` writes to them, with this
            // reader borrowed exclusively.
            bytes: unsafe { std::slice::from_raw_parts(self.held.bytes.as_ptr(), self.bytes) },
            stamp: self.held.stamp,
        })
    }

    /// Releases the latched value, so the next latch takes the newest.
    #[inline]
    pub fn release(&mut self) {
        self.seen = Seen::NotLooked;
    }

    /// Returns the number of the newest value, without latching it; 0 before the first.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.variable.newest()
    }

    /// Holds the newest value, if there is one.
    #[inline(always)]
    fn look(&mut self) -> Seen {
        // SAFETY: this reader keeps the variable, and with it the cell and its own pin, if it has one.
        if unsafe { self.held.glance.unchanged() } {
            self.show()
        } else {
            self.take()
        }
    }

    /// Takes the newest value.
    #[inline(never)]
    fn take(&mut self) -> Seen {
        self.held = match (&mut self.hold, &self.variable.cell) {
            (Hold::Copy(copy), Cell::Ring(ring)) => {
                let mark = ring.read(copy.words_mut(self.bytes.div_ceil(8)));
                Held::new(copy.base(), mark, ring.glance(mark.sequence))
            }
            (Hold::Pin(kept), Cell::Pinned(pinned)) => {
                if let Some(older) = kept.take() {
                    pinned.unpin(older);
                }
                let pin = kept.insert(pinned.pin());
                // SAFETY: pinned in this cell.
                let bytes = unsafe { pinned.bytes(pin) };
                Held::new(bytes.as_ptr().cast_mut(), pinned.mark(pin), pinned.glance(pin))
            }
            (Hold::Crowded(copy), Cell::Pinned(pinned)) => {
                let _one_at_a_time = lock(&self.variable.copying);
                let pin = pinned.pin();
                // SAFETY: pinned in this cell.
                copy.bytes_mut(self.bytes)
                    .copy_from_slice(unsafe { pinned.bytes(&pin) });
                let mark = pinned.mark(&pin);
                pinned.unpin(pin);
                Held::new(copy.base(), mark, pinned.blind())
            }
            (Hold::Copy(_), Cell::Pinned(_)) | (Hold::Crowded(_) | Hold::Pin(_), Cell::Ring(_)) => {
                unreachable!("a reader's hold is made for its variable's cell")
            }
        };
        self.show()
    }

    /// Returns `Held` for the value that is held, or `Nothing` if it was retracted or does not exist.
    #[inline(always)]
    fn show(&self) -> Seen {
        if self.variable.shows(self.held.stamp.sequence) {
            Seen::Held
        } else {
            Seen::Nothing
        }
    }
}

impl Held {
    /// Returns no value. The first latch takes one.
    fn nothing(cell: &Cell) -> Self {
        Self {
            bytes: NonNull::dangling(),
            stamp: Mark::default().into(),
            glance: cell.blind(),
        }
    }

    fn new(bytes: *mut u8, mark: Mark, glance: Glance) -> Self {
        Self {
            bytes: NonNull::new(bytes).expect("values are somewhere"),
            stamp: mark.into(),
            glance,
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        if let (Hold::Pin(held), Cell::Pinned(pinned)) = (&mut self.hold, &self.variable.cell)
            && let Some(pin) = held.take()
        {
            pinned.unpin(pin);
        }
        self.variable.close_reader(self.ticket);
    }
}
