//! The way to the dock: through the places of the station, then by the tag.

use core::time::Duration;

/// Where it is on the way to the dock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// On the way to a place of the station.
    Approach(usize),
    /// At the dock, or before it.
    Dock,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Charge {
    /// Places of the station that it has passed.
    passed: usize,
    /// Since when it is on the way to the next one.
    since: Duration,
    /// When the child that docks was READY or the robot was docked last.
    ready_at: Duration,
}

impl Charge {
    pub(crate) fn begin(now: Duration) -> Self {
        Self {
            passed: 0,
            since: now,
            ready_at: now,
        }
    }

    /// Returns where it is, before a dock whose station has so many places.
    pub(crate) fn step(&self, places: usize) -> Step {
        if self.passed < places {
            Step::Approach(self.passed)
        } else {
            Step::Dock
        }
    }

    pub(crate) fn since(&self) -> Duration {
        self.since
    }

    /// Goes on to the next place.
    pub(crate) fn next(&mut self, now: Duration) {
        (self.passed, self.since, self.ready_at) = (self.passed + 1, now, now);
    }

    /// Returns whether the child that docks has not been READY for `patience`, and the robot is not docked.
    pub(crate) fn is_stuck(&mut self, now: Duration, is_ready: bool, patience: Duration) -> bool {
        if is_ready {
            self.ready_at = now;
        }
        now.saturating_sub(self.ready_at) > patience
    }
}
