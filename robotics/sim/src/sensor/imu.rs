//! An inertial measurement unit: three gyros and three accelerometers, each with a constant bias and normal
//! noise.
//!
//! Like a real one, and as REP-145 states it, an accelerometer measures the specific force: at rest its upward
//! axis shows gravity. Vibration, temperature and a bias that wanders are not modelled.

use crate::error::{WorldError, check};
use crate::geometry::{Pose2, Twist2};
use crate::random::Noise;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;

/// An inertial measurement unit on a robot, level.
#[derive(Clone, Debug, PartialEq)]
pub struct ImuConfig {
    /// Its pose on the robot, in the robot's frame.
    pub mount: Pose2,
    /// Standard deviation of a turn rate, in rad/s.
    pub gyro_sigma: f64,
    /// Standard deviation of each gyro's constant bias, in rad/s; drawn once from the seed.
    pub gyro_bias: f64,
    /// Standard deviation of an acceleration, in m/s².
    pub accelerometer_sigma: f64,
    /// Standard deviation of each accelerometer's constant bias, in m/s²; drawn once from the seed.
    pub accelerometer_bias: f64,
    /// Separates the noise of several units of one robot.
    pub stream: u16,
}

/// A measurement in the frame of the unit: x ahead, y to the left, z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuReading {
    /// Turn rates about the three axes, in rad/s.
    pub angular_velocity: [f64; 3],
    /// Specific forces along the three axes, in m/s²: accelerations, with gravity as one upward.
    pub linear_acceleration: [f64; 3],
}

impl Default for ImuConfig {
    fn default() -> Self {
        Self {
            mount: Pose2::default(),
            // The data sheet of the MPU-9250: 0.1 degrees/s and 8 mg of noise in all.
            gyro_sigma: 0.1f64.to_radians(),
            accelerometer_sigma: 0.08,
            // Estimates of what is left after the means at rest were subtracted.
            gyro_bias: 0.05f64.to_radians(),
            accelerometer_bias: 0.02,
            stream: 0,
        }
    }
}

impl ImuConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        check("imu mount.x", self.mount.x, "a finite number", |_| true)?;
        check("imu mount.y", self.mount.y, "a finite number", |_| true)?;
        check("imu mount.heading", self.mount.heading, "a finite number", |_| {
            true
        })?;
        for (what, value) in [
            ("imu gyro_sigma", self.gyro_sigma),
            ("imu gyro_bias", self.gyro_bias),
            ("imu accelerometer_sigma", self.accelerometer_sigma),
            ("imu accelerometer_bias", self.accelerometer_bias),
        ] {
            check(what, value, "0 or more", |value| value >= 0.0)?;
        }
        Ok(())
    }

    /// Measures the motion of a robot: its twist, and how fast each part of the twist changes.
    pub(crate) fn measure(&self, twist: Twist2, change: Twist2, noise: &Noise, bias: &Noise) -> ImuReading {
        let Pose2 { x, y, heading } = self.mount;
        let (rate, gain) = (twist.angular, change.angular);
        // The robot's frame turns, and the unit turns about the robot's centre.
        let ahead = change.linear - rate * twist.lateral - gain * y - rate * rate * x;
        let left = change.lateral + rate * twist.linear + gain * x - rate * rate * y;
        let (sin, cos) = libm::sincos(heading);
        let truth = [
            0.0,
            0.0,
            rate,
            cos * ahead + sin * left,
            cos * left - sin * ahead,
            GRAVITY,
        ];
        let draws = |noise: &Noise| [0, 1, 2].map(|index| noise.normals(index));
        let (errors, biases) = (draws(noise), draws(bias));
        let axis = |index: usize| {
            let (sigma, bias) = if index < 3 {
                (self.gyro_sigma, self.gyro_bias)
            } else {
                (self.accelerometer_sigma, self.accelerometer_bias)
            };
            let (error, constant) = (errors[index / 2][index % 2], biases[index / 2][index % 2]);
            truth[index] + sigma * error + bias * constant
        };
        ImuReading {
            angular_velocity: [0, 1, 2].map(axis),
            linear_acceleration: [3, 4, 5].map(axis),
        }
    }
}
