//! How late turns began because of the machine: their thread was woken and did not run, or no worker was free. It
//! excuses takeovers (R17), and measures nothing in lockstep.

use std::collections::{BTreeMap, VecDeque};

use jde_core::{Nanos, SchemaId};
use parking_lot::Mutex;

/// Shorter delays than this are those of a machine that is not loaded, ns. The contract's budgets cover them.
const MIN_DELAY: Nanos = 200_000;
/// Most delays that are kept, of all schemas together: a machine that delays each of a thousand schemas keeps those of
/// some periods.
const MAX_DELAYS: usize = 4096;

/// A turn that began late.
#[derive(Clone, Copy)]
struct Delay {
    /// `None` for a timer of the rules.
    instance: Option<SchemaId>,
    begun: Nanos,
    late: Nanos,
}

/// The newest delays.
#[derive(Default)]
pub(crate) struct MachineDelays(Mutex<VecDeque<Delay>>);

impl MachineDelays {
    /// Records that a turn of an instance, or a timer of the rules, begins at `begun`, `late` after it could.
    pub(crate) fn record(&self, instance: Option<SchemaId>, begun: Nanos, late: Nanos) {
        if late < MIN_DELAY {
            return;
        }
        let mut delays = self.0.lock();
        if delays.len() == MAX_DELAYS {
            delays.pop_front();
        }
        delays.push_back(Delay {
            instance,
            begun,
            late,
        });
    }

    /// By how much the machine may have delayed a takeover by `winner` since its cause: its own turns, and the worst
    /// of each other instance that takes part.
    pub(super) fn since(
        &self,
        cause: Nanos,
        winner: SchemaId,
        takes_part: impl Fn(SchemaId) -> bool,
    ) -> Nanos {
        let delays = self.0.lock();
        let mut worst = BTreeMap::new();
        for delay in delays.iter().rev().take_while(|delay| delay.begun >= cause) {
            if delay
                .instance
                .is_none_or(|instance| instance == winner || takes_part(instance))
            {
                let sum = worst.entry(delay.instance).or_insert(0);
                // A turn that was due before the cause delayed it only since then.
                let late = delay.late.min(delay.begun - cause);
                *sum = match delay.instance {
                    Some(instance) if instance == winner => *sum + late,
                    Some(_) | None => late.max(*sum),
                };
            }
        }
        worst.into_values().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    #[test]
    fn r17_a_takeover_is_excused_by_the_turns_of_those_that_take_part_since_its_cause() {
        let delays = MachineDelays::default();
        for (instance, begun, late) in [
            (Some(1), 5, 4),
            (Some(1), 12, 8),
            (Some(1), 20, 3),
            (Some(2), 21, 5),
            (Some(2), 22, 4),
            (Some(3), 23, 10),
            (None, 24, 1),
        ] {
            delays.record(instance.map(SchemaId), begun * MS, late * MS);
        }
        delays.record(Some(SchemaId(1)), 25 * MS, MIN_DELAY - 1);
        let since = |cause: Nanos| delays.since(cause * MS, SchemaId(1), |instance| instance == SchemaId(2));
        assert_eq!(since(10), (2 + 3 + 5 + 1) * MS);
        assert_eq!(since(22), MS);
        assert_eq!(since(30), 0);
    }

    #[test]
    fn the_newest_delays_are_kept() {
        let delays = MachineDelays::default();
        for begun in 1..=2 * MAX_DELAYS as Nanos {
            delays.record(Some(SchemaId(1)), begun * MS, MS);
        }
        assert_eq!(delays.since(0, SchemaId(1), |_| false), MAX_DELAYS as Nanos * MS);
    }
}
