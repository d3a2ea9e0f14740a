//! A scanning laser: one ray a beam.
//!
//! All beams of a scan are taken at one instant. The sweep of a turning mirror is not modelled.

use std::f64::consts::{PI, TAU};

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::random::Noise;
use crate::sweep::Sweep;

/// A laser on a robot. By default 180 beams over half a turn, with a range of 8 m.
///
/// Beam `i` points along `angle(i) = -field_of_view / 2 + i · field_of_view / beams` in the frame of the
/// laser, from right to left: 180 beams over 180° point along -90°, -89°, ... +89°, and a full turn repeats
/// no direction.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserConfig {
    /// Its pose on the robot, in the robot's frame.
    pub mount: Pose2,
    /// Rays in a scan.
    pub beams: usize,
    /// The angle that the scan covers, in radians.
    pub field_of_view: f64,
    /// The shortest distance that it measures, in metres.
    pub range_min: f64,
    /// The longest distance that it measures, in metres.
    pub range_max: f64,
    /// Standard deviation of a range, in metres.
    pub sigma: f64,
    /// The intensity of a white surface, in units of the device; 0 if it measures no intensities. It is the same at
    /// every distance and angle, as of a device that corrects for both.
    pub intensity: f64,
    /// Separates the noise of several lasers of one robot.
    pub stream: u16,
}

/// Standard deviation of an intensity, as a fraction: an estimate.
const INTENSITY_SIGMA: f64 = 0.05;
/// The first draw of the noise of intensities: no laser has so many beams.
const INTENSITY_DRAWS: u32 = 1 << 31;

impl Default for LaserConfig {
    fn default() -> Self {
        Self {
            // LaserX of ARIA's p3dx.p.
            mount: Pose2 {
                x: 0.018,
                y: 0.0,
                heading: 0.0,
            },
            beams: 180,
            field_of_view: PI,
            // Inside the body's own edge: nothing outside the robot is too near.
            range_min: 0.02,
            range_max: 8.0,
            // The statistical error of a SICK LMS200 on its 8 m range is 5 mm.
            sigma: 0.005,
            intensity: 0.0,
            stream: 0,
        }
    }
}

impl LaserConfig {
    /// Returns the direction of the first beam, in radians.
    pub fn angle_min(&self) -> f64 {
        -self.field_of_view / 2.0
    }

    /// Returns the angle between neighbouring beams, in radians.
    pub fn angle_increment(&self) -> f64 {
        self.field_of_view / self.beams as f64
    }

    /// Returns the direction of the last beam, in radians: one increment short of the edge.
    pub fn angle_max(&self) -> f64 {
        self.angle(self.beams.saturating_sub(1))
    }

    /// Returns the direction of a beam, in radians.
    pub fn angle(&self, beam: usize) -> f64 {
        self.angle_min() + beam as f64 * self.angle_increment()
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let any = |_| true;
        check("laser mount.x", self.mount.x, "a finite number", any)?;
        check("laser mount.y", self.mount.y, "a finite number", any)?;
        check("laser mount.heading", self.mount.heading, "a finite number", any)?;
        check("laser beams", self.beams as f64, "1 to 100000", |value| {
            (1.0..=1e5).contains(&value)
        })?;
        check(
            "laser field_of_view",
            self.field_of_view,
            "more than 0 and at most 2π rad",
            |value| value > 0.0 && value <= TAU,
        )?;
        check("laser range_min", self.range_min, "0 m or more", |value| {
            value >= 0.0
        })?;
        check(
            "laser range_max",
            self.range_max,
            "more than range_min",
            |value| value > self.range_min,
        )?;
        check("laser sigma", self.sigma, "0 m or more", |value| value >= 0.0)?;
        check("laser intensity", self.intensity, "0 or more", |value| {
            value >= 0.0
        })
    }

    /// Fills a scan; the intensities are as many as the ranges, or none. `cast` lets the things meet the rays.
    pub(crate) fn scan(
        &self,
        robot: Pose2,
        noise: &Noise,
        (ranges, intensities): (&mut [f32], &mut [f32]),
        cast: impl FnOnce(&mut Sweep),
    ) {
        let laser = robot.compose(self.mount);
        let angles = (0..self.beams).map(|beam| laser.heading + self.angle(beam));
        let increment = self.angle_increment();
        let mut sweep = Sweep::new([laser.x, laser.y], angles, increment, self.range_max);
        cast(&mut sweep);
        let echoes = sweep.into_echoes();
        let readings = ranges.chunks_mut(2).zip(echoes.chunks(2));
        for (pair, (ranges, echoes)) in readings.enumerate() {
            let errors = if self.sigma > 0.0 {
                noise.normals(pair as u32)
            } else {
                [0.0; 2]
            };
            for ((range, echo), error) in ranges.iter_mut().zip(echoes).zip(errors) {
                let distance = echo.map(|echo| echo.distance);
                *range = super::reading(distance, self.sigma * error, self.range_min, self.range_max);
            }
        }
        for (beam, intensity) in intensities.iter_mut().enumerate() {
            let error = noise.normals(INTENSITY_DRAWS + beam as u32 / 2)[beam % 2];
            let reflectivity = echoes[beam].filter(|_| ranges[beam].is_finite());
            let white = self.intensity * (1.0 + INTENSITY_SIGMA * error).max(0.0);
            *intensity = reflectivity.map_or(0.0, |echo| (white * echo.reflectivity) as f32);
        }
    }
}
