//! The clock of a recording that plays: where it is by now, at the speed that is wanted. It does not look at any clock itself.

use std::time::{Duration, Instant};

use jde_core::Nanos;

/// A place that moves on at a speed.
pub(super) struct Pace {
    /// Where it was,
    place: Nanos,
    /// at that instant,
    since: Instant,
    /// s of the recording in a second since.
    speed: f64,
}

impl Pace {
    /// Goes on from a place at an instant.
    pub(super) fn new(place: Nanos, now: Instant, speed: f64) -> Self {
        Self {
            place,
            since: now,
            speed,
        }
    }

    /// Where it is by now; from now on it goes at that speed.
    pub(super) fn place(&mut self, now: Instant, speed: f64) -> Nanos {
        let passed = now.saturating_duration_since(self.since).as_secs_f64();
        let place = self.place + (passed * self.speed * 1e9) as Nanos;
        if speed != self.speed {
            *self = Self::new(place, now, speed);
        }
        place
    }

    /// How long it takes from one place to another.
    pub(super) fn until(&self, place: Nanos, due: Nanos) -> Duration {
        Duration::from_secs_f64(due.saturating_sub(place) as f64 / 1e9 / self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_speed_counts_from_where_it_is_and_not_for_what_has_passed() {
        let start = Instant::now();
        let after = |seconds: u64| start + Duration::from_secs(seconds);
        let mut pace = Pace::new(5_000_000_000, start, 1.0);
        assert_eq!(pace.place(after(60), 1.0), 65_000_000_000);
        assert_eq!(pace.place(after(60), 10.0), 65_000_000_000);
        assert_eq!(pace.place(after(61), 10.0), 75_000_000_000);
        assert_eq!(
            pace.until(75_000_000_000, 80_000_000_000),
            Duration::from_millis(500)
        );
        assert_eq!(pace.place(after(62), 0.5), 85_000_000_000);
        assert_eq!(pace.place(after(64), 0.5), 86_000_000_000);
    }
}
