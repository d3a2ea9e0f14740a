//! Authority over commands and children (R7): granted from fathers down, withdrawn from children up.
//!
//! It refuses to decide who wins.

use std::sync::Arc;

use super::Hierarchy;
use crate::effect::Effect;
use crate::spec::SchemaId;

impl Hierarchy {
    /// Gives authority to a new winner, and to the winners below it, whom an operator may have played before.
    pub(super) fn grant(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        self.node_mut(id).authority = true;
        out.push(Effect::Granted(id));
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner {
                self.grant(winner, out);
            }
        }
    }

    /// Takes the authority of a schema and of all below it, children before fathers.
    pub(super) fn withdraw(&mut self, id: SchemaId, out: &mut Vec<Effect>) {
        if !self.node(id).authority {
            return;
        }
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner {
                self.withdraw(winner, out);
            }
        }
        self.node_mut(id).authority = false;
        out.push(Effect::Withdrawn(id));
    }
}
