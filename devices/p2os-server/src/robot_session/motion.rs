//! The commands of a robot's motors: speeds, or a distance or a heading to reach, within the limits that the
//! client has set.
//!
//! It uses the robot's odometry, never its true pose.

use core::f64::consts::PI;

use jde_sim::{RobotConfig, Twist2};

/// How near to a heading counts as reached, rad; the protocol counts whole degrees.
const POSITION_TOLERANCE: f64 = 0.25 * PI / 180.0;

/// The client's last commands to the motors.
#[derive(Debug)]
pub(crate) struct MotorCommands {
    enabled: bool,
    linear: LinearTarget,
    angular: AngularTarget,
    /// Greatest speed while driving a distance, m/s.
    max_linear: f64,
    /// Greatest turn rate while turning to a heading, rad/s.
    max_angular: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum LinearTarget {
    /// m/s.
    Speed(f64),
    /// The remaining distance, m; negative is backwards.
    Distance(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum AngularTarget {
    /// rad/s.
    Speed(f64),
    /// rad, in the frame of the odometry.
    Heading(f64),
}

impl MotorCommands {
    /// Motors that are off, with the limits of the robot.
    pub(crate) fn new(config: &RobotConfig) -> Self {
        Self {
            enabled: false,
            linear: LinearTarget::Speed(0.0),
            angular: AngularTarget::Speed(0.0),
            max_linear: config.max_linear,
            max_angular: config.max_angular,
        }
    }

    pub(crate) fn enable(&mut self, on: bool) {
        self.enabled = on;
        self.stop();
    }

    pub(crate) fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Stops until the next command.
    pub(crate) fn stop(&mut self) {
        self.linear = LinearTarget::Speed(0.0);
        self.angular = AngularTarget::Speed(0.0);
    }

    pub(crate) fn set_speed(&mut self, speed: f64) {
        self.linear = LinearTarget::Speed(speed);
    }

    pub(crate) fn set_turn_rate(&mut self, speed: f64) {
        self.angular = AngularTarget::Speed(speed);
    }

    /// Drives a distance in metres and stops.
    pub(crate) fn move_by(&mut self, metres: f64) {
        self.linear = LinearTarget::Distance(metres);
    }

    /// Turns to a heading of the odometry and stops.
    pub(crate) fn turn_to(&mut self, heading: f64) {
        self.angular = AngularTarget::Heading(heading);
    }

    /// Returns the target heading, if there is one.
    pub(crate) fn heading(&self) -> Option<f64> {
        match self.angular {
            AngularTarget::Heading(heading) => Some(heading),
            AngularTarget::Speed(_) => None,
        }
    }

    /// Adjusts the target heading to a change of the odometry's heading, so that its direction stays the
    /// same.
    pub(crate) fn shift_heading(&mut self, by: f64) {
        if let AngularTarget::Heading(heading) = &mut self.angular {
            *heading += by;
        }
    }

    pub(crate) fn limit(&mut self, linear: f64) {
        self.max_linear = linear;
    }

    pub(crate) fn limit_turns(&mut self, angular: f64) {
        self.max_angular = angular;
    }

    /// Returns the command for the next `dt` seconds, from the heading and speeds that the wheels measured.
    pub(crate) fn command(&mut self, config: &RobotConfig, heading: f64, twist: Twist2, dt: f64) -> Twist2 {
        if !self.enabled {
            return Twist2::default();
        }
        if let LinearTarget::Distance(remaining) = &mut self.linear {
            *remaining -= twist.linear * dt;
            // At rest, less than half a millimetre counts as reached.
            if remaining.abs() < 0.0005 && twist.linear.abs() < 0.01 {
                self.linear = LinearTarget::Speed(0.0);
            }
        }
        if let AngularTarget::Heading(target) = self.angular
            && wrap(target - heading).abs() < POSITION_TOLERANCE
            && twist.angular.abs() < 0.02
        {
            self.angular = AngularTarget::Speed(0.0);
        }
        let linear = match self.linear {
            LinearTarget::Speed(speed) => speed,
            LinearTarget::Distance(remaining) => {
                approach(remaining, self.max_linear, config.linear_deceleration, dt)
            }
        };
        let angular = match self.angular {
            AngularTarget::Speed(speed) => speed,
            AngularTarget::Heading(target) => approach(
                wrap(target - heading),
                self.max_angular,
                config.angular_deceleration,
                dt,
            ),
        };
        Twist2::new(linear, angular)
    }
}

/// Returns a speed that still allows braking within `remaining`, and does not overshoot within `dt`.
fn approach(remaining: f64, max_speed: f64, deceleration: f64, dt: f64) -> f64 {
    // Brakes with 80 % of the deceleration, so that rounding to steps never overshoots.
    let braking = (2.0 * 0.8 * deceleration * remaining.abs()).sqrt();
    braking
        .min(max_speed)
        .min(remaining.abs() / dt / 4.0)
        .copysign(remaining)
}

/// Normalizes an angle to -π to π rad.
fn wrap(angle: f64) -> f64 {
    let turned = (angle + PI).rem_euclid(2.0 * PI);
    turned - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.01;

    /// Drives a robot that follows commands within its accelerations; returns the distance and the heading.
    fn drive(motion: &mut MotorCommands, seconds: f64) -> (f64, f64) {
        let config = RobotConfig::default();
        let (mut distance, mut heading, mut twist) = (0.0, 0.0, Twist2::default());
        let toward =
            |value: f64, target: f64, rate: f64| value + (target - value).clamp(-rate * DT, rate * DT);
        for _ in 0..(seconds / DT) as usize {
            let target = motion.command(&config, heading, twist, DT);
            twist.linear = toward(twist.linear, target.linear, config.linear_deceleration);
            twist.angular = toward(twist.angular, target.angular, config.angular_deceleration);
            distance += twist.linear * DT;
            heading += twist.angular * DT;
        }
        (distance, heading)
    }

    fn enabled() -> MotorCommands {
        let mut motion = MotorCommands::new(&RobotConfig::default());
        motion.enable(true);
        motion
    }

    #[test]
    fn motors_that_are_off_do_nothing() {
        let mut motion = MotorCommands::new(&RobotConfig::default());
        motion.set_speed(0.5);
        motion.set_turn_rate(1.0);
        assert_eq!(drive(&mut motion, 1.0), (0.0, 0.0));
    }

    #[test]
    fn motors_that_are_switched_on_wait_for_a_command() {
        let mut motion = MotorCommands::new(&RobotConfig::default());
        motion.set_speed(0.5);
        motion.enable(true);
        assert_eq!(drive(&mut motion, 1.0), (0.0, 0.0));
    }

    #[test]
    fn a_commanded_distance_is_reached() {
        for target in [1.0, -0.5, 0.01] {
            let mut motion = enabled();
            motion.move_by(target);
            let (distance, _) = drive(&mut motion, 15.0);
            assert!((distance - target).abs() < 0.005, "{distance} for {target}");
        }
    }

    #[test]
    fn a_heading_is_reached_by_the_shorter_turn() {
        for (target, turned) in [(1.0, 1.0), (-2.0, -2.0), (5.0, 5.0 - 2.0 * PI)] {
            let mut motion = enabled();
            motion.turn_to(target);
            let (_, heading) = drive(&mut motion, 10.0);
            assert!((heading - turned).abs() < 0.01, "{heading} for {target}");
        }
    }

    #[test]
    fn the_speed_limit_holds_while_driving_a_distance() {
        let mut motion = enabled();
        motion.limit(0.1);
        motion.move_by(5.0);
        let (distance, _) = drive(&mut motion, 10.0);
        assert!(distance < 1.0, "{distance}");
    }
}
