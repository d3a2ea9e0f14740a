//! Writing a variable: loan room, fill it, publish. It refuses to decide: the variable has the grants and the
//! checks.

#![allow(unsafe_code, reason = "a claimed slot is written in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Claim};
use crate::store::Cell;
use crate::{Error, Nanos, Refused, Variable};

/// Writes a variable. Its methods never block. A drop frees the place for another writer.
pub struct Writer {
    variable: Arc<Variable>,
    id: u32,
    seat: usize,
    room: Room,
}

/// Loaned room that its writer has set aside. A call that still has it may go on writing there without
/// effect. A drop gives it back.
#[must_use = "dropped, the room is given to others"]
pub struct Parted {
    variable: Arc<Variable>,
    room: Room,
    /// A reader's ticket, for the slot of the cell that it occupies.
    ticket: Option<usize>,
}

/// Where the next value is written.
enum Room {
    /// For small values: outside the cell.
    Beside { bytes: Aligned, loaned: bool },
    /// For other values: in a slot of the cell.
    Within { claim: Option<Claim> },
}

impl Writer {
    pub(crate) fn new(variable: Arc<Variable>, id: u32, seat: usize) -> Self {
        Self {
            room: Room::new(&variable),
            variable,
            id,
            seat,
        }
    }

    /// Returns the variable that it writes.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// Returns its id in stamps and grants.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Returns room for the next value, on a 64-byte boundary, with arbitrary contents. It is the same room
    /// until a publish or a discard.
    pub fn loan(&mut self) -> &mut [u8] {
        match (&mut self.room, &self.variable.cell) {
            (Room::Within { claim }, Cell::Pinned(pinned)) => {
                let claim = claim.get_or_insert_with(|| pinned.claim());
                // SAFETY: claimed from this cell; `&mut self` allows no second slice.
                unsafe { pinned.bytes_mut(claim) }
            }
            (Room::Beside { bytes, loaned }, Cell::Ring(_)) => {
                *loaned = true;
                bytes.bytes_mut(self.variable.bytes())
            }
            (Room::Within { .. }, Cell::Ring(_)) | (Room::Beside { .. }, Cell::Pinned(_)) => {
                unreachable!("a writer's room is made for its variable's cell")
            }
        }
    }

    /// Returns whether room is loaned.
    #[must_use]
    pub fn is_lent(&self) -> bool {
        self.room.is_lent()
    }

    /// Publishes the loaned value and returns its number. `time` is when it was measured; a time after `now`
    /// counts as `now`. A command is in force from `now` for its validity. Afterwards nothing is loaned, even
    /// after an error.
    ///
    /// # Errors
    /// [`Refused::NoAuthority`], [`Refused::NotFinite`], [`Refused::OutOfRange`], [`Refused::NothingLoaned`].
    pub fn publish(&mut self, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        self.publish_for(time, now, 0)
    }

    /// Publishes as [`Self::publish`] does. A command is in force for `least` nanoseconds if that is longer
    /// than its validity, for writers with a longer period.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn publish_for(&mut self, time: Nanos, now: Nanos, least: Nanos) -> Result<u64, Refused> {
        // A future time would make the value look new until then, and no older than later values.
        let time = time.min(now);
        let variable = &*self.variable;
        let published = match (&mut self.room, &variable.cell) {
            (Room::Within { claim }, Cell::Pinned(pinned)) => {
                let mut claim = claim.take().ok_or(Refused::NothingLoaned)?;
                // SAFETY: claimed from this cell; the slice ends with the check.
                if let Err(refused) = variable.check(unsafe { pinned.bytes_mut(&mut claim) }) {
                    pinned.abandon(claim);
                    return Err(refused);
                }
                pinned
                    .publish(
                        claim,
                        variable.gate(self.seat),
                        time,
                        self.id,
                        variable.valid_until(now, least),
                    )
                    .map_err(|_| Refused::NoAuthority)
            }
            (Room::Beside { bytes, loaned }, Cell::Ring(ring)) => {
                if !std::mem::take(loaned) {
                    return Err(Refused::NothingLoaned);
                }
                let words = bytes.words(variable.bytes().div_ceil(8));
                Ok(ring.publish(words, time, self.id))
            }
            (Room::Within { .. }, Cell::Ring(_)) | (Room::Beside { .. }, Cell::Pinned(_)) => {
                unreachable!("a writer's room is made for its variable's cell")
            }
        };
        variable.settle(published, time)
    }

    /// Retracts the newest value of an export, see [`Variable::retract`].
    pub fn retract(&mut self) {
        self.variable.retract();
    }

    /// Sets the loaned room aside, if there is any, so that the next loan is other room. This is for a loan
    /// to an abandoned call, which may still write there at any time. A slot of the cell then counts as one
    /// that a reader holds.
    ///
    /// # Errors
    /// [`Error::Crowded`] if readers hold all the slots that they may hold. Nothing changes then.
    pub fn part(&mut self) -> Result<Option<Parted>, Error> {
        if !self.room.is_lent() {
            return Ok(None);
        }
        let ticket = match &self.room {
            Room::Beside { .. } => None,
            Room::Within { .. } => Some(self.variable.open_slot()?),
        };
        let fresh = Room::new(&self.variable);
        Ok(Some(Parted {
            variable: self.variable.clone(),
            room: std::mem::replace(&mut self.room, fresh),
            ticket,
        }))
    }

    /// Gives back the loaned room without publishing.
    pub fn discard(&mut self) {
        self.room.discard(&self.variable);
    }
}

impl Parted {
    /// Returns the size of a value in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.variable.bytes()
    }
}

impl Room {
    fn new(variable: &Variable) -> Self {
        match &variable.cell {
            Cell::Ring(_) => Self::Beside {
                bytes: Aligned::new(variable.bytes()),
                loaned: false,
            },
            Cell::Pinned(_) => Self::Within { claim: None },
        }
    }

    fn is_lent(&self) -> bool {
        match self {
            Self::Beside { loaned, .. } => *loaned,
            Self::Within { claim } => claim.is_some(),
        }
    }

    fn discard(&mut self, variable: &Variable) {
        match self {
            Self::Beside { loaned, .. } => *loaned = false,
            Self::Within { claim } => {
                if let (Some(claim), Cell::Pinned(pinned)) = (claim.take(), &variable.cell) {
                    pinned.abandon(claim);
                }
            }
        }
    }
}

impl Drop for Parted {
    fn drop(&mut self) {
        self.room.discard(&self.variable);
        if let Some(ticket) = self.ticket {
            self.variable.close_reader(ticket);
        }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.discard();
        self.variable.close_writer(self.seat);
    }
}
