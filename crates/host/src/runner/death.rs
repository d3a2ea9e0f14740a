//! Handles the death of a schema's process in one of its calls: the same as any failure, reported to the
//! rules once.

use super::{Life, Runner};

impl Runner {
    /// Handles a failed call whose failure is no fault by itself. Its process may have died in it.
    pub(super) fn survive(&mut self, reason: &str) {
        let died = match &self.life {
            Life::Slept(instance) | Life::Awake { instance, .. } => instance.is_dead(),
            Life::Absent | Life::Changing => false,
        };
        if died && !self.go_back(reason) && self.is_to_tell() {
            self.engine.died(self.number, reason.to_owned());
        }
    }

    /// Whether the rules must still be informed of a failure. False once they know that the process died.
    pub(super) fn is_to_tell(&self) -> bool {
        match &self.life {
            Life::Slept(instance) | Life::Awake { instance, .. } => instance.is_to_tell(),
            Life::Absent | Life::Changing => true,
        }
    }
}
