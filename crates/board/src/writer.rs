//! Writing a variable: loan room, fill it, publish. Decides nothing: grants and checks are the variable's.

#![allow(unsafe_code, reason = "a claimed slot is written in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Claim};
use crate::store::Cell;
use crate::{Error, Nanos, Refused, Variable};

/// Writes a variable. Its methods never block. Dropped, it makes room for another writer.
pub struct Writer {
    variable: Arc<Variable>,
    id: u32,
    seat: usize,
    room: Room,
}

/// Room that was loaned and is no longer its writer's: whoever got it may go on writing there, and nobody sees it. Dropped,
/// it is given back.
#[must_use = "dropped, the room is given to others"]
pub struct Parted {
    variable: Arc<Variable>,
    room: Room,
    /// A reader's, for the slot that it keeps from the cell's own.
    ticket: Option<usize>,
}

/// Where the next value is made.
enum Room {
    /// Small values: beside the cell.
    Beside { bytes: Aligned, loaned: bool },
    /// Others: in a slot of the cell.
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

    /// The variable it writes.
    #[must_use]
    pub fn variable(&self) -> &Arc<Variable> {
        &self.variable
    }

    /// Who it is, in stamps and grants.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Room for the next value, on a 64-byte boundary, holding arbitrary bytes. The same room until it is published or
    /// discarded.
    pub fn loan(&mut self) -> &mut [u8] {
        match (&mut self.room, &self.variable.cell) {
            (Room::Within { claim }, Cell::Pinned(pinned)) => {
                let claim = claim.get_or_insert_with(|| pinned.claim());
                // SAFETY: claimed from this cell; `&mut self` lends no second slice.
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

    /// Whether something is loaned.
    #[must_use]
    pub fn is_lent(&self) -> bool {
        self.room.is_lent()
    }

    /// Publishes what was loaned, as measured at `time`, or `now` if that is yet to come, and answers its number. A command is in force from `now` for its
    /// validity. Afterwards nothing is loaned, whatever the answer.
    ///
    /// # Errors
    /// [`Refused::NoAuthority`], [`Refused::NotFinite`], [`Refused::OutOfRange`], [`Refused::NothingLoaned`].
    pub fn publish(&mut self, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        self.publish_for(time, now, 0)
    }

    /// As [`Self::publish`]; a command is in force for `least`, ns, if that is longer than its validity: for writers whose
    /// own rhythm is slower.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn publish_for(&mut self, time: Nanos, now: Nanos, least: Nanos) -> Result<u64, Refused> {
        // Else it would look new for as long as it takes, and be no older than what comes after it.
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

    /// Takes back the newest value of an export, see [`Variable::retract`].
    pub fn retract(&mut self) {
        self.variable.retract();
    }

    /// Parts with what was loaned, if anything was, so that the next loan is other room: for a loan to somebody who may write
    /// there at any time, although it is given up. A slot of the cell then counts as one that a reader holds.
    ///
    /// # Errors
    /// [`Error::Crowded`] while all slots that readers may hold are taken; nothing has changed then.
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

    /// Gives back what was loaned, unpublished.
    pub fn discard(&mut self) {
        self.room.discard(&self.variable);
    }
}

impl Parted {
    /// Bytes of a value.
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
