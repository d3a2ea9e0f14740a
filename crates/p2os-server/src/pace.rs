//! From the machine's time to the world's. A machine that was held up holds up the world: nothing drives on
//! meanwhile.

use core::time::Duration;
use std::time::Instant;

/// The longest part of the machine's time that is made up for at once; what is longer did not happen.
const LONGEST: Duration = Duration::from_millis(200);

/// Seconds of the world for seconds of the machine.
#[derive(Debug)]
pub(crate) struct Pace {
    last: Instant,
    world: Duration,
    speed: f64,
}

impl Pace {
    /// Begins at a time of the world.
    pub(crate) fn new(world: Duration, speed: f64) -> Self {
        Self {
            last: Instant::now(),
            world,
            speed,
        }
    }

    /// The world's time by now.
    pub(crate) fn now(&mut self) -> Duration {
        let now = Instant::now();
        let passed = now.duration_since(self.last).min(LONGEST);
        self.last = now;
        self.world += passed.mul_f64(self.speed);
        self.world
    }

    /// A world that has only come this far is not driven on by more than [`LONGEST`] of the machine's time.
    pub(crate) fn hold_to(&mut self, world: Duration) {
        self.world = self.world.min(world + LONGEST.mul_f64(self.speed));
    }

    /// How long to wait on this machine until a time of the world.
    pub(crate) fn until(&self, then: Duration) -> Duration {
        then.saturating_sub(self.world).div_f64(self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_was_held_up_goes_on_where_it_was() {
        let mut pace = Pace::new(Duration::from_secs(5), 1.0);
        pace.last = Instant::now()
            .checked_sub(Duration::from_secs(60))
            .expect("the machine runs for a minute");
        assert_eq!(pace.now(), Duration::from_secs(5) + LONGEST);
    }

    #[test]
    fn a_world_that_cannot_keep_up_is_not_driven_ever_faster() {
        let mut pace = Pace::new(Duration::from_secs(100), 2.0);
        pace.hold_to(Duration::from_secs(40));
        assert_eq!(pace.world, Duration::from_secs(40) + 2 * LONGEST);
        pace.hold_to(Duration::from_secs(40));
        assert_eq!(pace.world, Duration::from_secs(40) + 2 * LONGEST);
    }

    #[test]
    fn a_fast_world_is_waited_for_shortly() {
        let pace = Pace::new(Duration::ZERO, 4.0);
        assert_eq!(pace.until(Duration::from_secs(1)), Duration::from_millis(250));
    }
}
