//! Everything stopped at once by an operator, and let go on again (R14). Nothing is ended and nothing lost.

use jde_core::{Hierarchy, Operator, SchemaId, State};

use super::{Engine, Signal, schema};

impl Engine {
    /// Puts every root to sleep, and all that acts with it, takes all authority, and sends every command of every driver its neutral
    /// value, also where an absence policy would hold the last one for a while (R9). Whoever is inside an iteration has lost its
    /// authority when this returns, long before the group's patience ends (R1).
    pub(crate) fn stop_all(&self, by: &str) -> Result<(), String> {
        // The winner last: nobody may take over from it on the way.
        let roots = self.roots(|hierarchy, root| hierarchy.state(root) == State::Winner);
        let done = self.operate_each(by, roots, Operator::Stop);
        self.neutral();
        done
    }

    /// Releases every root that an operator keeps asleep.
    pub(crate) fn release_all(&self, by: &str) -> Result<(), String> {
        let mut roots = self.roots(|_, _| false);
        let rules = self.lock();
        roots.retain(|root| rules.hierarchy.is_stopped(schema(*root)));
        drop(rules);
        self.operate_each(by, roots, Operator::Release)
    }

    /// Each of them, also if one before is refused.
    fn operate_each(
        &self,
        by: &str,
        roots: Vec<usize>,
        operator: impl Fn(SchemaId) -> Operator,
    ) -> Result<(), String> {
        let done = roots
            .into_iter()
            .map(|root| self.operate(by, operator(schema(root))));
        let refused: Vec<_> = done.filter_map(Result::err).collect();
        if refused.is_empty() {
            Ok(())
        } else {
            Err(refused.join("; "))
        }
    }

    /// The roots, those of whom `last` is true at the end.
    fn roots(&self, last: impl Fn(&Hierarchy, SchemaId) -> bool) -> Vec<usize> {
        let groups = self.application.groups.iter();
        let tops = groups.filter(|group| group.father.is_none());
        let mut roots: Vec<usize> = tops.flat_map(|group| group.members.iter().copied()).collect();
        let rules = self.lock();
        roots.sort_by_key(|root| last(&rules.hierarchy, schema(*root)));
        roots
    }

    /// Sends every command its neutral value, which nobody may write over: also not whoever is still in an iteration.
    fn neutral(&self) {
        let mut rules = self.lock();
        let now = self.clock.now();
        for driver in rules.commands.brake_all(now) {
            self.ring_within(&mut rules, driver, Signal::Triggered);
        }
        self.unlock(rules);
    }
}
