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
        self.all_operated(by, done, Operator::Stop).map(drop)
    }

    /// Releases every root that an operator keeps asleep.
    pub(crate) fn release_all(&self, by: &str) -> Result<(), String> {
        let (done, moment) =
            self.transact_told(|hierarchy, now, out| self.release_roots(hierarchy, now, out));
        let way = if done.is_ok() { Turn::ALL_RELEASED } else { 0 };
        self.tell_turn(Turn::OPERATED, 0, way, moment);
        for root in self.all_operated(by, done, Operator::Release)? {
            self.give_back(root, |_| true);
        }
        Ok(())
    }

    /// Has an operator of the past stop everything again.
    pub(crate) fn stop_all_again(&self) {
        // What was refused then was told to whoever acted.
        let _ = self.transact(|hierarchy, now, out| self.stop_roots(hierarchy, now, out, ""));
    }

    /// Has an operator of the past let everything go on again.
    pub(crate) fn release_all_again(&self) {
        let _ = self.transact(|hierarchy, now, out| self.release_roots(hierarchy, now, out));
    }

    fn stop_roots(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        by: &str,
    ) -> Result<Vec<usize>, Refused> {
        hierarchy.stop_all(now, out)?;
        let groups = self.application.groups.iter();
        let tops = groups.filter(|group| group.father.is_none());
        let roots: Vec<usize> = tops.flat_map(|group| group.members.iter().copied()).collect();
        let mut held = self.held();
        roots.iter().for_each(|root| held.hold_with_everything(*root, by));
        Ok(roots)
    }

    fn release_roots(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
    ) -> Result<Vec<usize>, Refused> {
        let released = hierarchy.release_all(now, out)?;
        let released: Vec<usize> = released.into_iter().map(SchemaId::index).collect();
        let mut held = self.held();
        released.iter().for_each(|root| held.let_go(*root));
        Ok(released)
    }

    /// Tells of each schema on which an operator acted.
    fn all_operated(
        &self,
        by: &str,
        done: Result<Vec<usize>, Refused>,
        operator: impl Fn(SchemaId) -> Operator,
    ) -> Result<Vec<usize>, String> {
        let schemas = done.map_err(|refused| refused.to_string())?;
        for number in &schemas {
            self.operated(by, OperatorAction::Hierarchy(operator(super::schema(*number))));
        }
        Ok(schemas)
    }
}
