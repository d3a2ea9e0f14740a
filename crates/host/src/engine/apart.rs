//! Schemas in processes of their own, as the rules see them: whether an instance runs in one, and what
//! follows from its death.

use super::{Engine, Signal};
use crate::apart::Room;
use crate::turn::Turn;

impl Engine {
    /// Gives up an instance whose process died or whose call hangs. The level selects again, and the next
    /// awakening creates a new instance of the build in force.
    pub(crate) fn died(&self, instance: usize, reason: String) {
        self.ring(instance, Signal::Replaced);
        let moment = self.faulted(instance, reason.clone());
        self.tell_turn(Turn::GIVEN_UP, instance, 0, moment);
        self.give_up_build(instance, &reason);
    }

    /// The program and the limits that run an instance in a process of its own; `None` if it runs in this
    /// process.
    pub(crate) fn room(&self, instance: usize) -> Option<Room> {
        Some(Room {
            program: self.processes.program()?.clone(),
            limits: self.application.instances[instance].isolate?,
        })
    }

    /// Logs each limit that could not be set on a process.
    pub(crate) fn unlimited(&self, instance: usize, what: &[String]) {
        for what in what {
            tracing::warn!(schema = self.name(instance), "{what}");
        }
    }
}
