//! When instances are due, and until when a worker may sleep. It waits for nothing.

use std::collections::BTreeSet;

use jde_core::Nanos;

/// A turn may begin so much of its period after its deadline, if that lets another be taken without a sleep between the two: the
/// accuracy that Linux itself gives to who waits for a file (`select_estimate_accuracy`).
const LEEWAY: Nanos = 1000;

/// Deadlines by time, and each instance's own.
pub(super) struct Calendar {
    entries: BTreeSet<(Nanos, usize)>,
    due: Vec<Option<Nanos>>,
    leeway: Vec<Nanos>,
}

impl Calendar {
    pub(super) fn new(instances: usize) -> Self {
        Self {
            entries: BTreeSet::new(),
            due: vec![None; instances],
            leeway: vec![0; instances],
        }
    }

    /// An instance of that period is due then, and at no other time.
    pub(super) fn put(&mut self, instance: usize, due: Option<Nanos>, period: Nanos) {
        self.take_out(instance);
        self.entries.extend(due.map(|due| (due, instance)));
        self.due[instance] = due;
        self.leeway[instance] = period / LEEWAY;
    }

    /// An instance is due no more.
    pub(super) fn take_out(&mut self, instance: usize) {
        if let Some(due) = self.due[instance].take() {
            self.entries.remove(&(due, instance));
        }
    }

    /// Takes out who is due first, if that is by now.
    pub(super) fn take(&mut self, now: Nanos) -> Option<usize> {
        let &(due, instance) = self.entries.first()?;
        if due > now {
            return None;
        }
        self.take_out(instance);
        Some(instance)
    }

    /// When a worker has to be there: at the first deadline; at a later one, if nobody's leeway is over by then.
    pub(super) fn next(&self) -> Option<Nanos> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    /// Instances that are due then, each with its period.
    fn calendar(entries: &[(Nanos, Nanos)]) -> Calendar {
        let mut calendar = Calendar::new(entries.len());
        for (instance, (due, period)) in entries.iter().enumerate() {
            calendar.put(instance, Some(*due), *period);
        }
        calendar
    }

    #[test]
    fn who_is_due_comes_out_in_order_and_once() {
        let mut calendar = calendar(&[(30, MS), (10, MS), (20, MS)]);
        assert_eq!(calendar.take(9), None);
        assert_eq!(calendar.take(20), Some(1));
        assert_eq!(calendar.take(20), Some(2));
        assert_eq!(calendar.take(29), None);
        calendar.put(0, Some(40), MS);
        assert_eq!(calendar.take(39), None, "it has another deadline now");
        calendar.take_out(0);
        assert_eq!(calendar.take(Nanos::MAX), None);
        assert_eq!(calendar.next(), None);
    }

    #[test]
    fn r11_nobody_waits_longer_than_its_leeway_for_others() {
        // A thousandth of 10 ms is 10 us.
        let near = |second, period| calendar(&[(MS, 10 * MS), (MS + second, period)]).next();
        assert_eq!(near(10_000, 10 * MS), Some(MS + 10_000), "both at once");
        assert_eq!(near(10_001, 10 * MS), Some(MS), "the first would be too late");
        assert_eq!(
            calendar(&[(MS, 10 * MS)]).next(),
            Some(MS),
            "there is nobody to wait for"
        );
        let hurried = calendar(&[(MS, 10 * MS), (MS + 1000, MS), (MS + 3000, 10 * MS)]);
        assert_eq!(hurried.next(), Some(MS + 1000), "the second has 1 us");
    }
}
