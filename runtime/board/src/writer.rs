//! Writing a variable: loan a buffer, fill it, publish. The variable holds the grants and makes the checks.

#![allow(unsafe_code, reason = "a claimed slot is written in place")]

use std::sync::Arc;

use crate::cell::{Aligned, Claim};
use crate::store::Cell;
use crate::{Error, Nanos, Refused, Variable};

/// Writes a variable. Its methods never block. A drop allows another writer to open the variable.
pub struct Writer {
    variable: Arc<Variable>,
    id: u32,
    grant_index: usize,
    buffer: LoanBuffer,
}

/// A loaned buffer that its writer has set aside. A call that still has it may continue writing there without
/// effect. A drop returns it.
#[must_use = "if dropped, the buffer is reused"]
pub struct DetachedLoan {
    variable: Arc<Variable>,
    buffer: LoanBuffer,
    /// A reader's ticket, for the slot of the cell that it occupies.
    ticket: Option<usize>,
}

/// Where the next value is written.
enum LoanBuffer {
    /// For small values: outside the cell.
    Outside { bytes: Aligned, loaned: bool },
    /// For other values: in a slot of the cell.
    InSlot { claim: Option<Claim> },
}

impl Writer {
    pub(crate) fn new(variable: Arc<Variable>, id: u32, writer_index: usize) -> Self {
        Self {
            buffer: LoanBuffer::new(&variable),
            variable,
            id,
            grant_index: writer_index,
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

    /// Returns a buffer for the next value, on a 64-byte boundary, with arbitrary contents. It is the same
    /// buffer until a publish or a discard.
    pub fn loan(&mut self) -> &mut [u8] {
        match (&mut self.buffer, &self.variable.cell) {
            (LoanBuffer::InSlot { claim }, Cell::Pinned(pinned)) => {
                let claim = claim.get_or_insert_with(|| pinned.claim());
                // SAFETY: claimed from this cell; `&mut self` allows no second slice.
                unsafe { pinned.bytes_mut(claim) }
            }
            (LoanBuffer::Outside { bytes, loaned }, Cell::Ring(_)) => {
                *loaned = true;
                bytes.bytes_mut(self.variable.bytes())
            }
            (LoanBuffer::InSlot { .. }, Cell::Ring(_)) | (LoanBuffer::Outside { .. }, Cell::Pinned(_)) => {
                unreachable!("a writer's buffer is made for its variable's cell")
            }
        }
    }

    /// Returns a copy of the value in the loaned buffer.
    pub fn copy_loan(&mut self) -> Vec<u8> {
        let variable = Arc::clone(&self.variable);
        variable.describe().value_type.copy(self.loan())
    }

    /// Returns whether a buffer is loaned.
    #[must_use]
    pub fn is_loaned(&self) -> bool {
        self.buffer.is_loaned()
    }

    /// Publishes the loaned value and returns its number. `time` is when it was measured; a time after `now`
    /// counts as `now`. An export is valid and a command in force from `now` for its validity. Afterwards nothing is loaned, even
    /// after an error.
    ///
    /// # Errors
    /// [`Refused::NoAuthority`], [`Refused::NotFinite`], [`Refused::OutOfRange`], [`Refused::NothingLoaned`].
    pub fn publish(&mut self, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        self.publish_for(time, now, 0)
    }

    /// Publishes as [`Self::publish`] does. A command is in force for `least` nanoseconds if that is longer
    /// than its validity, for writers with a longer period. Exports have no such time.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn publish_for(&mut self, time: Nanos, now: Nanos, least: Nanos) -> Result<u64, Refused> {
        // A future time would make the value look new until then, and no older than later values.
        let time = time.min(now);
        let variable = &*self.variable;
        let published = match (&mut self.buffer, &variable.cell) {
            (LoanBuffer::InSlot { claim }, Cell::Pinned(pinned)) => {
                let mut claim = claim.take().ok_or(Refused::NothingLoaned)?;
                // SAFETY: claimed from this cell; the slice ends with the check.
                if let Err(refused) = variable.check(unsafe { pinned.bytes_mut(&mut claim) }) {
                    pinned.abandon(claim);
                    return Err(refused);
                }
                pinned
                    .publish(
                        claim,
                        variable.gate(self.grant_index),
                        time,
                        self.id,
                        variable.valid_until(now, least),
                    )
                    .map_err(|_| Refused::NoAuthority)
            }
            (LoanBuffer::Outside { bytes, loaned }, Cell::Ring(ring)) => {
                if !std::mem::take(loaned) {
                    return Err(Refused::NothingLoaned);
                }
                let words = bytes.words(variable.bytes().div_ceil(8));
                Ok(ring.publish(words, time, self.id, variable.valid_until(now, least)))
            }
            (LoanBuffer::InSlot { .. }, Cell::Ring(_)) | (LoanBuffer::Outside { .. }, Cell::Pinned(_)) => {
                unreachable!("a writer's buffer is made for its variable's cell")
            }
        };
        variable.finish_publish(published, time)
    }

    /// Retracts the newest value of an export, see [`Variable::retract`].
    pub fn retract(&mut self) {
        self.variable.retract();
    }

    /// Sets the loaned buffer aside, if there is one, so that the next loan is another buffer. This is for a
    /// loan to an abandoned call, which may still write there at any time. A slot of the cell then counts as
    /// one that a reader holds.
    ///
    /// # Errors
    /// [`Error::TooManyReaders`] if readers hold all the slots that they may hold; then nothing changes.
    pub fn detach_loan(&mut self) -> Result<Option<DetachedLoan>, Error> {
        if !self.buffer.is_loaned() {
            return Ok(None);
        }
        let ticket = match &self.buffer {
            LoanBuffer::Outside { .. } => None,
            LoanBuffer::InSlot { .. } => Some(self.variable.open_slot()?),
        };
        let fresh = LoanBuffer::new(&self.variable);
        Ok(Some(DetachedLoan {
            variable: self.variable.clone(),
            buffer: std::mem::replace(&mut self.buffer, fresh),
            ticket,
        }))
    }

    /// Returns the loaned buffer without publishing, and counts a refused value.
    pub fn refuse(&mut self) {
        self.discard();
        self.variable.count_refused();
    }

    /// Returns the loaned buffer without publishing.
    pub fn discard(&mut self) {
        self.buffer.discard(&self.variable);
    }
}

impl DetachedLoan {
    /// Returns the size of a value in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.variable.bytes()
    }
}

impl LoanBuffer {
    fn new(variable: &Variable) -> Self {
        match &variable.cell {
            Cell::Ring(_) => Self::Outside {
                bytes: Aligned::new(variable.bytes()),
                loaned: false,
            },
            Cell::Pinned(_) => Self::InSlot { claim: None },
        }
    }

    fn is_loaned(&self) -> bool {
        match self {
            Self::Outside { loaned, .. } => *loaned,
            Self::InSlot { claim } => claim.is_some(),
        }
    }

    fn discard(&mut self, variable: &Variable) {
        match self {
            Self::Outside { loaned, .. } => *loaned = false,
            Self::InSlot { claim } => {
                if let (Some(claim), Cell::Pinned(pinned)) = (claim.take(), &variable.cell) {
                    pinned.abandon(claim);
                }
            }
        }
    }
}

impl Drop for DetachedLoan {
    fn drop(&mut self) {
        self.buffer.discard(&self.variable);
        if let Some(ticket) = self.ticket {
            self.variable.close_reader(ticket);
        }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.discard();
        self.variable.close_writer(self.grant_index);
    }
}
