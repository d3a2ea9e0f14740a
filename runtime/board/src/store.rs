//! The choice of a variable's cell, and what both kinds of cell have in common.

use crate::cell::{Aligned, Pinned, Ring, SlotStamp, VersionCheck};
use crate::{Access, Declaration, Stamp};

/// Largest value that readers copy and do not borrow, in bytes: two cache lines.
const MAX_COPIED: usize = 128;
/// Slots of a small value's ring. A reader retries only if three values are published during one copy.
const RING_SLOTS: u64 = 4;

/// The cell of a variable.
pub(crate) enum Cell {
    Ring(Ring),
    Pinned(Pinned),
}

impl Cell {
    /// The maximum number of writers and readers together, without the two spare slots of [`Cell::new`] and
    /// that of the newest value.
    pub(crate) const MAX_USERS: usize = Pinned::MAX_SLOTS - 3;

    /// Returns the cell of a variable. With `shared`, other processes can map its values, unless they are
    /// small.
    pub(crate) fn new(declaration: &Declaration, shared: bool) -> std::io::Result<Self> {
        let bytes = declaration.value_type.bytes;
        match declaration.access {
            Access::Export { .. } if bytes <= MAX_COPIED => {
                let words = bytes.div_ceil(8);
                let mut initial = Aligned::new(bytes);
                if let Some(value) = &declaration.initial {
                    initial.bytes_mut(bytes).copy_from_slice(value);
                }
                Ok(Self::Ring(Ring::new(words, RING_SLOTS, initial.words(words))))
            }
            Access::Export { .. } | Access::Modulation | Access::Command { .. } => {
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

    /// Returns a check that never recognises a value as the newest.
    pub(crate) fn never_matching(&self) -> VersionCheck {
        match self {
            Self::Ring(ring) => ring.never_matching(),
            Self::Pinned(pinned) => pinned.never_matching(),
        }
    }

    /// Returns the number and the stamp of the newest value.
    pub(crate) fn newest(&self) -> SlotStamp {
        match self {
            Self::Ring(ring) => ring.stamp(),
            Self::Pinned(pinned) => pinned.newest(),
        }
    }
}

impl From<SlotStamp> for Stamp {
    #[inline]
    fn from(stamp: SlotStamp) -> Self {
        Self {
            time: stamp.time,
            sequence: stamp.sequence,
            writer: stamp.writer,
            valid_until: stamp.valid_until,
        }
    }
}
