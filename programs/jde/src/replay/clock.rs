//! The clock of playback: the position at a given instant and speed. Reads no clock itself.

use std::time::{Duration, Instant};

use jde_core::Nanos;

/// A position that advances at a speed.
pub(super) struct PlaybackClock {
    /// The position at the instant `since`, in ns.
    position: Nanos,
    /// The instant of `position`.
    since: Instant,
    /// Seconds of the recording per second since then.
    speed: f64,
}

impl PlaybackClock {
    /// Starts at a position and an instant.
    pub(super) fn new(position: Nanos, now: Instant, speed: f64) -> Self {
        Self {
            position,
            since: now,
            speed,
        }
    }

    /// Returns the position at `now`. From then on it advances at `speed`.
    pub(super) fn advance(&mut self, now: Instant, speed: f64) -> Nanos {
        let passed = now.saturating_duration_since(self.since).as_secs_f64();
        let position = self.position + (passed * self.speed * 1e9) as Nanos;
        if speed != self.speed {
            *self = Self::new(position, now, speed);
        }
        position
    }

    /// Returns the time that it takes from one position to another.
    pub(super) fn time_until(&self, position: Nanos, due: Nanos) -> Duration {
        Duration::from_secs_f64(due.saturating_sub(position) as f64 / 1e9 / self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_speed_applies_from_the_current_position() {
        let start = Instant::now();
        let after = |seconds: u64| start + Duration::from_secs(seconds);
        let mut clock = PlaybackClock::new(5_000_000_000, start, 1.0);
        assert_eq!(clock.advance(after(60), 1.0), 65_000_000_000);
        assert_eq!(clock.advance(after(60), 10.0), 65_000_000_000);
        assert_eq!(clock.advance(after(61), 10.0), 75_000_000_000);
        assert_eq!(
            clock.time_until(75_000_000_000, 80_000_000_000),
            Duration::from_millis(500)
        );
        assert_eq!(clock.advance(after(62), 0.5), 85_000_000_000);
        assert_eq!(clock.advance(after(64), 0.5), 86_000_000_000);
    }
}
