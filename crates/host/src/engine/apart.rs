//! Schemas in processes of their own, as the rules see them: where one is to run, and that one has died.

use super::{Engine, Signal};
use crate::apart::Room;
use crate::turn::Turn;

impl Engine {
    /// Nothing is left of an instance that could answer for itself: its level selects again, and the next awakening makes a fresh
    /// one, of the build that is in force.
    pub(crate) fn died(&self, instance: usize, reason: String) {
        self.ring(instance, Signal::Replaced);
        let moment = self.faulted(instance, reason.clone());
        self.tell_turn(Turn::GIVEN_UP, instance, 0, moment);
        self.give_up_build(instance, &reason);
    }

    /// What it takes to run an instance in a process of its own; nothing if it runs here.
    pub(crate) fn room(&self, instance: usize) -> Option<Room> {
        Some(Room {
            program: self.processes.program()?.clone(),
            limits: self.application.instances[instance].isolate?,
        })
    }

    /// Says what of a process could not be limited.
    pub(crate) fn unlimited(&self, instance: usize, what: &[String]) {
        for what in what {
            tracing::warn!(schema = self.name(instance), "{what}");
        }
    }
}
