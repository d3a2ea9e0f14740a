//! Reduces the values that arrive at a rate of the link to the requested rate. It never waits.

use jde_core::Nanos;
use jde_link::Rate;

/// Selects values on the time grid of a rate. A value that is slightly early or late does not cost another
/// one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RateLimiter {
    period: Nanos,
    /// Half the time between two arriving values: a value early by at most this is on time.
    tolerance: Nanos,
    /// When the next value is on time. The first value always is.
    due: Nanos,
}

impl RateLimiter {
    /// Selects `hz` values per second of those that arrive at a rate not below `hz`.
    pub(super) fn new(hz: f64, from: Rate) -> Self {
        Self {
            period: (1e9 / hz) as Nanos,
            tolerance: match from {
                Rate::Hz(hz) => 500_000_000 / u64::from(hz.max(1)),
                Rate::Full => 0,
            },
            due: 0,
        }
    }

    /// Whether the value of this time is selected.
    pub(super) fn accept(&mut self, time: Nanos) -> bool {
        if time.saturating_add(self.tolerance) < self.due {
            return false;
        }
        // A value that is later than that starts a new grid.
        let on_time = time <= self.due.saturating_add(self.tolerance);
        let from = if on_time { self.due } else { time };
        self.due = from.saturating_add(self.period);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The selected ones of values that arrive at these times, in ms.
    fn selected(hz: f64, times: impl IntoIterator<Item = u64>) -> Vec<u64> {
        let mut limiter = RateLimiter::new(hz, Rate::at_least(hz));
        let times = times.into_iter();
        times.filter(|time| limiter.accept(time * 1_000_000)).collect()
    }

    #[test]
    fn a_rate_that_the_link_does_not_offer_is_kept() {
        assert_eq!(
            selected(0.5, [7010, 8000, 9000, 10_030, 10_990]),
            [7010, 9000, 10_990]
        );
        assert_eq!(selected(3.0, (0..50).map(|step| step * 200)).len(), 30);
    }

    #[test]
    fn uneven_values_at_an_offered_rate_are_all_selected() {
        let uneven = [3000, 3210, 3390, 3600, 3810, 3990];
        assert_eq!(selected(5.0, uneven), uneven);
    }

    #[test]
    fn values_missed_in_a_pause_are_not_made_up_for() {
        assert_eq!(
            selected(0.5, [0, 9000, 10_000, 11_000, 12_000]),
            [0, 9000, 11_000]
        );
    }
}
