//! Handles the death of a schema's process in one of its calls: like any failure, it is reported to the rules
//! once.

use super::{InstanceState, Runner};

impl Runner {
    /// Handles a failed call whose failure is no fault by itself. Its process may have died in it.
    pub(super) fn handle_failed_call(&mut self, reason: &str) {
        let is_dead = match &self.state {
            InstanceState::Slept(instance) | InstanceState::Awake { instance, .. } => instance.is_dead(),
            InstanceState::Absent | InstanceState::Changing => false,
        };
        if is_dead && !self.roll_back(reason) && self.claim_failure_report() {
            self.engine.report_death(self.number, reason.to_owned());
        }
    }

    /// Whether the rules must still be informed of a failure. False after they were informed of the death of
    /// the process.
    pub(super) fn claim_failure_report(&self) -> bool {
        match &self.state {
            InstanceState::Slept(instance) | InstanceState::Awake { instance, .. } => {
                instance.claim_failure_report()
            }
            InstanceState::Absent | InstanceState::Changing => true,
        }
    }
}
