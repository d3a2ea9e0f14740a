//! A position sensor, as a satellite receiver whose fixes are given in metres of the world: a position with
//! normal noise, and outages.
//!
//! The noise of two fixes is independent. That of a real receiver wanders for minutes.

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::random::Noise;

/// A position sensor on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionConfig {
    /// The place of its antenna in the robot's frame, ahead and to the left, in metres.
    pub mount: [f64; 2],
    /// Standard deviation of each coordinate, in metres.
    pub sigma: f64,
    /// The share of the time in which there is no fix, from 0 to 1.
    pub outage: f64,
    /// The time is cut into spans of so many seconds, each of which has fixes or none.
    pub outage_time: f64,
    /// Separates the noise of several sensors of one robot.
    pub stream: u16,
}

impl Default for PositionConfig {
    fn default() -> Self {
        Self {
            mount: [0.0; 2],
            // A receiver with real-time kinematics: two centimetres.
            sigma: 0.02,
            outage: 0.0,
            outage_time: 10.0,
            stream: 0,
        }
    }
}

impl PositionConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        check("position mount.x", self.mount[0], "a finite number", |_| true)?;
        check("position mount.y", self.mount[1], "a finite number", |_| true)?;
        check("position sigma", self.sigma, "0 m or more", |value| value >= 0.0)?;
        check("position outage", self.outage, "0 to 1", |value| {
            (0.0..=1.0).contains(&value)
        })?;
        check(
            "position outage_time",
            self.outage_time,
            "0.01 s or more",
            |value| value >= 0.01,
        )
    }

    /// Returns the span of a time in seconds.
    pub(crate) fn span(&self, seconds: f64) -> u64 {
        (seconds / self.outage_time) as u64
    }

    /// Returns a fix, unless the draw of its span is an outage.
    pub(crate) fn measure(&self, robot: Pose2, noise: &Noise, span: &Noise) -> Option<[f64; 2]> {
        let antenna = robot.compose(Pose2::new(self.mount[0], self.mount[1], 0.0));
        let errors = noise.normals(0);
        let fix = [
            antenna.x + self.sigma * errors[0],
            antenna.y + self.sigma * errors[1],
        ];
        (span.uniform(0) >= self.outage).then_some(fix)
    }
}
