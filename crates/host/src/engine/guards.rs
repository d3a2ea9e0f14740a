//! Guards of commands (R18): their functions for the ports, and what follows from a refusal. It judges nothing
//! itself.

use std::sync::atomic::Ordering;

use jde_core::Nanos;
use jde_loader::Judge;
use jde_records::turn::Turn;

use super::Engine;
use crate::instance::{Guards, PortAccess, Refusal};

/// The guards of a replay, which only find the reasons of recorded refusals.
struct ReplayedGuards<'e>(&'e Engine);

impl Guards for Engine {
    fn guard(&self, guard: usize) -> Option<(Judge, Nanos)> {
        // A replay repeats the recorded refusals.
        if self.clock.is_replayed() {
            return None;
        }
        ReplayedGuards(self).guard(guard)
    }
}

impl Guards for ReplayedGuards<'_> {
    fn guard(&self, guard: usize) -> Option<(Judge, Nanos)> {
        let Self(engine) = self;
        let judge = engine.builds.current(guard).judge?;
        Some((judge, engine.metrics[guard].period.load(Ordering::Relaxed)))
    }
}

impl Engine {
    /// Reports that a guard refused a command. The schema that gave it is not READY until its retry.
    pub(crate) fn report_refusal(&self, refusal: &Refusal) {
        let commander = refusal.commander;
        let words = self.words_of(refusal);
        self.metrics[commander].refused.fetch_add(1, Ordering::Relaxed);
        let moment = self.rules.transact_refusal(commander, words);
        if moment.order > 0 {
            self.rules
                .record_turn(Turn::COMMAND_REFUSED, commander, 0, moment);
        }
    }

    /// Repeats a recorded refusal. The reason comes from another judgement of the command, by the state that
    /// the guard has in the replay; another build of the guard may accept it.
    pub(crate) fn repeat_refusal(&self, commander: usize, ports: &PortAccess) {
        let now = self.clock.now();
        let judged = ports.with_ports(|ports| ports.judge_newest(now, &ReplayedGuards(self)));
        let words = match judged.flatten() {
            Some(refusal) => self.words_of(&refusal),
            None => String::from("command refused in the recording, and accepted now"),
        };
        self.rules.transact_refusal(commander, words);
    }

    fn words_of(&self, refusal: &Refusal) -> String {
        let guard = self.name(refusal.guard);
        format!("command refused by the guard `{guard}`: {}", refusal.reason)
    }
}
