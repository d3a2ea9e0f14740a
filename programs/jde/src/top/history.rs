//! The recent states of every schema: the data of the strips.
//!
//! It stores changes instead of samples, so a schema without changes needs no more memory. It does not depend
//! on the width of the terminal.

use std::collections::VecDeque;

use jde_core::{Health, Nanos, State};
use jde_records::snapshot::Snapshot;

/// Changes kept for a schema: with 20 snapshots per second, at least the last three minutes.
const MAX_CHANGES: usize = 4096;

/// What a strip shows of a schema, ordered from the least to the most active.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum StripState {
    /// SLEPT.
    Slept,
    /// CHECKING.
    Checking,
    /// READY.
    Ready,
    /// WINNER.
    Winner,
    /// Faulted, in any state.
    Faulted,
}

/// The changes of all schemas since the view was opened.
#[derive(Debug, Default)]
pub(super) struct History {
    changes: Vec<VecDeque<(Nanos, StripState)>>,
    now: Nanos,
}

impl StripState {
    pub(super) fn of(state: State, health: &Health) -> Self {
        match (health, state) {
            (Health::Faulted(_), _) => Self::Faulted,
            (_, State::Slept) => Self::Slept,
            (_, State::Checking) => Self::Checking,
            (_, State::Ready) => Self::Ready,
            (_, State::Winner) => Self::Winner,
        }
    }
}

impl History {
    /// Adds a snapshot. One from the past, or with another number of schemas, starts a new history.
    pub(super) fn observe(&mut self, snapshot: &Snapshot) {
        if snapshot.time < self.now || snapshot.schemas.len() != self.changes.len() {
            self.changes = vec![VecDeque::new(); snapshot.schemas.len()];
        }
        self.now = snapshot.time;
        for (changes, schema) in self.changes.iter_mut().zip(&snapshot.schemas) {
            let strip_state = StripState::of(schema.state, &schema.health);
            if changes.back().is_none_or(|(_, last)| *last != strip_state) {
                changes.push_back((snapshot.time, strip_state));
                if changes.len() > MAX_CHANGES {
                    changes.pop_front();
                }
            }
        }
    }

    /// Returns the last `count` slices of `slice` ns each, oldest first: the most active state seen in each.
    ///
    /// The most active, so that a win shorter than a slice is still visible. `None` where there was no
    /// snapshot. Slices begin at whole multiples of their length, so that past slices do not change while
    /// time advances.
    pub(super) fn slices(&self, schema: usize, slice: Nanos, count: usize) -> Vec<Option<StripState>> {
        let mut slices = vec![None; count];
        let Some(changes) = self.changes.get(schema) else {
            return slices;
        };
        let slice = slice.max(1);
        let first = (self.now / slice + 1).saturating_sub(count as u64);
        let offset = count as u64 - (self.now / slice + 1 - first);
        let mut end = self.now + 1;
        for &(start, strip_state) in changes.iter().rev() {
            if end <= first * slice {
                break;
            }
            // Of two changes at the same time, the earlier one had no duration.
            if start < end {
                for index in (start / slice).max(first)..=(end - 1) / slice {
                    let entry = &mut slices[(index - first + offset) as usize];
                    *entry = (*entry).max(Some(strip_state));
                }
            }
            end = start;
        }
        slices
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::tests::{schema, snapshot};

    const MS: Nanos = 1_000_000;

    fn history(snapshots: &[(Nanos, State)]) -> History {
        let mut history = History::default();
        for (time, state) in snapshots {
            let mut goon = schema("goon");
            goon.state = *state;
            history.observe(&snapshot(time * MS, vec![goon], vec![]));
        }
        history
    }

    #[test]
    fn a_slice_before_the_first_snapshot_is_empty() {
        let history = history(&[(450, State::Checking)]);
        assert_eq!(
            history.slices(0, 100 * MS, 3),
            [None, None, Some(StripState::Checking)]
        );
    }

    #[test]
    fn a_state_lasts_until_the_next_change() {
        let history = history(&[(0, State::Slept), (210, State::Ready), (399, State::Ready)]);
        let (slept, ready) = (Some(StripState::Slept), Some(StripState::Ready));
        assert_eq!(history.slices(0, 100 * MS, 4), [slept, slept, ready, ready]);
    }

    #[test]
    fn a_short_win_is_shown_in_its_slice() {
        let history = history(&[
            (0, State::Checking),
            (130, State::Winner),
            (150, State::Checking),
            (250, State::Checking),
        ]);
        let (checking, winner) = (Some(StripState::Checking), Some(StripState::Winner));
        assert_eq!(history.slices(0, 100 * MS, 3), [checking, winner, checking]);
    }

    #[test]
    fn a_change_on_the_edge_belongs_to_the_new_slice() {
        let history = history(&[(0, State::Winner), (100, State::Slept), (150, State::Slept)]);
        assert_eq!(
            history.slices(0, 100 * MS, 2),
            [Some(StripState::Winner), Some(StripState::Slept)]
        );
    }

    #[test]
    fn the_strip_moves_by_whole_slices() {
        let history = history(&[(0, State::Winner), (1000, State::Slept), (1199, State::Slept)]);
        assert_eq!(
            history.slices(0, 100 * MS, 3),
            [
                Some(StripState::Winner),
                Some(StripState::Slept),
                Some(StripState::Slept)
            ]
        );
    }

    #[test]
    fn a_decreasing_time_starts_a_new_history() {
        let history = history(&[(5000, State::Winner), (100, State::Ready)]);
        assert_eq!(history.slices(0, 100 * MS, 2), [None, Some(StripState::Ready)]);
    }

    #[test]
    fn an_unknown_schema_has_no_history() {
        assert_eq!(history(&[(0, State::Ready)]).slices(7, MS, 2), [None, None]);
    }
}
