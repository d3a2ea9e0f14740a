//! How often a variable is published, estimated from the stamps of its values. It is not exact:
//! writers may race.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::Nanos;

/// The inverse of the newest interval's weight: the mean covers about the last eight intervals.
const AVERAGED_INTERVALS: u64 = 8;
/// The longest interval that counts, in mean intervals. So the rate of a schema that slept soon becomes right
/// again.
const MAX_INTERVAL: u64 = 4;

/// Exponential average of the intervals between values. Writers write it at each publication, so it has a
/// cache line of its own: readers read the adjacent data.
#[derive(Default)]
#[repr(align(64))]
pub(crate) struct Rate {
    /// Mean interval in nanoseconds; 0 until there are two values.
    interval: AtomicU64,
    /// Time of the last value, plus one; 0 until there is one.
    last: AtomicU64,
}

impl Rate {
    pub(crate) fn record(&self, time: Nanos) {
        let last = self.last.load(Ordering::Relaxed);
        self.last.store(time.saturating_add(1), Ordering::Relaxed);
        let Some(interval) = last.checked_sub(1).and_then(|last| time.checked_sub(last)) else {
            return;
        };
        let mean = self.interval.load(Ordering::Relaxed);
        let mean = if mean == 0 {
            interval
        } else {
            let interval = interval.min(mean.saturating_mul(MAX_INTERVAL));
            mean - mean / AVERAGED_INTERVALS + interval / AVERAGED_INTERVALS
        };
        self.interval.store(mean, Ordering::Relaxed);
    }

    /// Returns the values per second. The rate falls while no value arrives. 0 until there are two values.
    pub(crate) fn hz(&self, age: Nanos) -> f64 {
        let mean = self.interval.load(Ordering::Relaxed);
        if mean == 0 {
            return 0.0;
        }
        1e9 / mean.max(age) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Nanos = 10_000_000;

    fn rate_of(times: impl IntoIterator<Item = Nanos>) -> Rate {
        let rate = Rate::default();
        times.into_iter().for_each(|time| rate.record(time));
        rate
    }

    #[test]
    fn one_value_has_no_rate() {
        assert_eq!(rate_of([5]).hz(0), 0.0);
    }

    #[test]
    fn the_rate_of_regular_values_is_exact() {
        let rate = rate_of((0..50).map(|n| n * PERIOD));
        assert!((rate.hz(0) - 100.0).abs() < 1e-6, "{}", rate.hz(0));
    }

    #[test]
    fn the_rate_falls_while_no_value_arrives() {
        let rate = rate_of((0..50).map(|n| n * PERIOD));
        assert!((rate.hz(1_000_000_000) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_rate_recovers_soon_after_a_long_pause() {
        let hour = 3_600_000_000_000;
        let rate = rate_of(
            (0..50)
                .map(|n| n * PERIOD)
                .chain((0..30).map(|n| hour + n * PERIOD)),
        );
        assert!((rate.hz(0) - 100.0).abs() < 5.0, "{}", rate.hz(0));
    }

    #[test]
    fn stamps_that_run_backwards_are_ignored() {
        let rate = rate_of([PERIOD, 2 * PERIOD, 0, PERIOD, 2 * PERIOD]);
        assert!((rate.hz(0) - 100.0).abs() < 1e-6);
    }
}
