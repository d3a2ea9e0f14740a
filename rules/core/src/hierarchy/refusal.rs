//! Commands that a guard refuses (R18): their schema is not READY until its retry.
//!
//! It refuses to judge a command, and knows no guard.

use super::Phase;
use super::group::TimedCause;
use super::timer::Timer;
use super::transaction::Transaction;
use crate::effect::Effect;
use crate::record::Cause;
use crate::spec::SchemaId;
use crate::state::State;

impl Transaction<'_> {
    /// Reports that a guard refused a command of a schema. The schema is not READY for its group's retry, and
    /// the group selects (R2). Has no effect for a schema without authority or that is refused already.
    pub fn refused(&mut self, id: SchemaId) {
        let Some(group) = self.plan.group_of(id) else {
            return;
        };
        let node = self.node(id);
        if self.phase != Phase::Running || !node.has_authority() || node.is_refused() {
            return;
        }
        self.node_mut(id).refuse();
        let retry = self.now.saturating_add(self.plan.group(group).retry);
        self.timers.arm(Timer::Retry(id), retry);
        self.out.push(Effect::Refused(id));
        self.select(group, TimedCause::new(Cause::Refused(id), self.now));
        self.settle();
    }

    /// Ends the refusal of a schema.
    pub(super) fn retry(&mut self, id: SchemaId) {
        self.node_mut(id).retry();
        self.out.push(Effect::Retries(id));
        let node = self.node(id);
        if !node.is_ready() {
            return;
        }
        if node.state() != State::Winner {
            self.change(id, node.state_of_loser());
        }
        if let Some(group) = self.plan.group_of(id) {
            let cause = Cause::Timer(Timer::Retry(id));
            self.select(group, TimedCause::new(cause, self.now));
        }
    }
}
