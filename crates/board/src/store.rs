//! Which kind of cell a variable gets, and what its cell says of the newest value.

use crate::cell::{Aligned, Glance, Mark, Pinned, Ring};
use crate::{Access, Declaration, Stamp};

/// Largest value that readers copy rather than borrow, bytes: two cache lines.
const MOST_COPIED: usize = 128;
/// Slots of a small value's ring: a reader tries again only when three values are published while it copies one.
const RING_SLOTS: u64 = 4;

/// The cell of a variable.
pub(crate) enum Cell {
    Ring(Ring),
    Pinned(Pinned),
}

impl Cell {
    /// Most writers and readers together, beside the two of [`Cell::new`] and the newest value.
    pub(crate) const MOST_USERS: usize = Pinned::MOST_SLOTS - 3;

    /// One whose values other processes can map, if they are borrowed rather than copied and `shared` says so.
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
                // One more of each: for what the host puts, and for all readers beyond the declared number.
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

    /// What never tells that a value is the newest.
    pub(crate) fn blind(&self) -> Glance {
        match self {
            Self::Ring(ring) => ring.blind(),
            Self::Pinned(pinned) => pinned.blind(),
        }
    }

    /// Number and stamp of the newest value.
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
