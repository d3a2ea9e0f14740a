//! The way to the dock: through the places of the station, then by the tag.

use jde_schema::prelude::*;

use crate::wait::Wait;

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
    /// How long it neither docks nor charges.
    wait: Wait,
}

impl Charge {
    pub(crate) fn begin(now: Duration) -> Self {
        Self::resume(now, 0)
    }

    /// Goes on behind so many places, as before a reload.
    pub(crate) fn resume(now: Duration, passed: usize) -> Self {
        Self {
            passed,
            since: now,
            wait: Wait::begin(now),
        }
    }

    pub(crate) fn passed(&self) -> usize {
        self.passed
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
        *self = Self::resume(now, self.passed + 1);
    }

    /// Returns whether it has waited for `patience` before the dock, or at it without being charged.
    pub(crate) fn is_stuck(&mut self, cx: &Context, dock: &Child, charges: bool, patience: Duration) -> bool {
        self.wait.ends(cx, dock, charges, patience)
    }

    /// Begins anew to wait for the dock.
    pub(crate) fn wait_anew(&mut self, now: Duration) {
        self.wait = Wait::begin(now);
    }
}
