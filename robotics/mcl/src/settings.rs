//! What a localizer is told: the errors of the sensors, the sizes of a search, and what makes an estimate sure.

use crate::motion::MotionNoise;
use crate::sensor::Sensor;

/// What makes an estimate sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The least share of the beams that agree with the map at the estimate, as an average over scans, when the estimate
    /// becomes sure. Below it the robot is searched.
    pub sure_agreement: f64,
    /// The same while the estimate is sure. Below it a search must vouch for the estimate.
    pub agreement: f64,
    /// The same after a search of the map that found no better place: the map has changed. It counts for what was sure.
    pub changed_agreement: f64,
    /// How far the end of a beam may be from an obstacle of the map, m.
    pub tolerance: f64,
    /// The least share of the weights that the heaviest cluster has.
    pub share: f64,
    /// The greatest standard deviation of the position, m.
    pub deviation: f64,
    /// The greatest standard deviation of the heading, rad.
    pub heading_deviation: f64,
    /// The way that the robot must go before its estimate is sure after a search that found several places, or may have
    /// left out some, m.
    pub confirm: f64,
}

impl Limits {
    /// The share of the beams with which an estimate becomes sure: never less than that with which it stays so.
    pub(crate) const fn sure_agreement(&self) -> f64 {
        self.sure_agreement.max(self.agreement)
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sure_agreement: 0.7,
            agreement: 0.5,
            changed_agreement: 0.3,
            tolerance: 0.25,
            share: 0.95,
            deviation: 0.3,
            heading_deviation: 0.2,
            confirm: 1.0,
        }
    }
}

/// How it localizes. All may change from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The fewest particles.
    pub least: usize,
    /// The error of KLD-sampling.
    pub error: f64,
    /// The quantile of the standard normal distribution for the probability of that error.
    pub quantile: f64,
    /// The errors of the odometry.
    pub motion: MotionNoise,
    /// The model of the laser.
    pub sensor: Sensor,
    /// The way after which the particles are weighed, m.
    pub update_way: f64,
    /// The turn after which the particles are weighed, rad.
    pub update_turn: f64,
    /// The most poses that a search looks at.
    pub search: usize,
    /// The poses that a search looks at in one call.
    pub search_step: usize,
    /// What makes an estimate sure.
    pub limits: Limits,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            least: 500,
            error: 0.05,
            quantile: 2.326,
            motion: MotionNoise::default(),
            sensor: Sensor::default(),
            update_way: 0.1,
            update_turn: 0.1,
            search: 2_000_000,
            search_step: 40_000,
            limits: Limits::default(),
        }
    }
}
