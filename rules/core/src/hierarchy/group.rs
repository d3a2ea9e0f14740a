//! One group at run time: its winner, the handover away from it, the open request to the father and the
//! actuators, with every transition.
//!
//! It knows no schema's facts, and refuses to choose.

use super::candidates::CandidateList;
use super::winner::{ChoiceStep, Handover, Origin, Winner};
use crate::policy::PolicyInput;
use crate::record::{Case, Cause};
use crate::spec::{Nanos, SchemaId};
use crate::state::{ActuationState, Holder};

/// The changing facts of one group.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Group {
    winner: Option<Winner>,
    pending: Option<PendingArbitration>,
    actuation: ActuationState,
    /// When the current choice was made.
    since: Nanos,
    /// The last member that was chosen, for round robin.
    last: Option<SchemaId>,
    /// The forces of operators, oldest first; at most one of each holder.
    forces: Vec<(Holder, SchemaId)>,
    /// The choice that an event has ended since the last record.
    lost: Option<SchemaId>,
}

/// The cause of a selection, and when that situation began.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct TimedCause {
    pub(super) cause: Cause,
    /// When the situation began.
    pub(super) time: Nanos,
}

/// An open arbitration request to the father.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct PendingArbitration {
    pub(super) ticket: u64,
    pub(super) case: Case,
    /// The members that the father may choose.
    pub(super) candidates: Vec<SchemaId>,
    pub(super) trigger: TimedCause,
    /// The first trigger after the request.
    pub(super) retrigger: Option<TimedCause>,
    /// Whether the machine and not the father causes a missing reply.
    pub(super) excused: bool,
}

impl TimedCause {
    pub(super) const fn new(cause: Cause, time: Nanos) -> Self {
        Self { cause, time }
    }
}

impl Group {
    /// A group below a father that sleeps; also what an unknown identifier reads as.
    pub(super) const FRESH: Self = Self {
        winner: None,
        pending: None,
        actuation: ActuationState::Fresh,
        since: 0,
        last: None,
        forces: Vec::new(),
        lost: None,
    };

    pub(super) fn winner(&self) -> Option<SchemaId> {
        self.winner.as_ref().map(|winner| winner.id)
    }

    pub(super) fn handover(&self) -> Option<Handover> {
        self.winner.as_ref()?.handover
    }

    /// Whether this member is the winner and has not begun an iteration.
    pub(super) fn is_taking(&self, id: SchemaId) -> bool {
        let taking = |winner: &Winner| winner.id == id && winner.takeover.is_some();
        self.winner.as_ref().is_some_and(taking)
    }

    pub(super) fn actuation(&self) -> ActuationState {
        self.actuation
    }

    /// Returns the forces of operators, newest first.
    pub(super) fn forces(&self) -> impl Iterator<Item = (Holder, SchemaId)> {
        self.forces.iter().rev().copied()
    }

    pub(super) fn pending(&self) -> Option<&PendingArbitration> {
        self.pending.as_ref()
    }

    /// Returns the current choice: the target of a handover, else the winner.
    pub(super) fn choice(&self) -> Option<SchemaId> {
        self.winner.as_ref()?.choice()
    }

    pub(super) fn policy_input<'a>(
        &self,
        now: Nanos,
        members: &'a [SchemaId],
        list: &'a CandidateList,
    ) -> PolicyInput<'a> {
        PolicyInput {
            candidates: &list.candidates,
            first: list.first,
            members,
            chosen: self.choice(),
            since: self.since,
            last: self.last,
            now,
        }
    }

    /// Records the choice `before` an event if the event ended it, for the next record (R15).
    pub(super) fn lose(&mut self, before: Option<SchemaId>) {
        if self.choice() != before {
            self.lost = before;
        }
    }

    /// Records a choice for the policy and returns the one before (R15).
    pub(super) fn choose(&mut self, now: Nanos, choice: Option<SchemaId>) -> Option<SchemaId> {
        let before = self.lost.take().or_else(|| self.choice());
        if before != choice && choice.is_some() {
            self.since = now;
            self.last = choice;
        }
        before
    }

    /// Directs the group to a choice that may differ from the current one.
    pub(super) fn turn_to(
        &mut self,
        now: Nanos,
        to: Option<SchemaId>,
        origin: Origin,
        patience: Nanos,
    ) -> ChoiceStep {
        match &mut self.winner {
            Some(winner) => winner.turn_to(now, to, origin, patience),
            None => ChoiceStep::Promote,
        }
    }

    pub(super) fn drop_handover(&mut self) -> Option<Handover> {
        self.winner.as_mut()?.handover.take()
    }

    pub(super) fn promote(&mut self, id: SchemaId, origin: Origin) {
        self.winner = Some(Winner::new(id, origin));
        self.actuation = ActuationState::Commanding;
    }

    /// Records that the winner begins an iteration. Returns its selection if this is the first.
    pub(super) fn take_over(&mut self) -> Option<Origin> {
        self.winner.as_mut()?.takeover.take()
    }

    /// Removes a member that no longer wins or competes. Returns the handover away from it.
    pub(super) fn remove(&mut self, id: SchemaId) -> Option<Handover> {
        let winner = self.winner.as_mut()?;
        if winner.id == id {
            return self.winner.take()?.handover;
        }
        if let Some(handover) = &mut winner.handover {
            handover.to.take_if(|to| *to == id);
        }
        None
    }

    /// Forgets everything when the father's subtree sleeps. A force by an operator remains.
    pub(super) fn reset(&mut self) {
        *self = Self {
            forces: std::mem::take(&mut self.forces),
            ..Self::FRESH
        };
    }

    /// Holds the last command or brakes, once per absence (R9). Returns the new state of the actuators, if it
    /// changed. A fresh group has given no command that could be held.
    pub(super) fn lack_winner(&mut self, is_held: bool) -> Option<ActuationState> {
        let to = match self.actuation {
            ActuationState::Holding | ActuationState::Braked => return None,
            ActuationState::Commanding if is_held => ActuationState::Holding,
            ActuationState::Commanding | ActuationState::Fresh => ActuationState::Braked,
        };
        self.actuation = to;
        Some(to)
    }

    /// Brakes; returns false if it has braked already.
    pub(super) fn brake(&mut self) -> bool {
        std::mem::replace(&mut self.actuation, ActuationState::Braked) != ActuationState::Braked
    }

    pub(super) fn open_arbitration(&mut self, pending: PendingArbitration) {
        self.pending = Some(pending);
    }

    pub(super) fn close_arbitration(&mut self) -> Option<PendingArbitration> {
        self.pending.take()
    }

    /// Keeps the trigger for after the open request; returns false if none is open.
    pub(super) fn postpone(&mut self, trigger: TimedCause) -> bool {
        let pending = self.pending.as_mut();
        pending
            .map(|open| open.retrigger.get_or_insert(trigger))
            .is_some()
    }

    pub(super) fn excuse(&mut self) {
        if let Some(pending) = &mut self.pending {
            pending.excused = true;
        }
    }

    /// Adds a force, in place of an earlier one of the same holder.
    pub(super) fn force(&mut self, by: Holder, id: SchemaId) {
        self.forces.retain(|(holder, _)| *holder != by);
        self.forces.push((by, id));
    }

    /// Ends forces; returns whether there were any.
    pub(super) fn end_forces(&mut self, which: impl Fn(Holder, SchemaId) -> bool) -> bool {
        let before = self.forces.len();
        self.forces.retain(|(by, id)| !which(*by, *id));
        self.forces.len() < before
    }
}
