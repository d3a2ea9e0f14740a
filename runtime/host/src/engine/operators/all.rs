//! Stops everything at once for an operator, and releases it again (R14). No instance ends and no memory is
//! lost.
//!
//! Each operation is one transaction of the rules, so that every other change precedes or follows it
//! entirely.

use jde_core::{Holder, Operator, Refused, SchemaId, Transaction};
use jde_records::turn::Operation;

use super::Operators;
use super::holds::Actor;

impl Operators {
    /// Puts every root to sleep with all schemas below it. When this returns, a schema inside an iteration
    /// has lost its authority, long before the group's patience ends (R1). Every command is neutral, even
    /// where an absence policy would hold it for a while (R9).
    pub(crate) fn stop_all(&self, by: &Actor) -> Result<(), String> {
        let mut holder = Holder::UNKNOWN;
        let (done, moment) = self.rules.transact_recorded(|transaction| {
            holder = self.holds().holder(transaction, by);
            self.stop_roots(transaction, holder)
        });
        let stopped = match done {
            Ok(_) => Operation::AllStopped(holder),
            Err(_) => Operation::Refused,
        };
        self.record_operation(SchemaId(0), stopped, moment);
        self.report_operations(&by.name, done, Operator::Stop)
    }

    /// Ends every stop of everything.
    pub(crate) fn release_all(&self, by: &Actor) -> Result<(), String> {
        let (done, moment) = self
            .rules
            .transact_recorded(|transaction| transaction.release_all());
        let released = match done {
            Ok(_) => Operation::AllReleased,
            Err(_) => Operation::Refused,
        };
        self.record_operation(SchemaId(0), released, moment);
        self.report_operations(&by.name, done, Operator::Release)
    }

    /// Repeats an operator's stop of everything, in a replay.
    pub(crate) fn repeat_stop_all(&self, by: Holder) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|transaction| self.stop_roots(transaction, by));
    }

    /// Repeats an operator's release of everything, in a replay.
    pub(crate) fn repeat_release_all(&self) {
        let _ = self.rules.transact(|transaction| transaction.release_all());
    }

    fn stop_roots(&self, transaction: &mut Transaction, by: Holder) -> Result<Vec<SchemaId>, Refused> {
        transaction.stop_all(by)?;
        let groups = self.application.groups.iter();
        let tops = groups.filter(|group| group.father.is_none());
        let roots = tops.flat_map(|group| group.members.iter().copied());
        Ok(roots.collect())
    }

    /// Reports an operator's action on each affected schema.
    fn report_operations(
        &self,
        by: &str,
        done: Result<Vec<SchemaId>, Refused>,
        operator: impl Fn(SchemaId) -> Operator,
    ) -> Result<(), String> {
        for id in done.map_err(|refused| refused.to_string())? {
            self.rules.report_operation(by, operator(id).into());
        }
        Ok(())
    }
}
