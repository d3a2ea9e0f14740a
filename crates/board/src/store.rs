//! The choice of a variable's cell, and what both kinds of cell have in common.

use crate::cell::{Aligned, Glance, Mark, Pinned, Ring};
use crate::{Access, Declaration, Stamp};

/// Largest value that readers copy and do not borrow, in bytes: two cache lines.
const MOST_COPIED: usize = 128;
/// Slots of a small value's ring. A reader retries only if three values are published during one copy.
const RING_SLOTS: u64 = 4;

/// The cell of a variable.
pub(crate) enum Cell {
    Ring(Ring),
    Pinned(Pinned),
}

impl Cell {
    /// The maximum of writers and readers together, without the two spare ones of [`Cell::new`] and the
    /// newest value.
    pub(crate) const MOST_USERS: usize = Pinned::MOST_SLOTS - 3;

    /// Returns the cell of a variable. With `shared`, other processes can map its values, unless they are
    /// small.
    pub(crate) fn new(declaration: &Declaration, shared: bool) -> std::io::Result<Self> {
        let bytes = declaration.value_type.bytes;
        match declaration.access {
            Access::Export if bytes <= MOST_COPIED => {
                let words = bytes.div_ceil(8);
                let mut initial = Aligned::new(bytes);
                if let Some(value) = &declaration.initial {
                    initial.bytes_mut(bytes).copy_from_slice(value);
                }
                Ok(Self::Ring(Ring::new(words, RING_SLOTS, initial.words(words))))
            }
            Access::Export | Access::Modulation | Access::Command { .. } => {
                // One spare of each: a claim for values of the host, a pin for all readers beyond the
                // declared number.
                let (claims, pins) = (declaration.writers + 1, declaration.readers + 1);
                let mut pinned = if shared {
                    Pinned::in_file(bytes, declaration.writers, claims, pins)?
                } else {
                    Pinned::new(bytes, declaration.writers, claims, pins)
                };
                if let Some(value) = &declaration.initial {
                    pinned.set_initial(value);
                }
                Ok(Self::Pinned(pinned))
            }
        }
    }

    /// Returns a glance that never recognises a value as the newest.
    pub(crate) fn blind(&self) -> Glance {
        match self {
            Self::Ring(ring) => ring.blind(),
            Self::Pinned(pinned) => pinned.blind(),
        }
    }

    /// Returns the number and the stamp of the newest value.
    pub(crate) fn newest(&self) -> Mark {
        match self {
            Self::Ring(ring) => ring.mark(),
            Self::Pinned(pinned) => pinned.newest(),
        }
    }
}

impl From<Mark> for Stamp {
    #[inline]
    fn from(mark: Mark) -> Self {
        Self {
            time: mark.time,
            sequence: mark.sequence,
            writer: mark.writer,
            valid_until: mark.valid_until,
        }
    }
}
