//! The winner of a group: promotion, demotion, and the state of the actuators without a winner (R9).
//!
//! It refuses to choose; it only carries out a choice.

use super::Hierarchy;
use super::nodes::{Group, Origin};
use super::timer::Timer;
use crate::effect::Effect;
use crate::spec::{Absence, GroupId, Nanos, SchemaId};
use crate::state::{ActuationState, State};

impl Hierarchy {
    /// Promotes the choice in a group without a winner, or applies the absence policy.
    pub(super) fn set_winner(
        &mut self,
        id: GroupId,
        now: Nanos,
        to: Option<SchemaId>,
        origin: Origin,
        out: &mut Vec<Effect>,
    ) {
        match to {
            Some(to) => self.promote(id, to, origin, out),
            None => self.apply_absence(id, now, out),
        }
    }

    fn promote(&mut self, id: GroupId, to: SchemaId, origin: Origin, out: &mut Vec<Effect>) {
        let group = self.group_mut(id);
        group.winner = Some(to);
        group.takeover = Some(origin);
        group.actuation = ActuationState::Commanding;
        self.disarm(Timer::Hold(id));
        self.change(to, State::Winner, out);
        if self
            .plan
            .group(id)
            .father
            .is_none_or(|father| self.node(father).authority)
        {
            self.grant(to, out);
        }
        out.push(Effect::Promoted(to));
    }

    /// Applies the absence policy when no member wins: brakes or holds, once per absence (R9).
    pub(super) fn apply_absence(&mut self, id: GroupId, now: Nanos, out: &mut Vec<Effect>) {
        let hold_end = match self.plan.group(id).absence {
            Absence::Hold { for_ } if for_ > 0 => Some(now.saturating_add(for_)),
            Absence::Hold { .. } | Absence::Brake | Absence::Fallback(_) => None,
        };
        match (self.group(id).actuation, hold_end) {
            (ActuationState::Holding | ActuationState::Braked, _) => {}
            (ActuationState::Commanding, Some(until)) => {
                self.group_mut(id).actuation = ActuationState::Holding;
                self.arm(Timer::Hold(id), until);
                out.push(Effect::Hold { group: id, until });
            }
            // A fresh group has given no command that could be held.
            (ActuationState::Commanding, None) | (ActuationState::Fresh, _) => self.brake(id, out),
        }
    }

    /// Demotes a loser whose subtree sleeps. The loser sleeps too if it should no longer be awake.
    pub(super) fn demote(&mut self, loser: SchemaId, out: &mut Vec<Effect>) {
        if !self.node(loser).should_be_awake() {
            self.put_to_sleep(loser, out);
            return;
        }
        self.withdraw(loser, out);
        if let Some(group) = self.plan.group_of(loser) {
            self.group_mut(group).winner = None;
            self.group_mut(group).takeover = None;
        }
        out.push(Effect::Demoted(loser));
        let to = if self.node(loser).ready {
            State::Ready
        } else {
            State::Checking
        };
        self.change(loser, to, out);
    }

    /// Resets the memory of a group when its father's subtree sleeps. A force by an operator remains.
    pub(super) fn reset(&mut self, id: GroupId) {
        let forced = self.group(id).forced;
        self.disarm(Timer::Hold(id));
        *self.group_mut(id) = Group {
            forced,
            ..Group::default()
        };
    }

    /// Brakes, unless the group has braked already.
    pub(super) fn brake(&mut self, id: GroupId, out: &mut Vec<Effect>) {
        self.disarm(Timer::Hold(id));
        if std::mem::replace(&mut self.group_mut(id).actuation, ActuationState::Braked)
            != ActuationState::Braked
        {
            out.push(Effect::Brake { group: id });
        }
    }
}
