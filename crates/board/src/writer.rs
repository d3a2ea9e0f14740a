//! Writing a variable: loan room, fill it, publish. Decides nothing: grants and checks are the variable's.

#![allow(unsafe_code, reason = "a claimed slot is written in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Claim};
use crate::store::Cell;
use crate::{Nanos, Refused, Variable};

/// Writes a variable. Its methods never block. Dropped, it makes room for another writer.
pub struct Writer {
    variable: Arc<Variable>,
    id: u32,
    seat: usize,
    room: Room,
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
        let room = match &variable.cell {
            Cell::Ring(_) => Room::Beside {
                bytes: Aligned::new(variable.bytes()),
                loaned: false,
            },
            Cell::Pinned(_) => Room::Within { claim: None },
        };
        Self {
            variable,
            id,
            seat,
            room,
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

    /// Publishes what was loaned, as measured at `time`, and answers its number. A command is in force from `now` for its
    /// validity. Afterwards nothing is loaned, whatever the answer.
    ///
    /// # Errors
    /// [`Refused::NoAuthority`], [`Refused::NotFinite`], [`Refused::NothingLoaned`].
    pub fn publish(&mut self, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        self.publish_for(time, now, 0)
    }

    /// As [`Self::publish`]; a command is in force for `least`, ns, if that is longer than its validity: for writers whose
    /// own rhythm is slower.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn publish_for(&mut self, time: Nanos, now: Nanos, least: Nanos) -> Result<u64, Refused> {
        let variable = &*self.variable;
        let published = match (&mut self.room, &variable.cell) {
            (Room::Within { claim }, Cell::Pinned(pinned)) => {
                let mut claim = claim.take().ok_or(Refused::NothingLoaned)?;
                // SAFETY: claimed from this cell; the slice ends with the check.
                if let Err(refused) = variable.check_finite(unsafe { pinned.bytes_mut(&mut claim) }) {
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

    /// Gives back what was loaned, unpublished.
    pub fn discard(&mut self) {
        match &mut self.room {
            Room::Beside { loaned, .. } => *loaned = false,
            Room::Within { claim } => {
                if let (Some(claim), Cell::Pinned(pinned)) = (claim.take(), &self.variable.cell) {
                    pinned.abandon(claim);
                }
            }
        }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.discard();
        self.variable.close_writer(self.seat);
    }
}
