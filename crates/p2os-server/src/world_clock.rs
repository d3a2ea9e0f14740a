//! Converts the machine's time to the world's. When the machine stalls, the world stalls too: no robot drives
//! on without its client.

use core::time::Duration;
use std::time::Instant;

/// The longest part of the machine's time that is made up for at once. The rest is skipped.
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
    pub(crate) fn until(&self, then: Duration) -> Duration {
        then.saturating_sub(self.world).div_f64(self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_was_held_up_goes_on_where_it_was() {
        let mut pace = WorldClock::new(Duration::from_secs(5), 1.0);
        pace.last = Instant::now()
            .checked_sub(Duration::from_secs(60))
            .expect("the machine runs for a minute");
        assert_eq!(pace.now(), Duration::from_secs(5) + MAX_BACKLOG);
    }

    #[test]
    fn a_world_that_cannot_keep_up_is_not_driven_ever_faster() {
        let mut pace = WorldClock::new(Duration::from_secs(100), 2.0);
        pace.limit_backlog(Duration::from_secs(40));
        assert_eq!(pace.world, Duration::from_secs(40) + 2 * MAX_BACKLOG);
        pace.limit_backlog(Duration::from_secs(40));
        assert_eq!(pace.world, Duration::from_secs(40) + 2 * MAX_BACKLOG);
    }

    #[test]
    fn a_fast_world_is_waited_for_shortly() {
        let pace = WorldClock::new(Duration::ZERO, 4.0);
        assert_eq!(pace.until(Duration::from_secs(1)), Duration::from_millis(250));
    }
}
