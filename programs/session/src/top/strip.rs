//! The recent states of a schema, as the cells of its strip.

use jde_core::{Nanos, State};
use jde_timeline::{Keep, LogLimits, SchemaTimeline};

/// What a view keeps: of the states at 20 snapshots a second at least the last three minutes, and more switches than the
/// tallest terminals show.
pub(super) const KEEP: Keep = Keep {
    intervals: 4096,
    marks: 0,
    switches: MAX_SWITCHES,
    records: LogLimits {
        records: 0,
        candidates: 0,
        switches: 0,
    },
    ended: false,
};
pub(super) const MAX_SWITCHES: usize = 100;

/// What a cell shows of a schema, from the least to the most active.
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

impl From<State> for StripState {
    fn from(state: State) -> Self {
        match state {
            State::Slept => Self::Slept,
            State::Checking => Self::Checking,
            State::Ready => Self::Ready,
            State::Winner => Self::Winner,
        }
    }
}

/// Returns the last `count` cells of `slice` ns each, oldest first: the most active state in each.
pub(super) fn cells(
    schema: &SchemaTimeline,
    now: Nanos,
    slice: Nanos,
    count: usize,
) -> impl Iterator<Item = Option<StripState>> {
    let states = schema.states.slices(now, slice, count, StripState::from);
    let faulted = schema.faulted.slices(now, slice, count, |faulted| faulted);
    let cells = states.into_iter().zip(faulted);
    cells.map(|(state, faulted)| match faulted {
        Some(true) => Some(StripState::Faulted),
        Some(false) | None => state,
    })
}
