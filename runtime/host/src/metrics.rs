//! Counts and times of one instance, written by its runner and read by any thread. It evaluates nothing.

use std::sync::atomic::{
    AtomicBool, AtomicU64,
    Ordering::{Acquire, Relaxed, Release},
};

use jde_core::{Nanos, SchemaId};
use parking_lot::{Mutex, MutexGuard};

/// The divisor of the weight of a new interval: a mean follows a change of period within a second or two.
const MEAN_WEIGHT: i64 = 8;

/// A judgement of a guard within a call of another schema (R18).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RunningJudgement {
    pub(crate) guard: SchemaId,
    pub(crate) since: Nanos,
}

/// The measurements of an instance.
#[derive(Debug, Default)]
pub(crate) struct InstanceMetrics {
    pub(crate) iterations: AtomicU64,
    pub(crate) overruns: AtomicU64,
    pub(crate) refused: AtomicU64,
    pub(crate) faults: AtomicU64,
    /// Triggers that were dropped or had to rest (R12).
    pub(crate) triggers_dropped: AtomicU64,
    /// Calls that were given up and have not returned.
    pub(crate) abandoned_calls: AtomicU64,
    pub(crate) longest_iteration: AtomicU64,
    /// In lockstep, the turns that took longer than the budget by the machine's clock, and the longest of them.
    pub(crate) slow_turns: AtomicU64,
    pub(crate) slowest_turn: AtomicU64,
    pub(crate) period: AtomicU64,
    /// Whether an iteration has succeeded.
    pub(crate) started: AtomicBool,
    /// Since when a call runs, plus one; 0 while none runs.
    running_since: AtomicU64,
    /// How long judgements of guards took within that call, ns: they count for the guards.
    judged: AtomicU64,
    /// The judgement that runs within that call.
    judgement: Mutex<Option<RunningJudgement>>,
    /// Whether a debugger held a call since the last turn that was judged.
    was_held: AtomicBool,
    /// The ticket of the last arbitration that it was called for, and the time of the call.
    arbitration_ticket: AtomicU64,
    arbitration_started: AtomicU64,
    last_cycle: AtomicU64,
    mean_cycle: AtomicU64,
    mean_busy: AtomicU64,
    /// The time of the turns since the last cycle that were not periodic.
    busy_between: AtomicU64,
}

impl InstanceMetrics {
    /// Records an iteration and its duration.
    pub(crate) fn record_iteration(&self, took: Nanos) {
        // One thread at a time writes these, so no atomic read-modify-write is needed.
        self.iterations.store(self.iterations.load(Relaxed) + 1, Relaxed);
        if took > self.longest_iteration.load(Relaxed) {
            self.longest_iteration.store(took, Relaxed);
        }
    }

    /// Records how long a turn took by the machine's clock.
    pub(crate) fn record_machine_time(&self, took: Nanos, budget: Nanos) {
        if took > budget {
            self.slow_turns.store(self.slow_turns.load(Relaxed) + 1, Relaxed);
            self.slowest_turn.fetch_max(took, Relaxed);
        }
    }

    /// Records the start of a call.
    pub(crate) fn begin_call(&self, now: Nanos) {
        self.judged.store(0, Relaxed);
        self.running_since.store(now + 1, Relaxed);
    }

    /// Records that a guard judges a command of this call.
    pub(crate) fn begin_judgement(&self, guard: SchemaId, since: Nanos) -> RunningJudgement {
        *self.judgement() = Some(RunningJudgement { guard, since });
        RunningJudgement { guard, since }
    }

    /// Records the end of that judgement, unless it was given up.
    pub(crate) fn end_judgement(&self, ended: RunningJudgement, now: Nanos) {
        let mut judgement = self.judgement();
        if *judgement == Some(ended) {
            *judgement = None;
            self.judged.fetch_add(now.saturating_sub(ended.since), Relaxed);
        }
    }

    /// Returns the judgement that runs within the call, if one does.
    pub(crate) fn running_judgement(&self) -> Option<RunningJudgement> {
        *self.judgement()
    }

    /// Gives up the judgement that runs.
    pub(crate) fn give_up_judgement(&self) {
        *self.judgement() = None;
    }

    /// Returns how long judgements took within the call that runs, ns.
    pub(crate) fn judged(&self) -> Nanos {
        self.judged.load(Relaxed)
    }

