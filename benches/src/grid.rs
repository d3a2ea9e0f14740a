//! Where the deadlines of schemas of one kind lie that are woken at once (R11): what schemas keep is measured by it, and threads
//! beside them keep it too.

use std::time::Duration;

/// Most time between two that follow each other.
const STEP: Duration = Duration::from_millis(1);

/// The deadlines of one: the first, and then a period after each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    /// Since all were woken, ns.
    pub(crate) first: u64,
    /// ns.
    pub(crate) period: u64,
}

impl Grid {
    /// Of the one in that place among so many.
    pub(crate) fn of(place: usize, all: usize, period: Duration) -> Self {
        let period = period.as_nanos() as u64;
        let step = (period / all as u64).min(STEP.as_nanos() as u64);
        Self {
            first: period - (all - 1 - place) as u64 * step,
            period,
        }
    }

    /// Of as many as there are periods.
    pub(crate) fn all(periods: &[Duration]) -> Vec<Self> {
        let grids = periods.iter().enumerate();
        grids
            .map(|(place, period)| Self::of(place, periods.len(), *period))
            .collect()
    }

    /// How long after the last deadline something was, ns, if they were woken then; it was after the first.
    pub(crate) fn late(self, woken: u64, at: u64) -> u64 {
        (at - woken - self.first) % self.period
    }
}
