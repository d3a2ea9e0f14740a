//! A line sensor: cells under a robot, each of which measures how bright the floor below it is.
//!
//! A cell has its own light, so that the light of the world makes no difference. It sees colours by their
//! luminance; a real one mostly sees infrared, for which colours differ.

use crate::error::{WorldError, check};
use crate::floor::{Floor, Patch};
use crate::geometry::Pose2;
use crate::random::Noise;

/// The reflectance cells of a line sensor on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSensorConfig {
    /// The place of each cell in the robot's frame, ahead and to the left, in metres.
    pub mounts: Vec<[f64; 2]>,
    /// The side of the square of the floor that a cell sees, in metres.
    pub spot: f64,
    /// Standard deviation of a brightness.
    pub sigma: f64,
    /// Separates the noise of several line sensors of one robot.
    pub stream: u16,
}

impl LineSensorConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let count = self.mounts.len() as f64;
        check("line sensor mounts", count, "1 to 1000 cells", |value| {
            (1.0..=1e3).contains(&value)
        })?;
        for [x, y] in &self.mounts {
            check("line sensor mount x", *x, "a finite number", |_| true)?;
            check("line sensor mount y", *y, "a finite number", |_| true)?;
        }
        check("line sensor spot", self.spot, "more than 0 m", |value| {
            value > 0.0
        })?;
        check("line sensor sigma", self.sigma, "0 or more", |value| value >= 0.0)
    }

    /// Fills one brightness a cell, from 0 for black to 1 for white.
    pub(crate) fn measure(&self, robot: Pose2, floor: &Floor, noise: &Noise, brightness: &mut [f32]) {
        let (sin, cos) = libm::sincos(robot.heading);
        let sides = [
            [self.spot * cos, self.spot * sin],
            [-self.spot * sin, self.spot * cos],
        ];
        let bare = [floor.color.luminance()];
        for (index, (&[x, y], brightness)) in self.mounts.iter().zip(brightness).enumerate() {
            let cell = robot.compose(Pose2::new(x, y, 0.0));
            let patch = Patch {
                center: [cell.x, cell.y],
                sides,
            };
            let [seen] = floor.mean(&patch, bare, |color| [color.luminance()]);
            let error = self.sigma * noise.normals(index as u32)[0];
            *brightness = (seen + error).clamp(0.0, 1.0) as f32;
        }
    }
}
