//! Commands that a guard refuses (R18): their schema is not READY until its retry.
//!
//! It refuses to judge a command, and knows no guard.

use super::group::TimedCause;
use super::timer::Timer;
use super::{Hierarchy, Phase};
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::{Nanos, SchemaId};
use crate::state::State;

impl Hierarchy {
    /// Reports that a guard refused a command of a schema. The schema is not READY for its group's retry, and
    /// the group selects (R2). Has no effect for a schema without authority or that is refused already.
    pub fn refused(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        let Some(group) = self.plan.group_of(id) else {
            return;
        };
        let node = self.node(id);
        if self.phase != Phase::Running || !node.has_authority() || node.is_refused() {
            return;
        }
        self.node_mut(id).refuse();
        let retry = now.saturating_add(self.plan.group(group).retry);
        self.timers.arm(Timer::Retry(id), retry);
        out.push(Effect::Refused(id));
        self.select(now, group, TimedCause::new(Cause::Refused(id), now), out);
        self.settle(out);
    }

    /// Ends the refusal of a schema.
    pub(super) fn retry(&mut self, now: Nanos, id: SchemaId, out: &mut Vec<Effect>) {
        self.node_mut(id).retry();
        out.push(Effect::Retries(id));
        let node = self.node(id);
        if !node.is_ready() {
            return;
        }
        if node.state() != State::Winner {
            self.change(id, node.state_of_loser(), out);
        }
        if let Some(group) = self.plan.group_of(id) {
            let cause = Cause::Timer(Timer::Retry(id));
            self.select(now, group, TimedCause::new(cause, now), out);
        }
    }
}
