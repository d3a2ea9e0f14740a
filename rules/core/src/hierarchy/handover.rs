//! The handover from a loser to the next choice (R1, R5). The loser keeps WINNER and its authority until its
//! iteration has ended and its subtree sleeps, or until patience ends.
//!
//! During a handover it refuses to begin, wake or select anything in the loser's subtree.

use std::sync::Arc;

use super::Hierarchy;
use super::group::TimedCause;
use super::sleep::SleepMode;
use super::timer::Timer;
use super::transaction::Transaction;
use super::winner::{ChoiceStep, Handover, Origin};
use crate::record::Cause;
use crate::spec::{GroupId, SchemaId};

impl Hierarchy {
    /// Returns the group whose winner is being replaced, if that winner is this schema or a schema above it.
    pub(super) fn handover_above(&self, id: SchemaId) -> Option<GroupId> {
        let mut next = Some(id);
        while let Some(current) = next {
            let group = self.plan.group_of(current)?;
            if self.group(group).handover().is_some() && self.group(group).winner() == Some(current) {
                return Some(group);
            }
            next = self.plan.group(group).father;
        }
        None
    }

    /// Whether the father of a group, or a schema above it, is being replaced.
    pub(super) fn is_frozen(&self, group: GroupId) -> bool {
        self.plan
            .group(group)
            .father
            .is_some_and(|father| self.handover_above(father).is_some())
    }
}

impl Transaction<'_> {
    /// Carries out a choice that may differ from the current one.
    pub(super) fn apply_choice(
        &mut self,
        id: GroupId,
        to: Option<SchemaId>,
        origin: Origin,
        trigger: TimedCause,
    ) {
        let patience = self.plan.group(id).patience;
        match self
            .hierarchy
            .group_mut(id)
            .turn_to(self.now, to, origin, patience)
        {
            ChoiceStep::Promote => self.set_winner(id, to, origin),
            ChoiceStep::Continue => {}
            ChoiceStep::Resume(winner) => {
                self.drop_handover(id);
                self.resume_subtree(winner, trigger);
            }
            ChoiceStep::HandOver(deadline) => {
                self.timers.arm(Timer::Patience(id), deadline);
                self.advance(id);
            }
        }
    }

    /// Puts the schemas below the loser to sleep as far as possible, and completes the handover once all
    /// sleep.
    pub(super) fn advance(&mut self, id: GroupId) {
        let (Some(loser), Some(handover)) = (self.group(id).winner(), self.group(id).handover()) else {
            return;
        };
        let subtree_asleep = self.drain(loser, SleepMode::BetweenIterations);
        if subtree_asleep && !self.node(loser).is_running() {
            self.complete(id);
        } else if handover.deadline <= self.now {
            self.expire(id);
        }
    }

    /// Ends patience: the loser and everything below it lose their authority at once, even inside an
    /// iteration.
    pub(super) fn expire(&mut self, id: GroupId) {
        let Some(loser) = self.group(id).winner() else {
            return;
        };
        self.withdraw(loser);
        self.drain(loser, SleepMode::AtOnce);
        let is_changed = self.node_mut(loser).abandon();
        self.complete(id);
        if is_changed {
            let cause = Cause::Timer(Timer::Patience(id));
            self.select(id, TimedCause::new(cause, self.now));
        }
    }

    pub(super) fn drop_handover(&mut self, group: GroupId) -> Option<Handover> {
        let handover = self.group_mut(group).drop_handover();
        if handover.is_some() {
            self.timers.disarm(Timer::Patience(group));
        }
        handover
    }

    fn complete(&mut self, id: GroupId) {
        let (Some(loser), Some(handover)) = (self.group(id).winner(), self.drop_handover(id)) else {
            return;
        };
        self.demote(loser);
        self.set_winner(id, handover.to, handover.origin());
    }

    /// Lets the awake part of the subtree of a loser that is chosen again compete again.
    fn resume_subtree(&mut self, id: SchemaId, trigger: TimedCause) {
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if self.is_live(group) {
                self.select(group, trigger);
            } else {
                // Its members fell asleep with the loser's handover, and their last commands are still in
                // force.
                self.apply_absence(group);
            }
            for &member in plan.members(group) {
                self.resume_subtree(member, trigger);
            }
        }
    }
}
