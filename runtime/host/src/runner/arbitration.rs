//! The arbitration of a father among his children, when the rules request it.

use jde_app::RoleId;
use jde_core::{ArbitrationReply, GroupId, Level};
use jde_records::turn::TurnKind;

use super::Runner;

impl Runner {
    /// Calls the father's own arbitration, and reports the reply to the rules at once.
    pub(crate) fn arbitrate(&mut self, group: GroupId, ticket: u64, level: &Level) {
        let group_number = u64::from(group.0);
        let turn = self.record.begin(TurnKind::Arbitrated { group: group_number });
        turn.ticket = ticket;
        self.engine.metrics[self.number].begin_arbitration(ticket, self.engine.clock.now());
        let reply = self.call_arbitration(level);
        let failed = match &reply {
            ArbitrationReply::Failed { reason } => Some(reason.clone()),
            ArbitrationReply::Chosen { .. } => None,
        };
        self.record.turn.checked = self.engine.rules.report_arbitration(group, ticket, reply);
        self.record.finish();
        if let Some(reason) = failed
            && !self.roll_back(&reason)
        {
            self.handle_failed_call(&reason);
        }
    }

    /// Calls the father's own arbitration.
    pub(crate) fn call_arbitration(&mut self, level: &Level) -> ArbitrationReply {
        let Some(instance) = self.phase.instance() else {
            return ArbitrationReply::Failed {
                reason: "the father is not there".into(),
            };
        };
        let choice = instance.arbitrate(level);
        self.record.add_look(instance);
        let (role, reason) = match choice {
            Ok(choice) => choice,
            Err(reason) => return ArbitrationReply::Failed { reason },
        };
        let children = &self.engine.application.instances[self.number].children;
        let child = role.and_then(|role| children[role]);
        match (role, child) {
            (Some(RoleId(role)), None) => ArbitrationReply::Failed {
                reason: format!("chose the unbound child {role}"),
            },
            _ => ArbitrationReply::Chosen { child, reason },
        }
    }
}
