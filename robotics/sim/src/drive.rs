//! How a robot turns a command into speeds: its wheels, its limits of speed and acceleration, and the lag, the friction
//! and the skidding of its motors and wheels.
//!
//! It depends on no obstacles: `robot` moves the body.

use crate::config::RobotConfig;
use crate::error::{WorldError, check};
use crate::geometry::Twist2;

/// The least difference of a lagging speed that counts, in m/s and rad/s: a smaller one ends, so that a robot
/// comes to rest.
const AT_REST: f64 = 1e-6;

/// The motions that the wheels of a robot allow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kinematics {
    /// Two driven wheels beside the centre: ahead, backwards, and turns, also on the spot.
    #[default]
    Differential,
    /// Wheels that roll in all directions: it moves to the side, too, and turns meanwhile.
    Omnidirectional {
        /// Greatest speed to either side in m/s.
        max_lateral: f64,
        /// Greatest change of that speed in m/s².
        lateral_acceleration: f64,
    },
    /// Two steered wheels ahead of a rear axle, whose middle is the centre of the robot's frame (the bicycle
    /// model). It cannot turn on the spot.
    ///
    /// A command of `linear` and `angular` asks for the curvature `angular / linear`, as for the Ackermann
    /// controllers of ROS, and a speed that is cut to its limit keeps the curvature. A command without a
    /// linear speed has none: the wheels keep their angle. The limits of turn rates have no effect.
    Car {
        /// Distance of the axles in metres.
        wheelbase: f64,
        /// Greatest angle of the steered wheels to either side, in radians.
        max_steering: f64,
        /// Greatest change of that angle in rad/s.
        steering_rate: f64,
    },
}

/// The motors of a robot, with the last command.
#[derive(Debug, Default)]
pub(crate) struct Motors {
    command: Twist2,
    /// The speeds that the limits of acceleration allow now. The motors reach them after their lag.
    target: Twist2,
    /// The angle of a car's steered wheels in radians, to the left.
    steering: f64,
}

impl Kinematics {
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let positive = |value: f64| value > 0.0;
        match *self {
            Self::Differential => Ok(()),
            Self::Omnidirectional {
                max_lateral,
                lateral_acceleration,
            } => {
                check(
                    "max_lateral",
                    max_lateral,
                    "more than 0 and at most 20 m/s",
                    |value| value > 0.0 && value <= 20.0,
                )?;
                check(
                    "lateral_acceleration",
                    lateral_acceleration,
                    "more than 0 m/s²",
                    positive,
                )
            }
            Self::Car {
                wheelbase,
                max_steering,
                steering_rate,
            } => {
                check("wheelbase", wheelbase, "0.01 to 10 m", |value| {
                    (0.01..=10.0).contains(&value)
                })?;
                // Near a right angle the car would turn about its rear axle.
                check(
                    "max_steering",
                    max_steering,
                    "more than 0 and at most 1.4 rad",
                    |value| value > 0.0 && value <= 1.4,
                )?;
                check("steering_rate", steering_rate, "more than 0 rad/s", positive)
            }
        }
    }
}

impl Motors {
    /// Takes a command, within the limits of the speeds.
    pub(crate) fn command(&mut self, config: &RobotConfig, twist: Twist2) {
        let linear = twist.linear.clamp(-config.max_linear, config.max_linear);
        let turn = twist.angular.clamp(-config.max_angular, config.max_angular);
        let is_held = |speed: f64, band: f64| speed == 0.0 || speed.abs() < band;
        let is_slow = is_held(linear, config.dead_band);
        let turns = !is_held(turn, config.turn_dead_band);
        self.command = match config.kinematics {
            Kinematics::Differential if is_slow && !turns => Twist2::default(),
            Kinematics::Differential => Twist2::new(linear, turn),
            Kinematics::Omnidirectional { max_lateral, .. } => {
                let lateral = twist.lateral.clamp(-max_lateral, max_lateral);
                if is_slow && !turns && is_held(lateral, config.dead_band) {
                    Twist2::default()
                } else {
                    Twist2 {
                        lateral,
                        ..Twist2::new(linear, turn)
                    }
                }
            }
            Kinematics::Car { .. } if is_slow => Twist2::default(),
            // The curvature stays that of the command.
            Kinematics::Car { .. } => Twist2::new(linear, twist.angular / twist.linear * linear),
        };
    }

