//! The reports of the executor on a schema's own activity: checks, and the begin and end of iterations.
//!
//! This is the hot path: nothing is allocated when nothing changes.

use super::nodes::{Phase, RunState, TakeoverPhase};
use super::selection::TimedCause;
use super::{Hierarchy, nodes::Urgency};
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

impl Hierarchy {
    /// Reports the check of an awake motor schema. A changed readiness, and the first check after waking,
    /// cause a selection (R2). Has no effect for a schema that sleeps or is inside an abandoned iteration.
    pub fn checked(&mut self, now: Nanos, id: SchemaId, check: Check, out: &mut Vec<Effect>) {
        let Some(node) = self.nodes.get(id.index()) else {
            return;
        };
        if node.state == State::Slept || node.run == RunState::Abandoned {
            return;
        }
        let Some(group) = self.plan.group_of(id) else {
            return;
        };
        let urgency = Urgency::new(check.urgency);
        let is_changed = !node.checked || node.ready != check.ready;
        if !is_changed && node.urgency == urgency {
            return;
        }
        let node = self.node_mut(id);
        node.urgency = urgency;
        node.checked = true;
        node.ready = check.ready;
        let state = node.state;
        if !is_changed {
            return;
        }
        if state != State::Winner {
            // The snapshot of the selection contains the state that the check found.
            self.change(
                id,
                if check.ready {
                    State::Ready
                } else {
                    State::Checking
                },
                out,
            );
        }
        let trigger = TimedCause::new(Cause::Readiness(id), check.cause.min(now));
        self.select(now, group, trigger, out);
        self.settle(out);
    }

    /// Requests permission to start an iteration and, if it is granted, records that the iteration runs. Only
    /// a WINNER that should stay awake gets it, and only if no older iteration of it runs and neither it nor
    /// one of its fathers is being replaced.
    ///
    /// The first iteration after a promotion emits [`Effect::TookOver`].
    pub fn begin(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) -> bool {
        let Some(node) = self.nodes.get(id.index()) else {
            return false;
        };
        let is_permitted =
            node.state == State::Winner && node.run == RunState::Between && node.should_be_awake();
        if !is_permitted || self.handover_above(id).is_some() {
            return false;
        }
        self.set_run(id, RunState::Iterating);
        let node = &mut self.nodes[id.index()];
        if node.takeover_phase == TakeoverPhase::New {
            node.takeover_phase = TakeoverPhase::First;
        }
        if let Some(group) = self.plan.group_of(id)
            && let Some(origin) = self.group_mut(group).takeover.take()
        {
            let latency = now.saturating_sub(origin.cause_time);
            out.push(Effect::TookOver {
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
    pub fn end(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        if !self.plan.contains(id) {
            return;
        }
        let previous_run = self.set_run(id, RunState::Between);
        if self.nodes[id.index()].takeover_phase == TakeoverPhase::First {
            self.nodes[id.index()].takeover_phase = TakeoverPhase::Settled;
            out.push(Effect::Lapsed(id));
        }
        let awake = self.is_awake(id);
        if previous_run == RunState::Between
            || self.phase != Phase::Running
            || self.plan.kind(id) == Kind::Perceptive
        {
            return;
        }
        if let Some(group) = self.handover_above(id) {
            self.advance(now, group, out);
        } else if awake && let Some(group) = self.plan.group_of(id) {
            self.select(now, group, TimedCause::new(Cause::Iterated(id), now), out);
        }
        self.settle(out);
    }

    /// Sets the relation of a schema to its iteration and returns the previous one. No candidate list
    /// contains this, so none is marked.
    fn set_run(&mut self, id: SchemaId, run: RunState) -> RunState {
        std::mem::replace(&mut self.nodes[id.index()].run, run)
    }
}
