//! Reading a variable: latch the newest value, look at it as often as needed, release it (R8). Never blocks a writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Pin};
use crate::store::Cell;
use crate::variable::lock;
use crate::{Stamp, Variable};

/// What holds of every reader.
const ITS_CELLS: &str = "a reader's hold is made for its variable's cell";

/// Reads a variable. Dropped, it lets go of its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    hold: Hold,
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
    /// A value, which is held.
    Value(Stamp),
}

/// How the latched value is kept. What is kept outlives a release: while nothing newer is published the next latch finds it here, and
/// looks at a single word to know that.
enum Hold {
    /// Small values: a copy, with the stamp of what is in it.
    Copy { bytes: Aligned, of: Option<Stamp> },
    /// Readers of others beyond the declared number: a copy that is made anew each time, so that it never goes by the number alone.
    Crowded(Aligned),
    /// Others: a pin, with the stamp of what it holds. A reader has one at most, and there is a slot for it, used or not.
    Pin(Option<(Pin, Stamp)>),
}

impl Reader {
    pub(crate) fn new(variable: Arc<Variable>, ticket: usize) -> Self {
        let hold = match &variable.cell {
            Cell::Pinned(_) if ticket < variable.describe().readers => Hold::Pin(None),
            Cell::Pinned(_) => Hold::Crowded(Aligned::new(variable.bytes())),
            Cell::Ring(_) => Hold::Copy {
                bytes: Aligned::new(variable.bytes()),
                of: None,
            },
        };
        Self {
            bytes: variable.bytes(),
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

    /// The newest value at the first call; the same value, at the same address, until `release`. None if then nothing was
    /// published and there is no initial value: that, too, stays so until `release`.
    #[inline]
    pub fn latch(&mut self) -> Option<Latched<'_>> {
        let stamp = match self.seen {
            Seen::Value(stamp) => stamp,
            Seen::Nothing => return None,
            Seen::NotLooked => self.take()?,
        };
        Some(self.show(stamp))
    }

    /// The value that is latched, if one is.
    #[inline]
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        match self.seen {
            Seen::Value(stamp) => Some(self.show(stamp)),
            Seen::Nothing | Seen::NotLooked => None,
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

    /// Gets hold of the newest value, if there is one.
    #[inline]
    fn take(&mut self) -> Option<Stamp> {
        let stamp = match (&mut self.hold, &self.variable.cell) {
            (Hold::Copy { bytes, of }, Cell::Ring(ring)) => match *of {
                Some(stamp) if stamp.sequence == ring.newest() => stamp,
                Some(_) | None => {
                    let stamp = ring.read(bytes.words_mut(self.bytes.div_ceil(8))).into();
                    *of = Some(stamp);
                    stamp
                }
            },
            (Hold::Pin(held), Cell::Pinned(pinned)) => match held {
                Some((pin, stamp)) if pinned.is_newest(pin) => *stamp,
                Some(_) | None => {
                    if let Some((pin, _)) = held.take() {
                        pinned.unpin(pin);
                    }
                    let pin = pinned.pin();
                    let stamp = pinned.mark(&pin).into();
                    *held = Some((pin, stamp));
                    stamp
                }
            },
            (Hold::Crowded(copy), Cell::Pinned(pinned)) => {
                let _one_at_a_time = lock(&self.variable.copying);
                let pin = pinned.pin();
                // SAFETY: pinned in this cell.
                copy.bytes_mut(self.bytes)
                    .copy_from_slice(unsafe { pinned.bytes(&pin) });
                let mark = pinned.mark(&pin);
                pinned.unpin(pin);
                mark.into()
            }
            (Hold::Copy { .. }, Cell::Pinned(_)) | (Hold::Crowded(_) | Hold::Pin(_), Cell::Ring(_)) => {
                unreachable!("{ITS_CELLS}")
            }
        };
        if !self.variable.shows(stamp.sequence) {
            self.seen = Seen::Nothing;
            return None;
        }
        self.seen = Seen::Value(stamp);
        Some(stamp)
    }

    /// What is held, with its stamp.
    #[inline]
    fn show(&self, stamp: Stamp) -> Latched<'_> {
        let bytes = match (&self.hold, &self.variable.cell) {
            (Hold::Copy { bytes, .. } | Hold::Crowded(bytes), _) => bytes.bytes(self.bytes),
            // SAFETY: pinned in this cell.
            (Hold::Pin(Some((pin, _))), Cell::Pinned(pinned)) => unsafe { pinned.bytes(pin) },
            (Hold::Pin(None), _) => unreachable!("a stamp is kept only with its value"),
            (Hold::Pin(Some(_)), Cell::Ring(_)) => unreachable!("{ITS_CELLS}"),
        };
        Latched { bytes, stamp }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        if let (Hold::Pin(held), Cell::Pinned(pinned)) = (&mut self.hold, &self.variable.cell)
            && let Some((pin, _)) = held.take()
        {
            pinned.unpin(pin);
        }
        self.variable.close_reader(self.ticket);
    }
}
