//! What the motors of a base are led to: the commands so far, within its accelerations.

use core::time::Duration;

use jde_types::Twist;

use crate::{BaseDynamics, Travel};

/// The velocity that a base strives for, by the commands that its driver gave it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Setpoint {
    last: Duration,
    command: Twist,
    velocity: Twist,
}

impl Setpoint {
    /// Takes the command that counts from `now` on, and returns what the base strives for then: what the commands before
    /// have led it to.
    pub fn update(&mut self, now: Duration, command: Twist, dynamics: &BaseDynamics) -> Twist {
        let step = now.saturating_sub(self.last).as_secs_f64();
        let at_once = BaseDynamics {
            lag: 0.0,
            ..*dynamics
        };
        let before = Travel {
            velocity: self.velocity,
            ..Travel::default()
        };
        self.velocity = before.after(step, &self.command, &at_once).velocity;
        (self.last, self.command) = (now, command);
        self.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_follows_the_commands_within_the_accelerations_and_not_by_the_lag() {
        let dynamics = BaseDynamics {
            acceleration: 2.0,
            deceleration: 4.0,
            turn_acceleration: 5.0,
            turn_deceleration: 5.0,
            lag: 9.0,
        };
        let mut setpoint = Setpoint::default();
        let mut update = |ms, speed, turn| {
            let found = setpoint.update(Duration::from_millis(ms), Twist::planar(speed, turn), &dynamics);
            let rounded = |value: f64| (value * 1e6).round() / 1e6;
            (rounded(found.linear.x), rounded(found.angular.z))
        };
        assert_eq!(update(1000, 1.0, -0.2), (0.0, 0.0), "there was no command before");
        assert_eq!(update(1100, 1.0, -0.2), (0.2, -0.2));
        assert_eq!(update(2000, 0.0, 0.0), (1.0, -0.2));
        assert_eq!(update(2100, 0.0, 0.0), (0.6, 0.0));
    }
}
