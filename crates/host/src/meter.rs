//! Counts and times of one instance, written by its runner and read by any thread. It judges nothing.

use std::sync::atomic::{
    AtomicBool, AtomicU64,
    Ordering::{Acquire, Relaxed, Release},
};

use jde_core::Nanos;

/// A new interval counts an eighth in a mean: means follow a change of period within a second or two and are
/// still steady.
const SHARE: i64 = 8;

/// The measurements of an instance.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    pub(crate) iterations: AtomicU64,
    pub(crate) overruns: AtomicU64,
    pub(crate) refused: AtomicU64,
    pub(crate) faults: AtomicU64,
    /// Calls that were given up and have not returned.
    pub(crate) left: AtomicU64,
    pub(crate) longest: AtomicU64,
    pub(crate) period: AtomicU64,
    /// Whether an iteration has succeeded.
    pub(crate) started: AtomicBool,
    /// Since when a call runs, plus one; 0 while none runs.
    running_since: AtomicU64,
    /// The ticket of the question that it was last called to answer, and when.
    took_up: AtomicU64,
    took_up_at: AtomicU64,
    last_cycle: AtomicU64,
    mean_cycle: AtomicU64,
    mean_busy: AtomicU64,
}

impl Meter {
    /// Records an iteration and its duration.
    pub(crate) fn iterated(&self, took: Nanos) {
        // One thread at a time writes these, so no atomic read-modify-write is needed.
        self.iterations.store(self.iterations.load(Relaxed) + 1, Relaxed);
        if took > self.longest.load(Relaxed) {
            self.longest.store(took, Relaxed);
        }
    }

    /// Records the start of a call.
    pub(crate) fn enter(&self, now: Nanos) {
        self.running_since.store(now + 1, Relaxed);
    }

    /// Records the end of a call.
    pub(crate) fn leave(&self) {
        self.running_since.store(0, Release);
    }

    /// Since when a call runs.
    pub(crate) fn running_since(&self) -> Option<Nanos> {
        self.running_since.load(Acquire).checked_sub(1)
    }

    /// Records that the instance is about to be called to answer that question.
    pub(crate) fn take_up(&self, ticket: u64, now: Nanos) {
        self.took_up_at.store(now, Relaxed);
        self.took_up.store(ticket, Release);
    }

    /// Whether another call runs, or the call to answer that question began by `latest`, even if it has
    /// returned.
    pub(crate) fn is_busy_with(&self, ticket: Option<u64>, latest: Nanos) -> bool {
        // In this order: a call seen as returned has stored its ticket before.
        let runs = self.running_since().is_some();
        match ticket == Some(self.took_up.load(Acquire)) {
            true => self.took_up_at.load(Relaxed) <= latest,
            false => runs,
        }
    }

    /// Records a periodic cycle that began at `start` and took `busy`.
    pub(crate) fn cycle(&self, start: Nanos, busy: Nanos) {
        let last = self.last_cycle.load(Relaxed);
        self.last_cycle.store(start + 1, Relaxed);
        if last != 0 {
            blend(&self.mean_cycle, (start + 1).saturating_sub(last));
        }
        blend(&self.mean_busy, busy);
    }

    /// The instance falls asleep: the following pause is no cycle.
    pub(crate) fn pause(&self) {
        self.last_cycle.store(0, Relaxed);
    }

    /// Mean time between cycles, once there were two.
    pub(crate) fn measured(&self) -> Option<Nanos> {
        Some(self.mean_cycle.load(Relaxed)).filter(|mean| *mean > 0)
    }

    /// Share of time spent in calls.
    pub(crate) fn load(&self) -> f64 {
        match self.measured() {
            Some(cycle) => (self.mean_busy.load(Relaxed) as f64 / cycle as f64).min(1.0),
            None => 0.0,
        }
    }
}

/// Updates a mean in integer arithmetic: conversion to floating point and back is a chain of dependent
/// instructions.
fn blend(mean: &AtomicU64, new: Nanos) {
    let old = mean.load(Relaxed);
    let blended = if old == 0 {
        new
    } else {
        let step = new.wrapping_sub(old).cast_signed();
        old.wrapping_add_signed((step + SHARE / 2).div_euclid(SHARE))
    };
    mean.store(blended, Relaxed);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_goes_an_eighth_of_the_way_to_the_nearest_nanosecond() {
        let mean = AtomicU64::default();
        let after = |new| {
            blend(&mean, new);
            mean.load(Relaxed)
        };
        assert_eq!(after(1000), 1000, "the first is the mean");
        assert_eq!(after(1800), 1100);
        assert_eq!(after(300), 1000);
        assert_eq!(after(1003), 1000);
        assert_eq!(after(1004), 1001);
        assert_eq!(after(0), 876);
    }
}
