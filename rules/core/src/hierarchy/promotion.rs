//! The winner of a group: promotion, demotion, and the state of the actuators without a winner (R9).
//!
//! It refuses to choose; it only carries out a choice.

use super::timer::Timer;
use super::transaction::Transaction;
use super::winner::Origin;
use crate::effect::Effect;
use crate::spec::{Absence, GroupId, SchemaId};
use crate::state::{ActuationState, State};

impl Transaction<'_> {
    /// Promotes the choice in a group without a winner, or applies the absence policy.
    pub(super) fn set_winner(&mut self, id: GroupId, to: Option<SchemaId>, origin: Origin) {
        match to {
            Some(to) => self.promote(id, to, origin),
            None => self.apply_absence(id),
        }
    }

    fn promote(&mut self, id: GroupId, to: SchemaId, origin: Origin) {
        self.group_mut(id).promote(to, origin);
        self.timers.disarm(Timer::Hold(id));
        self.change(to, State::Winner);
        if self
            .plan
            .group(id)
            .father
            .is_none_or(|father| self.node(father).delegates())
        {
            self.grant(to);
        }
        self.out.push(Effect::Promoted(to));
    }

    /// Applies the absence policy when no member wins: brakes or holds, once per absence (R9).
    pub(super) fn apply_absence(&mut self, id: GroupId) {
        let hold = match self.plan.group(id).absence {
            Absence::Hold { for_ } => for_,
            Absence::Brake | Absence::Fallback(_) => 0,
        };
        match self.group_mut(id).lack_winner(hold > 0) {
            Some(ActuationState::Holding) => {
                let until = self.now.saturating_add(hold);
                self.timers.arm(Timer::Hold(id), until);
                self.out.push(Effect::Hold { group: id, until });
            }
            Some(ActuationState::Braked) => self.out.push(Effect::Brake { group: id }),
            Some(ActuationState::Commanding | ActuationState::Fresh) | None => {}
        }
    }

    /// Demotes a loser whose subtree sleeps. The loser sleeps too if it should no longer be awake.
    pub(super) fn demote(&mut self, loser: SchemaId) {
        if !self.node(loser).should_be_awake() {
            self.put_to_sleep(loser);
            return;
        }
        self.withdraw(loser);
        if let Some(group) = self.plan.group_of(loser) {
            self.group_mut(group).remove(loser);
        }
        self.out.push(Effect::Demoted(loser));
        self.change(loser, self.node(loser).state_of_loser());
    }

    /// Resets the memory of a group when its father's subtree sleeps. A force by an operator remains.
    pub(super) fn reset(&mut self, id: GroupId) {
        self.timers.disarm(Timer::Hold(id));
        self.group_mut(id).reset();
    }

    /// Brakes, unless the group has braked already.
    pub(super) fn brake(&mut self, id: GroupId) {
        self.timers.disarm(Timer::Hold(id));
        if self.group_mut(id).brake() {
            self.out.push(Effect::Brake { group: id });
        }
    }
}
