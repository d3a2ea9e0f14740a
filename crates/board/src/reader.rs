//! Reading a variable: latch the newest value, look at it as often as needed, release it (R8). Never blocks a writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::ptr::NonNull;
use std::sync::Arc;

use crate::cell::{Aligned, Glance, Mark, Pin};
use crate::store::Cell;
use crate::variable::lock;
use crate::{Stamp, Variable};

/// Reads a variable. Dropped, it lets go of its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    hold: Hold,
    held: Held,
    seen: Seen,
    /// Bytes of a value.
    bytes: usize,
}

/// The value that was taken last.
struct Held {
    /// Where it is, in what `Hold` keeps: stays there, as it is, until another is taken.
    bytes: NonNull<u8>,
    stamp: Stamp,
    /// What tells that nothing newer was published.
    glance: Glance,
}

// SAFETY: what it points to is the reader's own, or pinned by it.
unsafe impl Send for Held {}
// SAFETY: through a shared reference it is only read.
unsafe impl Sync for Held {}

/// A value that stays as it is until it is released.
#[derive(Clone, Copy, Debug)]
pub struct Latched<'a> {
    /// The value, on a 64-byte boundary.
    pub bytes: &'a [u8],
    /// When, which and whose.
    pub stamp: Stamp,
}

/// What the first latch after a release saw.
#[derive(Clone, Copy)]
enum Seen {
    /// There was none yet.
    NotLooked,
    /// There is no value to see.
    Nothing,
    /// The value that is held.
    Held,
}

/// How the latched value is kept. What is kept outlives a release: while nothing newer is published the next latch finds it here, and
/// looks at a single word to know that.
enum Hold {
    /// Small values: a copy.
    Copy(Aligned),
    /// Readers of others beyond the declared number: a copy that is made anew each time.
    Crowded(Aligned),
    /// Others: a pin. A reader has one at most, and there is a slot for it, used or not.
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

    /// The variable it reads.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// Another reader of the variable, under the same name; it has latched nothing.
    #[must_use]
    pub fn another(&self) -> Self {
        self.variable.reader(&self.variable.reader_name(self.ticket))
    }

    /// The newest value at the first call; the same value, at the same address, until `release` or `latch_newest`. None if then
    /// nothing was published and there is no initial value: that, too, stays so as long.
    #[inline(always)]
    pub fn latch(&mut self) -> Option<Latched<'_>> {
        if let Seen::NotLooked = self.seen {
            self.seen = self.look();
        }
        self.latched()
    }

    /// Lets go of the latched value and latches the newest.
    #[inline(always)]
    pub fn latch_newest(&mut self) -> Option<Latched<'_>> {
        self.seen = self.look();
        self.latched()
    }

    /// The value that is latched, if one is.
    #[inline(always)]
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        matches!(self.seen, Seen::Held).then(|| Latched {
            // SAFETY: it was taken, so as many bytes are there, and nobody writes to them: `take` does, borrowing this reader alone.
            bytes: unsafe { std::slice::from_raw_parts(self.held.bytes.as_ptr(), self.bytes) },
            stamp: self.held.stamp,
        })
    }

    /// Lets go of the latched value, so that the next latch takes the newest.
    #[inline]
    pub fn release(&mut self) {
        self.seen = Seen::NotLooked;
    }

    /// Number of the newest value, without latching it; 0 before the first.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.variable.newest()
    }

    /// Sees to it that the newest value is held, if there is one.
    #[inline(always)]
    fn look(&mut self) -> Seen {
        // SAFETY: this reader keeps the variable, and with it the cell, and the pin if it has one.
        if unsafe { self.held.glance.unchanged() } {
            self.show()
        } else {
            self.take()
        }
    }

    /// Gets hold of the newest value.
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

    /// What is seen of the value that is held: nothing, if it was taken back.
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
    /// No value: the first look takes one.
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
