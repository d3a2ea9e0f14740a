//! Authority over commands and children (R7): granted from fathers down, withdrawn from children up.
//!
//! It refuses to decide which schema wins.

use std::sync::Arc;

use super::transaction::Transaction;
use crate::effect::Effect;
use crate::spec::SchemaId;

impl Transaction<'_> {
    /// Grants authority to a new winner and to the winners below it, which an operator may have played
    /// earlier.
    pub(super) fn grant(&mut self, id: SchemaId) {
        let plan = Arc::clone(&self.plan);
        if let Some(group) = plan.group_of(id) {
            self.out.push(Effect::TakesOver { group, id });
        }
        self.node_mut(id).grant();
        self.out.push(Effect::Granted(id));
        if self.node(id).delegates() {
            self.grant_below(id);
        }
    }

    /// Reports that a debugger holds a call of a schema, or lets it go on. Meanwhile nothing below it has
    /// authority, since it could not put it to sleep. Has no effect for a schema that sleeps.
    pub fn set_debugged(&mut self, id: SchemaId, debugged: bool) {
        if !self.is_awake(id) || !self.node_mut(id).set_debugged(debugged) || !self.has_authority(id) {
            return;
        }
        if debugged {
            self.withdraw_below(id);
        } else {
            self.grant_below(id);
        }
    }

    fn grant_below(&mut self, id: SchemaId) {
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner() {
                self.grant(winner);
            }
        }
    }

    /// Withdraws the authority of a schema and of all schemas below it, children before fathers.
    pub(super) fn withdraw(&mut self, id: SchemaId) {
        if !self.node(id).has_authority() {
            return;
        }
        self.withdraw_below(id);
        self.node_mut(id).withdraw();
        self.out.push(Effect::Withdrawn(id));
    }

    fn withdraw_below(&mut self, id: SchemaId) {
        let plan = Arc::clone(&self.plan);
        for &group in plan.groups_under(id) {
            if let Some(winner) = self.group(group).winner() {
                self.withdraw(winner);
            }
        }
    }
}
