//! A ring of sonars: each reports the nearest thing in its cone, however thin.
//!
//! Multiple reflections, crosstalk and surfaces that reflect away from the sensor are not modelled; a part of the echoes
//! may be lost, wherever they come from.

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::random::Noise;

/// Sonars on a robot. By default the 16 of a Pioneer P3-DX: eight at the front from left to right, then eight
/// at the rear from right to left.
#[derive(Clone, Debug, PartialEq)]
pub struct SonarConfig {
    /// The pose of each sonar, in the robot's frame.
    pub mounts: Vec<Pose2>,
    /// The whole angle of each cone, in radians.
    pub cone: f64,
    /// The shortest distance that it measures, in metres.
    pub range_min: f64,
    /// The longest distance that it measures, in metres.
    pub range_max: f64,
    /// Standard deviation of a range, in metres.
    pub sigma: f64,
    /// The part of the echoes that do not come back: the sonar then reads as if nothing were there.
    pub dropped_echoes: f64,
    /// Separates the noise of several rings of one robot.
    pub stream: u16,
}

/// The left half of the ring of a P3-DX, front to rear, in millimetres and degrees (SonarUnit in ARIA's
/// p3dx.p).
const LEFT_MOUNTS: [[f64; 3]; 8] = [
    [69.0, 136.0, 90.0],
    [114.0, 119.0, 50.0],
    [148.0, 78.0, 30.0],
    [166.0, 27.0, 10.0],
    [-255.0, 27.0, 170.0],
    [-237.0, 78.0, 150.0],
    [-203.0, 119.0, 130.0],
    [-157.0, 136.0, 90.0],
];

impl Default for SonarConfig {
    fn default() -> Self {
        let left = |[x, y, degrees]: [f64; 3]| Pose2::new(x / 1000.0, y / 1000.0, degrees.to_radians());
        let right = |[x, y, degrees]: [f64; 3]| left([x, -y, -degrees]);
        let (front, rear) = LEFT_MOUNTS.split_at(4);
        let mounts = (front.iter().map(|&unit| left(unit)))
            .chain(front.iter().rev().map(|&unit| right(unit)))
            .chain(rear.iter().rev().map(|&unit| right(unit)))
            .chain(rear.iter().map(|&unit| left(unit)))
            .collect();
        Self {
            mounts,
            // The main lobe of the Polaroid transducer, about 30 degrees.
            cone: 30f64.to_radians(),
            range_min: 0.0,
            range_max: 5.0,
            sigma: 0.01,
            dropped_echoes: 0.0,
            stream: 0,
        }
    }
}

impl SonarConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        for mount in &self.mounts {
            check("sonar mount.x", mount.x, "a finite number", |_| true)?;
            check("sonar mount.y", mount.y, "a finite number", |_| true)?;
            check("sonar mount.heading", mount.heading, "a finite number", |_| true)?;
        }
        check(
            "sonar mounts",
            self.mounts.len() as f64,
            "1 to 1000 sonars",
            |value| (1.0..=1e3).contains(&value),
        )?;
        check("sonar cone", self.cone, "0 to π rad", |value| {
            (0.0..=std::f64::consts::PI).contains(&value)
        })?;
        check("sonar range_min", self.range_min, "0 m or more", |value| {
            value >= 0.0
        })?;
        check(
            "sonar range_max",
            self.range_max,
            "more than range_min",
            |value| value > self.range_min,
        )?;
        check("sonar dropped_echoes", self.dropped_echoes, "0 to 1", |value| {
            (0.0..=1.0).contains(&value)
        })?;
        check("sonar sigma", self.sigma, "0 m or more", |value| value >= 0.0)
    }

    /// Fills one range a sonar. `cast` returns the distance to the nearest thing in the cone around a
    /// direction.
    pub(crate) fn measure(
        &self,
        robot: Pose2,
        (noise, drops): (&Noise, &Noise),
        ranges: &mut [f32],
        cast: impl Fn([f64; 2], f64) -> Option<f64>,
    ) {
        for (index, (mount, range)) in self.mounts.iter().zip(ranges).enumerate() {
            let sonar = robot.compose(*mount);
            let is_dropped = self.dropped_echoes > 0.0 && drops.uniform(index as u32) < self.dropped_echoes;
            let nearest = cast([sonar.x, sonar.y], sonar.heading).filter(|_| !is_dropped);
            let error = self.sigma * noise.normals(index as u32)[0];
            *range = super::reading(nearest, error, self.range_min, self.range_max);
        }
    }
}
