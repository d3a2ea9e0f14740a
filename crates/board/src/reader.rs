//! Reading a variable: latch the newest value, look at it as often as needed, release it (R8). Never blocks a writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Pin};
use crate::store::Cell;
use crate::variable::lock;
use crate::{Stamp, Variable};

/// Reads a variable. Dropped, it lets go of its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    hold: Hold,
    /// Of the value that is held, if one is.
    stamp: Option<Stamp>,
    seen: Seen,
    /// Bytes of a value.
    bytes: usize,
}

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
            variable,
            ticket,
            hold,
            stamp: None,
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

    /// The newest value at the first call; the same value, at the same address, until `release`. None if then nothing was
    /// published and there is no initial value: that, too, stays so until `release`.
    #[inline(always)]
    pub fn latch(&mut self) -> Option<Latched<'_>> {
        if let Seen::NotLooked = self.seen {
            self.seen = self.look();
        }
        self.latched()
    }

    /// The value that is latched, if one is.
    #[inline(always)]
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        match (self.seen, &self.stamp) {
            (Seen::Held, Some(stamp)) => Some(Latched {
                bytes: self.held(),
                stamp: *stamp,
            }),
            (Seen::Held, None) | (Seen::Nothing | Seen::NotLooked, _) => None,
        }
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
        let newest = match (&self.hold, &self.variable.cell, &self.stamp) {
            (Hold::Copy(_), Cell::Ring(ring), Some(stamp)) => ring.newest() == stamp.sequence,
            (Hold::Pin(Some(pin)), Cell::Pinned(pinned), _) => pinned.is_newest(pin),
            _ => false,
        };
        if !newest {
            self.take();
        }
        match &self.stamp {
            Some(stamp) if self.variable.shows(stamp.sequence) => Seen::Held,
            Some(_) | None => Seen::Nothing,
        }
    }

    /// Gets hold of the newest value.
    #[inline(never)]
    fn take(&mut self) {
        let mark = match (&mut self.hold, &self.variable.cell) {
            (Hold::Copy(copy), Cell::Ring(ring)) => ring.read(copy.words_mut(self.bytes.div_ceil(8))),
            (Hold::Pin(held), Cell::Pinned(pinned)) => {
                if let Some(older) = held.take() {
                    pinned.unpin(older);
                }
                let pin = pinned.pin();
                let mark = pinned.mark(&pin);
                *held = Some(pin);
                mark
            }
            (Hold::Crowded(copy), Cell::Pinned(pinned)) => {
                let _one_at_a_time = lock(&self.variable.copying);
                let pin = pinned.pin();
                // SAFETY: pinned in this cell.
                copy.bytes_mut(self.bytes)
                    .copy_from_slice(unsafe { pinned.bytes(&pin) });
                let mark = pinned.mark(&pin);
                pinned.unpin(pin);
                mark
            }
            (Hold::Copy(_), Cell::Pinned(_)) | (Hold::Crowded(_) | Hold::Pin(_), Cell::Ring(_)) => {
                unreachable!("a reader's hold is made for its variable's cell")
            }
        };
        self.stamp = Some(mark.into());
    }

    /// The bytes of the value that is held.
    #[inline(always)]
    fn held(&self) -> &[u8] {
        match (&self.hold, &self.variable.cell) {
            (Hold::Copy(copy) | Hold::Crowded(copy), _) => copy.bytes(self.bytes),
            // SAFETY: pinned in this cell.
            (Hold::Pin(Some(pin)), Cell::Pinned(pinned)) => unsafe { pinned.bytes(pin) },
            (Hold::Pin(_), _) => unreachable!("a stamp is kept only with its value"),
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
