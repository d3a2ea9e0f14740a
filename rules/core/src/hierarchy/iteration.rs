//! The reports of the executor on a schema's own activity: checks, and the begin and end of iterations.
//!
//! This is the hot path: nothing is allocated when nothing changes.

use super::Phase;
use super::group::TimedCause;
use super::last_check::Urgency;
use super::transaction::Transaction;
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::{Kind, Nanos, SchemaId};
use crate::state::State;

/// The result of a motor schema's check of its precondition.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Check {
    /// Whether the precondition is true.
    pub ready: bool,
    /// The urgency, on a scale that its siblings share. A NaN counts as the lowest.
    pub urgency: f64,
    /// When the situation that it reports began.
    pub cause: Nanos,
}

impl Transaction<'_> {
    /// Reports the check of an awake motor schema. A changed readiness, and the first check after waking,
    /// cause a selection (R2). Has no effect for a schema that sleeps or is inside an abandoned iteration.
    pub fn checked(&mut self, id: SchemaId, check: Check) {
        let Some(group) = self.plan.group_of(id) else {
            return;
        };
        let urgency = Urgency::new(check.urgency);
        let hierarchy = &mut *self.hierarchy;
        if !hierarchy.nodes.check(&hierarchy.plan, id, check.ready, urgency) {
            return;
        }
        let node = self.node(id);
        if node.state() != State::Winner {
            // The snapshot of the selection contains the state that the check found.
            self.change(id, node.state_of_loser());
        }
        let trigger = TimedCause::new(Cause::Readiness(id), check.cause.min(self.now));
        self.select(group, trigger);
        self.settle();
    }

    /// Requests permission to start an iteration and, if it is granted, records that the iteration runs. Only
    /// a WINNER that should stay awake gets it, and only if no older iteration of it runs and neither it nor
    /// one of its fathers is being replaced.
    ///
    /// The first iteration after a promotion emits [`Effect::TookOver`].
    pub fn begin(&mut self, id: SchemaId) -> bool {
        if !self.node(id).can_begin() || self.handover_above(id).is_some() {
            return false;
        }
        self.nodes.begin(id);
        if let Some(group) = self.plan.group_of(id)
            && let Some(origin) = self.group_mut(group).take_over()
        {
            let latency = self.now.saturating_sub(origin.cause_time);
            self.out.push(Effect::TookOver {
                group,
                record: origin.record,
                id,
                latency,
            });
        }
        true
    }

    /// Reports that the iteration of a schema ended, by a return or by a panic (after
    /// [`faulted`](Self::faulted)). A handover that waited for it continues. A winner competes again (R2).
    pub fn end(&mut self, id: SchemaId) {
        if !self.plan.contains(id) {
            return;
        }
        let end = self.nodes.end(id);
        if end.lapsed {
            self.out.push(Effect::Lapsed(id));
        }
        let awake = self.is_awake(id);
        if !end.ran || self.phase != Phase::Running || self.plan.kind(id) == Kind::Perceptive {
            return;
        }
        if let Some(group) = self.handover_above(id) {
            self.advance(group);
        } else if awake && let Some(group) = self.plan.group_of(id) {
            self.select(group, TimedCause::new(Cause::Iterated(id), self.now));
        }
        self.settle();
    }

    /// [`Self::end`] of an iteration that could not act because an input had no value (R19): a motor schema is not
    /// READY until its next check.
    pub fn end_unready(&mut self, id: SchemaId) {
        let group = self.plan.group_of(id).filter(|_| self.node(id).is_running());
        let is_changed = group.is_some() && self.node_mut(id).end_readiness();
        let replaced = group.filter(|group| is_changed && self.handover_above(id) == Some(*group));
        self.end(id);
        if let Some(group) = replaced {
            // The end completed a handover, which selects nobody; the readiness changed (R2).
            self.select(group, TimedCause::new(Cause::Readiness(id), self.now));
            self.settle();
        }
    }
}
