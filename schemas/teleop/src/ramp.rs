//! The limits of what a person wishes: speeds, and how fast they increase.

use jde_schema::prelude::*;

/// Gap between two commands after which acceleration starts from zero speed again.
const RESTART_PAUSE: Duration = Duration::from_millis(300);

/// The limits of a base: those of its speeds ahead and sideways, and of its turn rate.
pub(crate) struct Limits {
    /// In m/s.
    pub(crate) speed: f64,
    /// In rad/s.
    pub(crate) turn: f64,
    /// In m/s².
    pub(crate) acceleration: f64,
    /// In rad/s².
    pub(crate) turn_acceleration: f64,
}

/// Remembers the last command, so that the next one does not leap.
#[derive(Default)]
pub(crate) struct Ramp {
    /// The last command, and its time.
    last: Option<(Twist, Duration)>,
}

impl Ramp {
    /// Returns the command for a wish at time `now`, within the limits.
    pub(crate) fn follow(&mut self, now: Duration, wish: &Twist, limits: &Limits) -> Twist {
        let is_recent = |(_, time): &(Twist, Duration)| now.saturating_sub(*time) <= RESTART_PAUSE;
        let (last, elapsed) = match self.last.filter(is_recent) {
            Some((last, time)) => (last, now.saturating_sub(time).as_secs_f64()),
            None => (Twist::ZERO, Duration::from_millis(50).as_secs_f64()),
        };
        let linear = Limit {
            max: limits.speed,
            step: limits.acceleration * elapsed,
        };
        let angular = Limit {
            max: limits.turn,
            step: limits.turn_acceleration * elapsed,
        };
        let mut twist = Twist::planar(
            linear.apply(wish.linear.x, last.linear.x),
            angular.apply(wish.angular.z, last.angular.z),
        );
        twist.linear.y = linear.apply(wish.linear.y, last.linear.y);
        self.last = Some((twist, now));
        twist
    }

    /// Notes that the base was commanded to stand.
    pub(crate) fn stand(&mut self, now: Duration) -> Twist {
        self.last = Some((Twist::ZERO, now));
        Twist::ZERO
    }
}

/// The limits of one speed.
struct Limit {
    /// Highest absolute value.
    max: f64,
    /// Highest increase in this step.
    step: f64,
}

impl Limit {
    /// Returns the speed to command for a wish after the speed `last`. It decreases at once, increases step
    /// by step, and passes through 0 when the sign changes.
    fn apply(&self, wish: f64, last: f64) -> f64 {
        let wish = wish.clamp(-self.max, self.max);
        let previous = if wish * last > 0.0 { last.abs() } else { 0.0 };
        wish.abs().min(previous + self.step).copysign(wish)
    }
}
