//! Authority over commands and children (R7): granted from fathers down, withdrawn from children up.
//!
//! It refuses to decide which schema wins.

use std::sync::Arc;

use super::Hierarchy;
use crate::effect::Effect;
use crate::spec::SchemaId;

impl Hierarchy {
    /// Grants authority to a new winner and to the winners below it, which an operator may have played
    /// earlier.
    pub(super) fn grant(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        let plan = Arc::clone(&self.plan);
        if let Some(group) = plan.group_of(id) {
            out.push(Effect::TakesOver { group, id });
        }
        self.node_mut(id).grant();
        out.push(Effect::Granted(id));
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner() {
                self.grant(winner, out);
            }
        }
    }

    /// Withdraws the authority of a schema and of all schemas below it, children before fathers.
    pub(super) fn withdraw(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        if !self.node(id).has_authority() {
            return;
        }
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner() {
                self.withdraw(winner, out);
            }
        }
        self.node_mut(id).withdraw();
        out.push(Effect::Withdrawn(id));
    }
}
