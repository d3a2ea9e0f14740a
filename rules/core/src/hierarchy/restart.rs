//! Faults, health and restarts. A faulted schema affects no other, and its restart policy states when it may
//! run again.
//!
//! It refuses to decide what a fault is; the executor reports it.

use super::Phase;
use super::group::TimedCause;
use super::sleep::SleepMode;
use super::timer::Timer;
use super::transaction::Transaction;
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::SchemaId;
use crate::state::{Health, State};

impl Transaction<'_> {
    /// Reports that a schema panicked, returned an error, hung or died. It sleeps at once with its subtree,
    /// its level selects again, and its restart policy applies.
    ///
    /// A running iteration counts as abandoned until [`end`](Self::end) is called for it, even if the fault
    /// itself ended it: report the fault, then the end. A second report before the restart has no effect.
    pub fn faulted(&mut self, id: SchemaId, reason: String) {
        if !self.plan.contains(id) || self.node(id).is_faulted() {
            return;
        }
        self.set_health(id, Health::Faulted(reason));
        if self.phase != Phase::Running {
            return;
        }
        let policy = self.plan.schema(id).restart;
        if let Some(due) = self.hierarchy.restarts[id].due(policy, self.now) {
            self.timers.arm(Timer::Restart(id), due);
        }
        if self.is_awake(id) {
            self.fail_awake(id);
        }
        self.settle();
    }

    /// Reports that the code or the process of a schema was replaced, or that its fault counts as repaired.
    /// The fault and all restarts are cleared, and the schema wakes if it has a requester.
    pub fn restored(&mut self, id: SchemaId) {
        if self.plan.contains(id) {
            self.forget_faults(id);
            self.recover(id);
            self.settle();
        }
    }

    /// Reports a missed deadline.
    pub fn overrun(&mut self, id: SchemaId) {
        if *self.health(id) == Health::Ok {
            self.set_health(id, Health::Overrun);
        }
    }

    /// Reports that a schema meets its deadlines again.
    pub fn on_time(&mut self, id: SchemaId) {
        if *self.health(id) == Health::Overrun {
            self.set_health(id, Health::Ok);
        }
    }

    pub(super) fn restart(&mut self, id: SchemaId) {
        self.hierarchy.restarts[id].record(self.now);
        self.recover(id);
    }

    /// Clears the pending restart and the count of restarts.
    pub(super) fn forget_faults(&mut self, id: SchemaId) {
        self.timers.disarm(Timer::Restart(id));
        self.restarts[id].forget();
    }

    pub(super) fn set_health(&mut self, id: SchemaId, health: Health) {
        if self.plan.contains(id) && *self.health(id) != health {
            self.node_mut(id).set_health(health.clone());
            self.out.push(Effect::Health { id, health });
        }
    }

    fn recover(&mut self, id: SchemaId) {
        self.set_health(id, Health::Ok);
        let woke = self.wake_if_allowed(id);
        if woke {
            self.compete(id, woke, Cause::Woken(id));
        }
    }

    /// Puts an awake schema to sleep at once, with everything below it.
    fn fail_awake(&mut self, id: SchemaId) {
        let Some(group) = self.plan.group_of(id) else {
            return self.put_to_sleep(id);
        };
        let before = self.group(group).choice();
        let handover = self
            .group(group)
            .handover()
            .filter(|_| self.node(id).state() == State::Winner);
        self.withdraw(id);
        self.drain(id, SleepMode::AtOnce);
        self.put_to_sleep(id);
        if let Some(replaced) = self.handover_above(id) {
            self.group_mut(group).lose(before);
            self.advance(replaced);
            return;
        }
        if let Some(handover) = handover
            && self.group(group).pending().is_some()
        {
            // The father has an open request, but the handover had already chosen the next winner.
            self.set_winner(group, handover.to, handover.origin());
        }
        self.group_mut(group).lose(before);
        self.select(group, TimedCause::new(Cause::Faulted(id), self.now));
    }
}
