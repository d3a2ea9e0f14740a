//! Everything stopped at once by an operator, and let go on again (R14). Nothing is ended and nothing lost.
//!
//! Each is one transaction of the rules, so that whatever others do at the same time comes before it or after it.

use jde_core::{Effect, Hierarchy, Nanos, Operator, Refused, SchemaId};

use super::Engine;
use crate::event::OperatorAction;
use crate::turn::Turn;

impl Engine {
    /// Puts every root to sleep with all below it. Whoever is inside an iteration has lost its authority when this returns, long before
    /// the group's patience ends (R1), and what anybody commanded is neutral, also where an absence policy would hold it for a
    /// while (R9).
    pub(crate) fn stop_all(&self, by: &str) -> Result<(), String> {
        let (done, moment) =
            self.transact_told(|hierarchy, now, out| self.stop_roots(hierarchy, now, out, by));
        let way = if done.is_ok() { Turn::ALL_STOPPED } else { 0 };
        self.tell_turn(Turn::OPERATED, 0, way, moment);
        self.all_operated(by, done, Operator::Stop)
    }

    /// Lets every root go on that was stopped with everything, and by nobody by itself.
    pub(crate) fn release_all(&self, by: &str) -> Result<(), String> {
        let (done, moment) = self.transact_told(|hierarchy, now, out| hierarchy.release_all(now, out));
        let way = if done.is_ok() { Turn::ALL_RELEASED } else { 0 };
        self.tell_turn(Turn::OPERATED, 0, way, moment);
        self.all_operated(by, done, Operator::Release)
    }

    /// Has an operator of the past stop everything again.
    pub(crate) fn stop_all_again(&self) {
        // What was refused then was told to whoever acted.
        let _ = self.transact(|hierarchy, now, out| self.stop_roots(hierarchy, now, out, ""));
    }

    /// Has an operator of the past let everything go on again.
    pub(crate) fn release_all_again(&self) {
        let _ = self.transact(|hierarchy, now, out| hierarchy.release_all(now, out));
    }

    fn stop_roots(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        by: &str,
    ) -> Result<Vec<SchemaId>, Refused> {
        hierarchy.stop_all(now, out)?;
        let groups = self.application.groups.iter();
        let tops = groups.filter(|group| group.father.is_none());
        let roots = tops.flat_map(|group| group.members.iter().map(|root| super::schema(*root)));
        by.clone_into(&mut self.held().everything);
        Ok(roots.collect())
    }

    /// Tells of each schema on which an operator acted.
    fn all_operated(
        &self,
        by: &str,
        done: Result<Vec<SchemaId>, Refused>,
        operator: impl Fn(SchemaId) -> Operator,
    ) -> Result<(), String> {
        for id in done.map_err(|refused| refused.to_string())? {
            self.operated(by, OperatorAction::Hierarchy(operator(id)));
        }
        Ok(())
    }
}
