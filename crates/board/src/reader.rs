//! Reading a variable: latch the newest value, look at it as often as needed, release it (R8). Never blocks a writer.

#![allow(unsafe_code, reason = "a pinned slot is read in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Pin};
use crate::variable::{Cell, lock};
use crate::{Stamp, Variable};

/// Reads a variable. Dropped, it lets go of its value.
pub struct Reader {
    variable: Arc<Variable>,
    ticket: usize,
    hold: Hold,
    stamp: Option<Stamp>,
}

/// A value that stays as it is until it is released.
#[derive(Clone, Copy, Debug)]
pub struct Latched<'a> {
    /// The value, on a 64-byte boundary.
    pub bytes: &'a [u8],
    /// When, which and whose.
    pub stamp: Stamp,
}

/// How the latched value is kept.
enum Hold {
    /// Small values, and readers beyond the declared number.
    Copy(Aligned),
    /// Others.
    Pin(Option<Pin>),
}

impl Reader {
    pub(crate) fn new(variable: Arc<Variable>, ticket: usize) -> Self {
        let hold = match &variable.cell {
            Cell::Pinned(_) if ticket < variable.describe().readers => Hold::Pin(None),
            Cell::Ring(_) | Cell::Pinned(_) => Hold::Copy(Aligned::new(variable.bytes())),
        };
        Self {
            variable,
            ticket,
            hold,
            stamp: None,
        }
    }

    /// The variable it reads.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// The newest value at the first call; the same value, at the same address, until `release`. None while nothing was
    /// published and there is no initial value; that is not kept, the next call looks again.
    pub fn latch(&mut self) -> Option<Latched<'_>> {
        if self.stamp.is_none() {
            self.take();
        }
        self.latched()
    }

    /// The value that is latched, if one is.
    #[must_use]
    pub fn latched(&self) -> Option<Latched<'_>> {
        let stamp = self.stamp?;
        let bytes = match (&self.hold, &self.variable.cell) {
            (Hold::Copy(copy), _) => copy.bytes(self.variable.bytes()),
            // SAFETY: pinned in this cell.
            (Hold::Pin(Some(pin)), Cell::Pinned(pinned)) => unsafe { pinned.bytes(pin) },
            (Hold::Pin(_), _) => return None,
        };
        Some(Latched { bytes, stamp })
    }

    /// Lets go of the latched value, so that the next latch takes the newest.
    pub fn release(&mut self) {
        self.stamp = None;
        if let (Hold::Pin(pin), Cell::Pinned(pinned)) = (&mut self.hold, &self.variable.cell)
            && let Some(pin) = pin.take()
        {
            pinned.unpin(pin);
        }
    }

    /// Number of the newest value, without latching it; 0 before the first.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.variable.newest()
    }

    fn take(&mut self) {
        let bytes = self.variable.bytes();
        let stamp: Stamp = match (&mut self.hold, &self.variable.cell) {
            (Hold::Copy(copy), Cell::Ring(ring)) => ring.read(copy.words_mut(bytes.div_ceil(8))).into(),
            (Hold::Copy(copy), Cell::Pinned(pinned)) => {
                let _one_at_a_time = lock(&self.variable.copying);
                let pin = pinned.pin();
                // SAFETY: pinned in this cell.
                copy.bytes_mut(bytes)
                    .copy_from_slice(unsafe { pinned.bytes(&pin) });
                let stamp = pinned.mark(&pin).into();
                pinned.unpin(pin);
                stamp
            }
            (Hold::Pin(held), Cell::Pinned(pinned)) => {
                let pin = pinned.pin();
                let stamp = pinned.mark(&pin).into();
                *held = Some(pin);
                stamp
            }
            (Hold::Pin(_), Cell::Ring(_)) => unreachable!("small values are copied"),
        };
        if self.variable.shows(stamp.sequence) {
            self.stamp = Some(stamp);
        } else {
            self.release();
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.release();
        self.variable.close_reader(self.ticket);
    }
}
