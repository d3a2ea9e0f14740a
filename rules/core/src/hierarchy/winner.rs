//! The winner of a group, and the handover away from it (R1).
//!
//! It refuses to end a handover: that depends on the schemas below.

use crate::spec::{Nanos, SchemaId};

/// The member whose state is WINNER.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Winner {
    pub(super) id: SchemaId,
    /// The selection that promoted it, until it begins an iteration.
    pub(super) takeover: Option<Origin>,
    pub(super) handover: Option<Handover>,
}

/// A handover under way in a group, away from its winner.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Handover {
    /// The next choice; `None` if no member is to win.
    pub to: Option<SchemaId>,
    /// When the handover was first decided.
    pub since: Nanos,
    /// When patience ends. It does not change when the target changes.
    pub deadline: Nanos,
    /// The record that chose the target.
    pub record: u64,
    /// When the situation that led to that record began.
    pub cause_time: Nanos,
}

/// The selection that a promotion carries out.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Origin {
    pub(super) record: u64,
    pub(super) cause_time: Nanos,
}

/// What a choice requires of the schemas of a group.
pub(super) enum ChoiceStep {
    /// There is no winner: the choice is promoted at once.
    Promote,
    /// The present winner, or the handover under way, is carried on.
    Continue,
    /// The winner is chosen again, and its handover is dropped.
    Resume(SchemaId),
    /// A handover begins. Its patience ends at this time.
    HandOver(Nanos),
}

impl Handover {
    pub(super) fn origin(self) -> Origin {
        Origin {
            record: self.record,
            cause_time: self.cause_time,
        }
    }
}

impl Winner {
    pub(super) fn new(id: SchemaId, origin: Origin) -> Self {
        Self {
            id,
            takeover: Some(origin),
            handover: None,
        }
    }

    /// Returns the choice of the group: the target of a handover, else the winner.
    pub(super) fn choice(&self) -> Option<SchemaId> {
        self.handover.map_or(Some(self.id), |handover| handover.to)
    }

    /// Directs the group to a choice that may differ from the current one.
    pub(super) fn turn_to(
        &mut self,
        now: Nanos,
        to: Option<SchemaId>,
        origin: Origin,
        patience: Nanos,
    ) -> ChoiceStep {
        let is_same = to == Some(self.id);
        match &mut self.handover {
            None if is_same => ChoiceStep::Continue,
            None => {
                let deadline = now.saturating_add(patience);
                self.handover = Some(Handover {
                    to,
                    since: now,
                    deadline,
                    record: origin.record,
                    cause_time: origin.cause_time,
                });
                ChoiceStep::HandOver(deadline)
            }
            Some(_) if is_same => ChoiceStep::Resume(self.id),
            Some(handover) => {
                if handover.to != to {
                    handover.to = to;
                    handover.record = origin.record;
                    handover.cause_time = origin.cause_time;
                }
                ChoiceStep::Continue
            }
        }
    }
}
