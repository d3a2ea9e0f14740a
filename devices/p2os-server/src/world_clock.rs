//! Converts the machine's time to the world's. When the machine stalls, the world stalls too, so that no
//! robot continues without its client.

use core::time::Duration;
use std::time::Instant;

/// The longest delay of the machine that the world catches up with. The rest is skipped.
const MAX_BACKLOG: Duration = Duration::from_millis(200);

/// The clock of the world, as a function of the machine's.
#[derive(Debug)]
pub(crate) struct WorldClock {
    last: Instant,
    world: Duration,
    speed: f64,
}

impl WorldClock {
    /// Starts at a time of the world.
    pub(crate) fn new(world: Duration, speed: f64) -> Self {
        Self {
            last: Instant::now(),
            world,
            speed,
        }
    }

    /// Returns the world's present time.
    pub(crate) fn now(&mut self) -> Duration {
        let now = Instant::now();
        let passed = now.duration_since(self.last).min(MAX_BACKLOG);
        self.last = now;
        self.world += passed.mul_f64(self.speed);
        self.world
    }

    /// Limits the backlog of a world that has only reached `world` to [`MAX_BACKLOG`] of the machine's time.
    pub(crate) fn limit_backlog(&mut self, world: Duration) {
        self.world = self.world.min(world + MAX_BACKLOG.mul_f64(self.speed));
    }

    /// Returns the machine's time until a time of the world.
    pub(crate) fn until(&self, time: Duration) -> Duration {
        time.saturating_sub(self.world).div_f64(self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stalled_clock_catches_up_by_a_bounded_time() {
        let mut clock = WorldClock::new(Duration::from_secs(5), 1.0);
        clock.last = Instant::now()
            .checked_sub(Duration::from_secs(60))
            .expect("the machine runs for a minute");
        assert_eq!(clock.now(), Duration::from_secs(5) + MAX_BACKLOG);
    }

    #[test]
    fn the_backlog_of_a_slow_world_is_bounded() {
        let mut clock = WorldClock::new(Duration::from_secs(100), 2.0);
        clock.limit_backlog(Duration::from_secs(40));
        assert_eq!(clock.world, Duration::from_secs(40) + 2 * MAX_BACKLOG);
        clock.limit_backlog(Duration::from_secs(40));
        assert_eq!(clock.world, Duration::from_secs(40) + 2 * MAX_BACKLOG);
    }

    #[test]
    fn waiting_times_are_divided_by_the_speed() {
        let clock = WorldClock::new(Duration::ZERO, 4.0);
        assert_eq!(clock.until(Duration::from_secs(1)), Duration::from_millis(250));
    }
}
