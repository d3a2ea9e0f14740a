//! Going to sleep (R5, R6, R10): children before fathers, between iterations where time allows, and
//! perceptive schemas once they have no requester.
//!
//! It refuses to decide about winners: the caller that removes a winner selects afterwards.

use std::sync::Arc;

use super::timer::Timer;
use super::transaction::Transaction;
use crate::effect::Effect;
use crate::spec::{GroupId, Kind, SchemaId};
use crate::state::{Requester, State};

/// When a schema inside an iteration goes to sleep.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(super) enum SleepMode {
    /// When the iteration has ended.
    BetweenIterations,
    /// Now; the iteration is abandoned.
    AtOnce,
}

impl Transaction<'_> {
    /// Puts the subtree of a schema to sleep, without the schema itself, as far as the mode allows. Returns
    /// true if nothing below it is awake.
    pub(super) fn drain(&mut self, id: SchemaId, mode: SleepMode) -> bool {
        let plan = Arc::clone(&self.plan);
        let mut all_asleep = true;
        for &group in plan.groups_under(id) {
            all_asleep &= self.sleep_group(group, mode);
        }
        all_asleep
    }

    /// Puts the members of a group to sleep with everything below them, as far as the mode allows. Returns
    /// true if none is awake. The requests of fathers and operators for the members that sleep are removed.
    pub(super) fn sleep_group(&mut self, group: GroupId, mode: SleepMode) -> bool {
        let plan = Arc::clone(&self.plan);
        self.drop_handover(group);
        self.cancel_arbitration(group);
        self.timers.disarm(Timer::Turn(group));
        let mut all_asleep = true;
        for &member in plan.members(group) {
            let subtree_asleep = self.drain(member, mode);
            if self.is_awake(member) {
                let may_sleep =
                    mode == SleepMode::AtOnce || (subtree_asleep && !self.node(member).is_iterating());
                if !may_sleep {
                    all_asleep = false;
                    continue;
                }
                self.put_to_sleep(member);
            }
            self.node_mut(member).release_by_all();
            all_asleep &= subtree_asleep;
        }
        if all_asleep {
            self.reset(group);
        }
        all_asleep
    }

    /// Puts one awake schema to sleep at once. Its subtree must sleep already. Its requesters remain.
    pub(super) fn put_to_sleep(&mut self, id: SchemaId) {
        self.withdraw(id);
        if let Some(group) = self.plan.group_of(id)
            && self.group_mut(group).remove(id).is_some()
        {
            self.timers.disarm(Timer::Patience(group));
        }
        let node = self.node_mut(id);
        let woken = node.prepare_sleep();
        let abandoned = node.is_abandoned();
        self.out.push(Effect::Slept { id, abandoned });
        self.change(id, State::Slept);
        let plan = Arc::clone(&self.plan);
        for &need in &plan.schema(id).needs {
            self.release(need, Requester::Need(id));
        }
        for perceptive in woken {
            self.release(perceptive, Requester::Father(id));
        }
    }

    /// Removes one requester; returns whether it was present. A perceptive schema that should no longer be
    /// awake sleeps when the transaction settles.
    pub(super) fn release(&mut self, id: SchemaId, requester: Requester) -> bool {
        if !self.node_mut(id).release(requester) {
            return false;
        }
        if self.plan.kind(id) == Kind::Perceptive && !self.node(id).should_be_awake() {
            self.unneeded.push(id);
        }
        true
    }

    /// Ends a transaction: perceptive schemas that should no longer be awake go to sleep, after the schemas
    /// that needed them.
    pub(super) fn settle(&mut self) {
        let mut next = 0;
        while let Some(&id) = self.unneeded.get(next) {
            next += 1;
            if !self.node(id).should_be_awake() && self.is_awake(id) {
                self.put_to_sleep(id);
            }
        }
        self.unneeded.clear();
    }
}
