//! A scanning laser: one ray a beam, all at one instant or one after another as its mirror turns.
//!
//! While it turns, the robot moves; what else moves is where it is at the end of the scan.

use std::f64::consts::{PI, TAU};

use parry2d_f64::query::Ray;

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::random::Noise;
use crate::solid;
use crate::sweep::{Echo, Sweep};

/// A laser on a robot. By default 180 beams over half a turn, with a range of 8 m.
///
/// Beam `i` points along `angle(i) = -field_of_view / 2 + i · field_of_view / beams` in the frame of the
/// laser, from right to left: 180 beams over 180° point along -90°, -89°, ... +89°, and a full turn repeats
/// no direction. One that turns clockwise has the same directions in the opposite order.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserConfig {
    /// Its pose on the robot, in the robot's frame.
    pub mount: Pose2,
    /// How high it is above the floor, in metres: it sees nothing that is lower. At 0 it sees all.
    pub height: f64,
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
    /// The turn of its mirror; `None` if all beams are taken at one instant.
    pub turn: Option<LaserTurn>,
    /// The part of the beams that get nothing back, whatever is there.
    pub dropped_beams: f64,
    /// What a beam reads that gets nothing back.
    pub no_return: NoReturn,
    /// Separates the noise of several lasers of one robot.
    pub stream: u16,
}

/// How a laser turns: its beams are measured one after another, the last one at the present time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserTurn {
    /// Seconds of a whole turn, at most those of [`crate::RobotConfig::trail`].
    pub period: f64,
    /// Whether it turns clockwise: beam 0 is then the leftmost.
    pub clockwise: bool,
}

/// What a beam reads that gets nothing back: nothing is in its range, or what is there is black, or the beam was dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoReturn {
    /// +∞ (REP-117). Something too near to measure reads -∞.
    #[default]
    Infinity,
    /// The greatest distance. Something too near to measure reads -∞.
    Max,
    /// 0, and so does something too near to measure.
    Zero,
    /// NaN, and so does something too near to measure.
    Nan,
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
            height: 0.0,
            beams: 180,
            field_of_view: PI,
            // Inside the body's own edge: nothing outside the robot is too near.
            range_min: 0.02,
            range_max: 8.0,
            // The statistical error of a SICK LMS200 on its 8 m range is 5 mm.
            sigma: 0.005,
            intensity: 0.0,
            turn: None,
            dropped_beams: 0.0,
            no_return: NoReturn::Infinity,
            stream: 0,
        }
    }
}

impl LaserConfig {
    /// Returns the direction of the first beam, in radians.
    pub fn angle_min(&self) -> f64 {
        match self.turn {
            Some(turn) if turn.clockwise => self.field_of_view / 2.0 + self.angle_increment(),
            Some(_) | None => -self.field_of_view / 2.0,
        }
    }

    /// Returns the angle from a beam to the next one, in radians; negative if it turns clockwise.
    pub fn angle_increment(&self) -> f64 {
        let increment = self.field_of_view / self.beams as f64;
        match self.turn {
            Some(turn) if turn.clockwise => -increment,
            Some(_) | None => increment,
        }
    }

    /// Returns the time from a beam to the next one, in seconds: 0 if it does not turn.
    pub fn time_increment(&self) -> f64 {
        let period = self.turn.map_or(0.0, |turn| turn.period);
        period * self.field_of_view / TAU / self.beams as f64
    }

    /// Returns how long before the present time a beam is measured, in seconds.
    pub fn age(&self, beam: usize) -> f64 {
        self.time_increment() * self.beams.saturating_sub(beam + 1) as f64
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
        check("laser height", self.height, "0 m or more", |value| value >= 0.0)?;
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
        check("laser dropped_beams", self.dropped_beams, "0 to 1", |value| {
            (0.0..=1.0).contains(&value)
        })?;
        if let Some(turn) = self.turn {
            check(
                "laser turn",
                turn.period,
                "more than 0 and at most 1 s",
                |value| value > 0.0 && value <= 1.0,
            )?;
        }
        check("laser intensity", self.intensity, "0 or more", |value| {
            value >= 0.0
        })
    }

    /// Returns the rays of all beams from a robot at a pose.
    pub(crate) fn sweep(&self, robot: Pose2) -> Sweep {
        let laser = robot.compose(self.mount);
        let (first, increment) = (self.angle_min(), self.angle_increment());
        let angles = (0..self.beams).map(|beam| laser.heading + (first + beam as f64 * increment));
        Sweep::new(
            [laser.x, laser.y],
            angles,
            increment,
            (self.range_max, self.height),
        )
    }

    /// Returns the ray of a beam from a robot at a pose.
    pub(crate) fn ray(&self, robot: Pose2, beam: usize) -> Ray {
        let laser = robot.compose(self.mount);
        solid::ray([laser.x, laser.y], laser.heading + self.angle(beam))
    }

    /// Fills a scan from what its beams meet; the intensities are as many as the ranges, or none.
    pub(crate) fn scan(
        &self,
        echoes: &[Option<Echo>],
        (noise, drops): (&Noise, &Noise),
        (ranges, intensities): (&mut [f32], &mut [f32]),
    ) {
        let readings = ranges.chunks_mut(2).zip(echoes.chunks(2));
        for (pair, (ranges, echoes)) in readings.enumerate() {
            let errors = if self.sigma > 0.0 {
                noise.normals(pair as u32)
            } else {
                [0.0; 2]
            };
            for ((range, echo), error) in ranges.iter_mut().zip(echoes).zip(errors) {
                let distance = echo.filter(|echo| !echo.is_black).map(|echo| echo.distance);
                *range = super::reading(distance, self.sigma * error, self.range_min, self.range_max);
            }
        }
        if self.dropped_beams > 0.0 {
            for (beam, range) in (0..).zip(&mut *ranges) {
                if drops.uniform(beam) < self.dropped_beams {
                    *range = f32::INFINITY;
                }
            }
        }
        for (beam, intensity) in intensities.iter_mut().enumerate() {
            let error = noise.normals(INTENSITY_DRAWS + beam as u32 / 2)[beam % 2];
            let reflectivity = echoes[beam].filter(|_| ranges[beam].is_finite());
            let white = self.intensity * (1.0 + INTENSITY_SIGMA * error).max(0.0);
            *intensity = reflectivity.map_or(0.0, |echo| (white * echo.reflectivity) as f32);
        }
        self.state_no_return(ranges);
    }

    /// Replaces what is not finite by what the device reads instead.
    fn state_no_return(&self, ranges: &mut [f32]) {
        let (free, too_near) = match self.no_return {
            NoReturn::Infinity => return,
            NoReturn::Max => (self.range_max as f32, f32::NEG_INFINITY),
            NoReturn::Zero => (0.0, 0.0),
            NoReturn::Nan => (f32::NAN, f32::NAN),
        };
        for range in ranges {
            if *range == f32::INFINITY {
                *range = free;
            } else if *range == f32::NEG_INFINITY {
                *range = too_near;
            }
        }
    }
}
