//! What follows when the process of a schema dies in one of its calls: what follows from any failure, and the rules hear of it once.

use super::{Life, Runner};

impl Runner {
    /// A call failed whose failure is no fault by itself, but its process may have died in it.
    pub(super) fn survive(&mut self, reason: &str) {
        let died = match &self.life {
            Life::Slept(instance) | Life::Awake { instance, .. } => instance.is_dead(),
            Life::Absent | Life::Changing => false,
        };
        if died && !self.go_back(reason) && self.is_to_tell() {
            self.engine.died(self.number, reason.to_owned());
        }
    }

    /// Whether the rules do not know yet that its process has died, if it has.
    pub(super) fn is_to_tell(&self) -> bool {
        match &self.life {
            Life::Slept(instance) | Life::Awake { instance, .. } => instance.is_to_tell(),
            Life::Absent | Life::Changing => true,
        }
    }
}