    /// Returns the twist of the base after `dt` seconds, from the present one. A load of as many kilograms as the robot
    /// can push halves the speeds.
    pub(crate) fn step(&mut self, config: &RobotConfig, base: Twist2, load: f64, dt: f64) -> Twist2 {
        // The speeds of the motors are those of the wheels, which turn by more than the base when they skid.
        let now = Twist2 {
            angular: base.angular / config.grip(),
            ..base
        };
        let (command, target) = (self.command, &mut self.target);
        let slowed = 1.0 + load / config.max_push;
        target.linear = approach(
            target.linear,
            command.linear / slowed,
            config.linear_acceleration * dt,
            config.linear_deceleration * dt,
        );
        target.angular = approach(
            target.angular,
            command.angular,
            config.angular_acceleration * dt,
            config.angular_deceleration * dt,
        );
        if let Kinematics::Omnidirectional {
            lateral_acceleration, ..
        } = config.kinematics
        {
            let change = lateral_acceleration * dt;
            target.lateral = approach(target.lateral, command.lateral / slowed, change, change);
        }
        let lag = |now: f64, target: f64| lagged(now, target, config.lag, dt);
        let next = Twist2 {
            linear: lag(now.linear, target.linear),
            lateral: lag(now.lateral, target.lateral),
            angular: lag(now.angular, target.angular),
        };
        match config.kinematics {
            Kinematics::Differential | Kinematics::Omnidirectional { .. } => Twist2 {
                angular: next.angular * config.grip(),
                ..next
            },
            Kinematics::Car {
                wheelbase,
                max_steering,
                steering_rate,
            } => {
                if command.linear != 0.0 {
                    let angle = libm::atan(command.angular / command.linear * wheelbase);
                    let change = angle.clamp(-max_steering, max_steering) - self.steering;
                    self.steering += change.clamp(-steering_rate * dt, steering_rate * dt);
                }
                Twist2::new(next.linear, next.linear * libm::tan(self.steering) / wheelbase)
            }
        }
    }

    /// Continues from a twist of the base that an obstacle has changed.
    pub(crate) fn resume(&mut self, config: &RobotConfig, twist: Twist2) {
        self.target = Twist2 {
            angular: twist.angular / config.grip(),
            ..twist
        };
    }

    /// Forgets the command, at rest. A car keeps the angle of its wheels.
    pub(crate) fn stop(&mut self) {
        (self.command, self.target) = Default::default();
    }
}

/// Returns a speed after `dt` seconds on its way to `target`: that of a first-order system.
fn lagged(now: f64, target: f64, lag: f64, dt: f64) -> f64 {
    let rest = target - now;
    if lag == 0.0 || rest.abs() < AT_REST {
        return target;
    }
    now + rest * (1.0 - libm::exp(-dt / lag))
}

/// Returns the next speed on the way to `desired`. It changes by at most `loss` toward zero and by at most
/// `gain` away from zero, and stops at zero before it changes sign.
fn approach(speed: f64, desired: f64, gain: f64, loss: f64) -> f64 {
    if speed != 0.0 && desired * speed < speed * speed {
        let target = if desired * speed > 0.0 { desired } else { 0.0 };
        if speed > target {
            (speed - loss).max(target)
        } else {
            (speed + loss).min(target)
        }
    } else if desired > speed {
        (speed + gain).min(desired)
    } else {
        (speed - gain).max(desired)
    }
}
