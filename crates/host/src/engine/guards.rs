//! Guards of commands (R18): their functions for the ports, and what follows from a refusal.

use std::sync::atomic::Ordering;

use jde_core::Nanos;
use jde_loader::Judge;
use jde_records::turn::Turn;

use super::{Engine, schema};
use crate::instance::{Guards, Refusal};

impl Guards for Engine {
    fn guard(&self, guard: usize) -> Option<(Judge, Nanos)> {
        // A replay repeats the recorded refusals.
        if self.clock.is_replayed() {
            return None;
        }
        let judge = self.builds.current(guard).judge?;
        Some((judge, self.metrics[guard].period.load(Ordering::Relaxed)))
    }
}

impl Engine {
    /// Reports that a guard refused a command. The schema that gave it is not READY until its retry.
    pub(crate) fn report_refusal(&self, refusal: &Refusal) {
        let (commander, guard) = (refusal.commander, self.name(refusal.guard));
        let words = format!("command refused by the guard {guard}: {}", refusal.reason);
        self.metrics[commander].refused.fetch_add(1, Ordering::Relaxed);
        let moment = self.rules.transact_refusal(commander, words);
        if moment.order > 0 {
            self.rules
                .record_turn(Turn::COMMAND_REFUSED, commander, 0, moment);
        }
    }

    /// Repeats a recorded refusal.
    pub(crate) fn repeat_refusal(&self, commander: usize) {
        self.rules
            .transact(|hierarchy, now, out| hierarchy.refused(now, schema(commander), out));
    }
}
