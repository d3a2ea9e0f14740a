//! A schema's states over time: the share of every state in each column, and the sums over the whole time.

use jde_core::{Nanos, State};

use super::columns::Columns;

/// The states of a schema.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    /// For each column, the shares of time as WINNER, READY and CHECKING.
    shares: Vec<[f32; 3]>,
    /// Total times as WINNER, READY and CHECKING, ns.
    sums: [Nanos; 3],
}

impl Band {
    pub(crate) fn new(columns: Columns) -> Self {
        Self {
            shares: vec![[0.0; 3]; columns.count],
            sums: [0; 3],
        }
    }

    /// For each column, the share of time in at least this state.
    pub(crate) fn shares(&self, least: State) -> impl Iterator<Item = f32> {
        let kinds = kind(least).map_or(0, |kind| kind + 1);
        self.shares
            .iter()
            .map(move |shares| shares[..kinds].iter().sum::<f32>().min(1.0))
    }

    /// The total time in a state, ns; SLEPT does not count.
    pub(crate) fn time(&self, state: State) -> Nanos {
        kind(state).map_or(0, |kind| self.sums[kind])
    }

    /// Whether the schema was ever awake.
    pub(crate) fn was_awake(&self) -> bool {
        self.sums.iter().any(|sum| *sum > 0)
    }

    /// Adds an interval of a state.
    pub(crate) fn fill(&mut self, columns: Columns, state: State, from: Nanos, to: Nanos) {
        let Some(kind) = kind(state) else { return };
        let clamp = |time: Nanos| time.clamp(columns.from, columns.to);
        self.sums[kind] += clamp(to).saturating_sub(clamp(from));
        for (column, share) in columns.covered(from, to) {
            self.shares[column][kind] += share as f32;
        }
    }
}

/// The index of a state's sums; none for SLEPT.
fn kind(state: State) -> Option<usize> {
    match state {
        State::Winner => Some(0),
        State::Ready => Some(1),
        State::Checking => Some(2),
        State::Slept => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_summed_by_column_and_in_total() {
        let columns = Columns::new(0, 10_000, 5);
        let mut band = Band::new(columns);
        band.fill(columns, State::Checking, 0, 1000);
        band.fill(columns, State::Ready, 1000, 3000);
        band.fill(columns, State::Winner, 3000, 7000);
        band.fill(columns, State::Slept, 7000, 10_000);
        let shares = |least| band.shares(least).collect::<Vec<_>>();
        assert_eq!(shares(State::Winner), [0.0, 0.5, 1.0, 0.5, 0.0]);
        assert_eq!(shares(State::Ready), [0.5, 1.0, 1.0, 0.5, 0.0]);
        assert_eq!(shares(State::Checking), [1.0, 1.0, 1.0, 0.5, 0.0]);
        assert_eq!(
            (band.time(State::Winner), band.time(State::Checking)),
            (4000, 1000)
        );
        assert!(band.was_awake());
    }

    #[test]
    fn a_state_from_before_the_time_range_counts_within_it() {
        let columns = Columns::new(5000, 10_000, 5);
        let mut band = Band::new(columns);
        band.fill(columns, State::Winner, 1000, 20_000);
        assert_eq!(band.time(State::Winner), 5000);
        assert!(band.shares(State::Winner).all(|share| share == 1.0));
    }
}
