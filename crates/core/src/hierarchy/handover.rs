//! The handover from a loser to the next choice (R1, R5). The loser keeps WINNER and its authority until its
//! iteration has ended and its subtree sleeps, or until patience ends.
//!
//! During a handover it refuses to begin, wake or select anything in the loser's subtree.

use std::sync::Arc;

use super::Hierarchy;
use super::nodes::{Origin, RunState};
use super::selection::TimedCause;
use super::sleep::SleepMode;
use super::timer::Timer;
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::{GroupId, Nanos, SchemaId};

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

impl Hierarchy {
    /// Carries out a choice that may differ from the current one.
    pub(super) fn apply_choice(
        &mut self,
        now: Nanos,
        id: GroupId,
        to: Option<SchemaId>,
        origin: Origin,
        trigger: TimedCause,
        out: &mut Vec<Effect>,
    ) {
        let patience = self.plan.group(id).patience;
        let Origin { record, cause_time } = origin;
        let group = self.group_mut(id);
        match (group.winner, group.handover) {
            (None, _) => self.set_winner(id, now, to, origin, out),
            (Some(winner), None) if to == Some(winner) => {}
            (Some(winner), Some(_)) if to == Some(winner) => {
                self.drop_handover(id);
                self.resume_subtree(now, winner, trigger, out);
            }
            (Some(_), Some(handover)) if handover.to == to => {}
            (Some(_), Some(handover)) => {
                group.handover = Some(Handover {
                    to,
                    record,
                    cause_time,
                    ..handover
                });
            }
            (Some(_), None) => {
                let deadline = now.saturating_add(patience);
                group.handover = Some(Handover {
                    to,
                    since: now,
                    deadline,
                    record,
                    cause_time,
                });
                self.arm(Timer::Patience(id), deadline);
                self.advance(now, id, out);
            }
        }
    }

    /// Puts the schemas below the loser to sleep as far as possible, and completes the handover once all
    /// sleep.
    pub(super) fn advance(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        let (Some(loser), Some(handover)) = (self.group(id).winner, self.group(id).handover) else {
            return;
        };
        let subtree_asleep = self.drain(loser, SleepMode::BetweenIterations, out);
        if subtree_asleep && self.node(loser).run == RunState::Between {
            self.complete(now, id, out);
        } else if handover.deadline <= now {
            self.expire(now, id, out);
        }
    }

    /// Ends patience: the loser and everything below it lose their authority at once, even inside an
    /// iteration.
    pub(super) fn expire(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        let Some(loser) = self.group(id).winner else {
            return;
        };
        self.withdraw(loser, out);
        self.drain(loser, SleepMode::AtOnce, out);
        let node = self.node_mut(loser);
        let was_ready = node.ready;
        if node.run == RunState::Iterating {
            // It cannot check during the iteration, so its readiness is unknown.
            node.run = RunState::Abandoned;
            node.ready = false;
        }
        let is_changed = was_ready && !node.ready;
        self.complete(now, id, out);
        if is_changed {
            self.select(
                now,
                id,
                TimedCause::new(Cause::Timer(Timer::Patience(id)), now),
                out,
            );
        }
    }

    /// Returns the group whose winner is being replaced, if that winner is this schema or a schema above it.
    pub(super) fn handover_above(&self, id: SchemaId) -> Option<GroupId> {
        let mut next = Some(id);
        while let Some(current) = next {
            let group = self.plan.group_of(current)?;
            if self.group(group).handover.is_some() && self.group(group).winner == Some(current) {
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

    pub(super) fn drop_handover(&mut self, group: GroupId) -> Option<Handover> {
        let handover = self.group_mut(group).handover.take();
        if handover.is_some() {
            self.disarm(Timer::Patience(group));
        }
        handover
    }

    fn complete(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        let (Some(loser), Some(handover)) = (self.group(id).winner, self.drop_handover(id)) else {
            return;
        };
        self.demote(loser, out);
        let origin = Origin {
            record: handover.record,
            cause_time: handover.cause_time,
        };
        self.set_winner(id, now, handover.to, origin, out);
    }

    /// Lets the awake part of the subtree of a loser that is chosen again compete again.
    fn resume_subtree(&mut self, now: Nanos, id: SchemaId, trigger: TimedCause, out: &mut Vec<Effect>) {
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if self.is_live(group) {
                self.select(now, group, trigger, out);
            } else {
                // Its members fell asleep with the loser's handover, and their last commands are still in
                // force.
                self.apply_absence(group, now, out);
            }
            for &member in plan.members(group) {
                self.resume_subtree(now, member, trigger, out);
            }
        }
    }
}
