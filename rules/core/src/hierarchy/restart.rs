//! Faults, health and restarts. A faulted schema affects no other, and its restart policy states when it may
//! run again.
//!
//! It refuses to decide what a fault is; the executor reports it.

use super::group::TimedCause;
use super::sleep::SleepMode;
use super::timer::Timer;
use super::{Hierarchy, Phase};
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::{Nanos, SchemaId};
use crate::state::{Health, State};

impl Hierarchy {
    /// Reports that a schema panicked, returned an error, hung or died. It sleeps at once with its subtree,
    /// its level selects again, and its restart policy applies.
    ///
    /// A running iteration counts as abandoned until [`end`](Self::end) is called for it, even if the fault
    /// itself ended it: report the fault, then the end. A second report before the restart has no effect.
    pub fn faulted(&mut self, now: Nanos, id: SchemaId, reason: String, out: &mut Vec<Effect>) {
        if !self.plan.contains(id) || self.node(id).is_faulted() {
            return;
        }
        self.set_health(id, Health::Faulted(reason), out);
        if self.phase != Phase::Running {
            return;
        }
        let policy = self.plan.schema(id).restart;
        if let Some(due) = self.restarts[id.index()].due(policy, now) {
            self.timers.arm(Timer::Restart(id), due);
        }
        if self.is_awake(id) {
            self.fail_awake(now, id, out);
        }
        self.settle(out);
    }

    /// Reports that the code or the process of a schema was replaced, or that its fault counts as repaired.
    /// The fault and all restarts are cleared, and the schema wakes if it has a requester.
    pub fn restored(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        if self.plan.contains(id) {
            self.forget_faults(id);
            self.recover(now, id, out);
            self.settle(out);
        }
    }

    /// Reports a missed deadline.
    pub fn overrun(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        if *self.health(id) == Health::Ok {
            self.set_health(id, Health::Overrun, out);
        }
    }

    /// Reports that a schema meets its deadlines again.
    pub fn on_time(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        if *self.health(id) == Health::Overrun {
            self.set_health(id, Health::Ok, out);
        }
    }

    pub(super) fn restart(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        self.restarts[id.index()].record(now);
        self.recover(now, id, out);
    }

    /// Clears the pending restart and the count of restarts.
    pub(super) fn forget_faults(&mut self, id: SchemaId) {
        self.timers.disarm(Timer::Restart(id));
        self.restarts[id.index()].forget();
    }

    /// Returns how many restarts its policy still grants at this time; `None` if it is never restarted.
    #[must_use]
    pub fn restarts_left(&self, now: Nanos, id: SchemaId) -> Option<u32> {
        if !self.plan.contains(id) {
            return None;
        }
        self.restarts[id.index()].left(self.plan.schema(id).restart, now)
    }

    pub(super) fn set_health(&mut self, id: SchemaId, health: Health, out: &mut Vec<Effect>) {
        if self.plan.contains(id) && *self.health(id) != health {
            self.node_mut(id).set_health(health.clone());
            out.push(Effect::Health { id, health });
        }
    }

    fn recover(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        self.set_health(id, Health::Ok, out);
        let woke = self.wake_if_allowed(id, out);
        if woke {
            self.compete(now, id, woke, Cause::Woken(id), out);
        }
    }

    /// Puts an awake schema to sleep at once, with everything below it.
    fn fail_awake(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        let Some(group) = self.plan.group_of(id) else {
            return self.put_to_sleep(id, out);
        };
        let before = self.group(group).choice();
        let handover = self
            .group(group)
            .handover()
            .filter(|_| self.node(id).state() == State::Winner);
        self.withdraw(id, out);
        self.drain(id, SleepMode::AtOnce, out);
        self.put_to_sleep(id, out);
        if let Some(replaced) = self.handover_above(id) {
            self.group_mut(group).lose(before);
            self.advance(now, replaced, out);
            return;
        }
        if let Some(handover) = handover
            && self.group(group).pending().is_some()
        {
            // The father has an open request, but the handover had already chosen the next winner.
            self.set_winner(group, now, handover.to, handover.origin(), out);
        }
        self.group_mut(group).lose(before);
        self.select(now, group, TimedCause::new(Cause::Faulted(id), now), out);
    }
}
