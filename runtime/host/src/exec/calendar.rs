//! The deadlines of instances, and the time until which a worker may sleep. It never waits itself.

use std::collections::BTreeSet;

use jde_core::{Nanos, SchemaId, Table};

/// A turn may begin up to a thousandth of its period after its deadline, if that saves a sleep between two
/// turns.
const LEEWAY_DIVISOR: Nanos = 1000;
/// The greatest such delay, ns: the default timer slack of a Linux thread.
const MAX_LEEWAY: Nanos = 50_000;

/// All deadlines, ordered by time and by instance.
pub(super) struct Calendar {
    entries: BTreeSet<(Nanos, SchemaId)>,
    due: Table<SchemaId, Option<Nanos>>,
    leeway: Table<SchemaId, Nanos>,
}

impl Calendar {
    pub(super) fn new(instances: usize) -> Self {
        Self {
            entries: BTreeSet::new(),
            due: vec![None; instances].into(),
            leeway: vec![0; instances].into(),
        }
    }

    /// Sets the only deadline of an instance. Its turn may be delayed by up to `leeway`, ns.
    pub(super) fn set_due(&mut self, instance: SchemaId, due: Option<Nanos>, leeway: Nanos) {
        self.remove(instance);
        self.entries.extend(due.map(|due| (due, instance)));
        self.due[instance] = due;
        self.leeway[instance] = leeway;
    }

    /// Removes the deadline of an instance.
    pub(super) fn remove(&mut self, instance: SchemaId) {
        if let Some(due) = self.due[instance].take() {
            self.entries.remove(&(due, instance));
        }
    }

    /// Removes and returns the instance that is due first, if it is due by now.
    pub(super) fn pop_due(&mut self, now: Nanos) -> Option<SchemaId> {
        let &(due, instance) = self.entries.first()?;
        if due > now {
            return None;
        }
        self.remove(instance);
        Some(instance)
    }

    /// Returns when a worker must be ready: at the first deadline, or at a later one if no instance's leeway
    /// ends before it.
    pub(super) fn next_wakeup(&self) -> Option<Nanos> {
        let mut latest = Nanos::MAX;
        let mut next = None;
        for &(due, instance) in &self.entries {
            if due > latest {
                break;
            }
            latest = latest.min(due.saturating_add(self.leeway[instance]));
            next = Some(due);
        }
        next
    }
}

/// Returns how long a turn of a schema with this period may be delayed, ns.
pub(super) fn leeway(period: Nanos) -> Nanos {
    (period / LEEWAY_DIVISOR).min(MAX_LEEWAY)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    /// Instances with their deadlines and leeways.
    fn calendar(entries: &[(Nanos, Nanos)]) -> Calendar {
        let mut calendar = Calendar::new(entries.len());
        for (instance, (due, leeway)) in (0..).map(SchemaId).zip(entries) {
            calendar.set_due(instance, Some(*due), *leeway);
        }
        calendar
    }

    #[test]
    fn due_instances_are_returned_once_in_the_order_of_their_deadlines() {
        let mut calendar = calendar(&[(30, 0), (10, 0), (20, 0)]);
        assert_eq!(calendar.pop_due(9), None);
        assert_eq!(calendar.pop_due(20), Some(SchemaId(1)));
        assert_eq!(calendar.pop_due(20), Some(SchemaId(2)));
        assert_eq!(calendar.pop_due(29), None);
        calendar.set_due(SchemaId(0), Some(40), 0);
        assert_eq!(
            calendar.pop_due(39),
            None,
            "the new deadline replaces the old one"
        );
        calendar.remove(SchemaId(0));
        assert_eq!(calendar.pop_due(Nanos::MAX), None);
        assert_eq!(calendar.next_wakeup(), None);
    }

    #[test]
    fn r11_no_turn_is_delayed_longer_than_its_leeway() {
        let wakeup_for_two = |second, leeway| calendar(&[(MS, 10), (MS + second, leeway)]).next_wakeup();
        assert_eq!(wakeup_for_two(10, 10), Some(MS + 10), "one wakeup for both");
        assert_eq!(
            wakeup_for_two(11, 10),
            Some(MS),
            "the first turn would be too late"
        );
        assert_eq!(
            calendar(&[(MS, 10)]).next_wakeup(),
            Some(MS),
            "a single deadline is not delayed"
        );
        let short_leeway = calendar(&[(MS, 10), (MS + 1, 1), (MS + 3, 10)]);
        assert_eq!(
            short_leeway.next_wakeup(),
            Some(MS + 1),
            "the leeway of the second deadline limits the delay"
        );
        let no_leeway = calendar(&[(MS, 0), (MS + 1, 10)]);
        assert_eq!(
            no_leeway.next_wakeup(),
            Some(MS),
            "the first deadline has no leeway"
        );
    }

    #[test]
    fn r11_the_leeway_is_a_thousandth_of_the_period_up_to_a_maximum() {
        assert_eq!(leeway(MS), 1000);
        assert_eq!(leeway(50 * MS), MAX_LEEWAY);
        assert_eq!(leeway(3_600_000 * MS), MAX_LEEWAY);
    }
}
