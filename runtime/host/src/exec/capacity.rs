//! Decides how many workers a pool has. One is always free, however many are inside calls. It starts and ends
//! no thread.
//!
//! The last free worker takes a turn only if no other is about to return, and more workers are started before
//! it does. So a pool has at most one worker more than there are schemas, and none beyond its start while
//! turns are short, however many turns are due.

use jde_core::Nanos;

/// How long to wait for a worker that is about to return, ns. A busy system may not let it run, or its turn
/// may take longer than expected.
pub(super) const GRACE: Nanos = 500_000;
/// Workers that were not needed for this time exit, ns.
const IDLE_TIMEOUT: Nanos = 1_000_000_000;

/// The workers that have not hung.
pub(super) struct Capacity {
    /// The number at the start, and the least later.
    min_workers: usize,
    /// The greatest number: one for each schema, and a free one.
    max_workers: usize,
    workers: usize,
    /// Workers in no turn, including those not started yet.
    free: usize,
    /// Workers in a turn that was expected to be short.
    short_turns: usize,
    /// Until when the newest of these is waited for.
    expected_return: Nanos,
    /// The fewest free workers since `since`.
    min_free: usize,
    since: Nanos,
}

impl Capacity {
    pub(super) fn new(workers: usize, schemas: usize) -> Self {
        Self {
            min_workers: workers,
            max_workers: schemas + 1,
            workers,
            free: workers,
            short_turns: 0,
            expected_return: 0,
            min_free: workers,
            since: 0,
        }
    }

    /// Returns until when a free worker takes no turn, because it is the last one and another is about to
    /// return.
    pub(super) fn deferred_until(&self, now: Nanos) -> Option<Nanos> {
        (self.free == 1 && self.short_turns > 0 && now < self.expected_return).then_some(self.expected_return)
    }

    /// A free worker starts a turn. Returns how many workers to start.
    pub(super) fn begin_turn(&mut self, now: Nanos, is_short: bool) -> usize {
        // All workers that were expected back are still busy. As many instances may be due, and each would
        // find no free worker.
        let added = match (self.free, self.short_turns) {
            (1, 0) => 1,
            (1, _) => self.workers,
            _ => 0,
        }
        .min(self.max_workers.saturating_sub(self.workers));
        self.free -= 1;
        self.min_free = self.min_free.min(self.free);
        if is_short {
            self.short_turns += 1;
            self.expected_return = now.saturating_add(GRACE);
        }
        self.free += added;
        self.workers += added;
        added
    }

    /// A turn ended, or was given up and a new worker replaces its worker.
    pub(super) fn end_turn(&mut self, is_short: bool) {
        self.free += 1;
        self.short_turns -= usize::from(is_short);
    }

    /// Removes workers that the system refused to start, or that exit.
    pub(super) fn remove_workers(&mut self, workers: usize) {
        self.free -= workers;
        self.workers -= workers;
    }

    /// Returns until when an idle worker stays at least; `None` if there are no more workers than at the
    /// start.
    pub(super) fn idle_until(&self, now: Nanos) -> Option<Nanos> {
        (self.workers > self.min_workers).then(|| now.saturating_add(IDLE_TIMEOUT))
    }

    /// Returns whether a free worker exits, because others were free all the time.
    pub(super) fn try_retire(&mut self, now: Nanos) -> bool {
        if now < self.since.saturating_add(IDLE_TIMEOUT) {
            return false;
        }
        let retires = self.workers > self.min_workers && self.min_free > 1;
        if retires {
            self.remove_workers(1);
            self.min_free -= 1;
        } else {
            (self.min_free, self.since) = (self.free, now);
        }
        retires
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_free_worker_takes_no_turn_while_another_is_about_to_return() {
        let mut capacity = Capacity::new(2, 100);
        assert_eq!(capacity.deferred_until(7), None, "two workers are free");
        assert_eq!(capacity.begin_turn(7, true), 0);
        assert_eq!(capacity.deferred_until(7), Some(7 + GRACE));
        assert_eq!(
            capacity.deferred_until(7 + GRACE),
            None,
            "the other worker has not returned in time"
        );
        capacity.end_turn(true);
        assert_eq!(capacity.begin_turn(8, false), 0);
        assert_eq!(
            capacity.deferred_until(8),
            None,
            "the end of a long turn is not predictable"
        );
    }

    #[test]
    fn one_worker_is_free_however_many_take_turns() {
        let mut capacity = Capacity::new(2, 100);
        for turn in 0..100 {
            assert_eq!(capacity.begin_turn(0, false), usize::from(turn > 0));
        }
        assert_eq!((capacity.workers, capacity.free), (101, 1));
    }

    #[test]
    fn there_is_at_most_one_worker_more_than_schemas() {
        let mut capacity = Capacity::new(2, 5);
        (0..5).for_each(|turn| _ = capacity.begin_turn(turn * 2 * GRACE, true));
        assert_eq!((capacity.workers, capacity.free), (6, 1));
    }

    #[test]
    fn the_pool_waits_for_few_of_many_turns_that_take_unexpectedly_long() {
        let mut capacity = Capacity::new(2, 100);
        let (mut now, mut waits) = (0, 0);
        for _ in 0..100 {
            if let Some(until) = capacity.deferred_until(now) {
                (now, waits) = (until, waits + 1);
            }
            capacity.begin_turn(now, true);
        }
        assert_eq!(waits, 6, "2, 4, 8, 16, 32 and 64 were too few");
    }

    #[test]
    fn workers_that_were_not_needed_for_a_long_time_exit() {
        let mut capacity = Capacity::new(2, 100);
        (0..5).for_each(|_| _ = capacity.begin_turn(0, false));
        (0..5).for_each(|_| capacity.end_turn(false));
        assert_eq!((capacity.workers, capacity.free), (6, 6));
        assert!(capacity.idle_until(0) > Some(0));
        assert!(!capacity.try_retire(IDLE_TIMEOUT - 1));
        assert!(!capacity.try_retire(IDLE_TIMEOUT), "all were needed");
        capacity.begin_turn(IDLE_TIMEOUT, false);
        capacity.end_turn(false);
        let retired = (0..10).filter(|_| capacity.try_retire(2 * IDLE_TIMEOUT)).count();
        assert_eq!((retired, capacity.workers), (4, 2), "the initial workers stay");
        assert_eq!(capacity.idle_until(0), None);
    }
}
