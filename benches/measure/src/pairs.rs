//! Measures several operations in turn, so that the load of the machine affects all of them equally, and
//! compares what was measured in the same round. Never compares one run with another.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// A measured operation; the argument is the number of repetitions.
pub type Side<'a> = &'a mut dyn FnMut(u64);

/// Forces the computation of a result, and discards it.
#[inline(always)]
pub fn see<T>(result: T) {
    let _ = black_box(result);
}

/// The times of one side, one per round.
#[derive(Clone, Debug)]
pub struct Rounds(Vec<f64>);

/// The extent of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// The number of rounds.
    pub rounds: usize,
    /// The time of each side in each round.
    pub batch: Duration,
}

impl Rounds {
    /// Wraps values that were measured elsewhere, in the order of the rounds, in ns or any common unit.
    pub fn of(values: Vec<f64>) -> Self {
        Self(values)
    }

    /// Returns the median.
    pub fn median(&self) -> f64 {
        median(self.0.clone())
    }

    /// Returns the median of the ratios of both sides in the same round.
    pub fn by(&self, other: &Self) -> f64 {
        median(
            self.0
                .iter()
                .zip(&other.0)
                .map(|(ours, theirs)| ours / theirs)
                .collect(),
        )
    }
}

/// Returns the time of one operation of each side in each round, ns. Each round begins with a different side.
pub fn interleave<const SIDES: usize>(effort: Effort, mut sides: [Side<'_>; SIDES]) -> [Rounds; SIDES] {
    let batches = sides.each_mut().map(|side| batch(effort.batch, side));
    let mut all = [const { Vec::new() }; SIDES];
    for round in 0..effort.rounds {
        for turn in 0..SIDES {
            let place = (round + turn) % SIDES;
            let start = Instant::now();
            sides[place](batches[place]);
            all[place].push(start.elapsed().as_nanos() as f64 / batches[place] as f64);
        }
    }
    all.map(Rounds)
}

/// Returns how many operations of a side take about the target time.
fn batch(target: Duration, side: &mut Side<'_>) -> u64 {
    let mut count = 1;
    loop {
        let start = Instant::now();
        side(count);
        let took = start.elapsed();
        if took * 2 >= target {
            let each = took.as_nanos() as f64 / count as f64;
            return ((target.as_nanos() as f64 / each) as u64).max(1);
        }
        count *= 2;
    }
}

/// Returns the median, or NaN if there are no values.
pub fn median(values: Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

/// Returns the value below which the given share of values lies, or NaN if there are no values.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values
        .get((last as f64 * share).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_is_that_of_the_same_round() {
        // A machine that is ten times slower in one round slows both sides.
        let ours = Rounds(vec![2.0, 20.0, 2.0]);
        let theirs = Rounds(vec![1.0, 10.0, 1.0]);
        assert_eq!(ours.by(&theirs), 2.0);
        assert_eq!(ours.median(), 2.0);
    }

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(quantile(values.clone(), 0.99), 99.0);
        assert_eq!(median(values), 50.0);
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn every_side_is_measured_in_every_round() {
        let (mut one, mut two) = (0, 0);
        let effort = Effort {
            rounds: 7,
            batch: Duration::from_micros(10),
        };
        let side = |calls: &mut u32, times: u64| {
            *calls += 1;
            (0..times).for_each(|_| see(()));
        };
        let [a, b] = interleave(effort, [&mut |n| side(&mut one, n), &mut |n| side(&mut two, n)]);
        assert_eq!((a.0.len(), b.0.len()), (7, 7));
        assert!(one > 7 && two > 7);
    }
}