    fn judgement(&self) -> MutexGuard<'_, Option<RunningJudgement>> {
        self.judgement.lock()
    }

    /// Records that a debugger holds the call that runs. Until the next [`Self::begin_call`] it has taken no time.
    pub(crate) fn hold_call(&self) {
        self.was_held.store(true, Relaxed);
        self.running_since.store(Nanos::MAX, Relaxed);
    }

    /// Whether a debugger held a call since this was asked last.
    pub(crate) fn take_held(&self) -> bool {
        self.was_held.load(Relaxed) && self.was_held.swap(false, Relaxed)
    }

    /// Records the end of a call.
    pub(crate) fn end_call(&self) {
        self.running_since.store(0, Release);
    }

    /// Returns since when a call runs; `None` while none runs.
    pub(crate) fn running_since(&self) -> Option<Nanos> {
        self.running_since.load(Acquire).checked_sub(1)
    }

    /// Records that the instance is about to be called for an arbitration.
    pub(crate) fn begin_arbitration(&self, ticket: u64, now: Nanos) {
        self.arbitration_started.store(now, Relaxed);
        self.arbitration_ticket.store(ticket, Release);
    }

    /// Whether another call runs, or the call for that arbitration began by `latest`, even if it has
    /// returned.
    pub(crate) fn is_busy_with(&self, ticket: Option<u64>, latest: Nanos) -> bool {
        // In this order: a call seen as returned has stored its ticket before.
        let is_running = self.running_since().is_some();
        match ticket == Some(self.arbitration_ticket.load(Acquire)) {
            true => self.arbitration_started.load(Relaxed) <= latest,
            false => is_running,
        }
    }

    /// Records a turn between two cycles, which took `busy`.
    pub(crate) fn record_between(&self, busy: Nanos) {
        self.busy_between
            .store(self.busy_between.load(Relaxed) + busy, Relaxed);
    }

    /// Records a periodic cycle that began at `start` and took `busy`.
    pub(crate) fn record_cycle(&self, start: Nanos, busy: Nanos) {
        let last = self.last_cycle.load(Relaxed);
        self.last_cycle.store(start + 1, Relaxed);
        if last != 0 {
            update_mean(&self.mean_cycle, (start + 1).saturating_sub(last));
        }
        let between = self.busy_between.load(Relaxed);
        if between != 0 {
            self.busy_between.store(0, Relaxed);
        }
        update_mean(&self.mean_busy, busy + between);
    }

    /// The instance falls asleep: the following pause is no cycle.
    pub(crate) fn pause(&self) {
        self.last_cycle.store(0, Relaxed);
    }

    /// Returns the mean time between cycles; `None` before the second cycle.
    fn mean_cycle(&self) -> Option<Nanos> {
        Some(self.mean_cycle.load(Relaxed)).filter(|mean| *mean > 0)
    }

    /// Returns the mean time between cycles; `None` before the second cycle, and when the next one is late by more than
    /// that mean, because the mean is no longer true.
    pub(crate) fn mean_period(&self, now: Nanos) -> Option<Nanos> {
        let last = self.last_cycle.load(Relaxed);
        let since = last.checked_sub(1).map_or(0, |last| now.saturating_sub(last));
        self.mean_cycle().filter(|mean| since / 2 <= *mean)
    }

    /// Returns the share of time spent in turns, periodic or not.
    pub(crate) fn load(&self) -> f64 {
        match self.mean_cycle() {
            Some(cycle) => (self.mean_busy.load(Relaxed) as f64 / cycle as f64).min(1.0),
            None => 0.0,
        }
    }
}

/// Updates a mean in integer arithmetic, because conversions to and from floating point take longer.
fn update_mean(mean: &AtomicU64, new: Nanos) {
    let old = mean.load(Relaxed);
    let blended = if old == 0 {
        new
    } else {
        let step = new.wrapping_sub(old).cast_signed();
        old.wrapping_add_signed((step + MEAN_WEIGHT / 2).div_euclid(MEAN_WEIGHT))
    };
    mean.store(blended, Relaxed);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_moves_an_eighth_of_the_way_rounded_to_a_nanosecond() {
        let mean = AtomicU64::default();
        let mean_after = |new| {
            update_mean(&mean, new);
            mean.load(Relaxed)
        };
        assert_eq!(mean_after(1000), 1000, "the first value is the mean");
        assert_eq!(mean_after(1800), 1100);
        assert_eq!(mean_after(300), 1000);
        assert_eq!(mean_after(1003), 1000);
        assert_eq!(mean_after(1004), 1001);
        assert_eq!(mean_after(0), 876);
    }

    #[test]
    fn a_mean_period_is_unknown_while_a_cycle_is_late_by_more_than_it() {
        let metrics = InstanceMetrics::default();
        metrics.record_cycle(0, 10);
        assert_eq!(metrics.mean_period(50), None);
        metrics.record_cycle(100, 10);
        assert_eq!(metrics.mean_period(300), Some(100));
        assert_eq!(metrics.mean_period(302), None);
        metrics.pause();
        assert_eq!(metrics.mean_period(10_000), Some(100), "a pause is no cycle");
    }
}
