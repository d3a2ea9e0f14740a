//! The depth of each pixel of a camera: the distance along its optical axis, as in ROS's depth images (REP-118).
//!
//! The model is that of structured light: the sensor measures a disparity, so that the error of a depth grows
//! with the square of the depth. There are no shadows of the projector, no errors at edges, and no pixels
//! without a measurement in the range.

use crate::error::{WorldError, check};
use crate::random::Noise;

/// What a camera measures of the depth of its pixels. By default the numbers of a Kinect.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthConfig {
    /// The shortest depth that it measures, in metres.
    pub range_min: f64,
    /// The longest depth that it measures, in metres.
    pub range_max: f64,
    /// Standard deviation of a depth of 1 m, in metres. It grows with the square of the depth.
    pub sigma: f64,
    /// Separates the noise of several cameras of one robot.
    pub stream: u16,
}

impl Default for DepthConfig {
    fn default() -> Self {
        // Khoshelham and Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping
        // applications", Sensors 12(2), 2012: half a step of the disparity, and depths up to 5 m.
        Self {
            range_min: 0.5,
            range_max: 5.0,
            sigma: 0.001425,
            stream: 0,
        }
    }
}

impl DepthConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        check("depth range_min", self.range_min, "0 m or more", |value| {
            value >= 0.0
        })?;
        check(
            "depth range_max",
            self.range_max,
            "more than range_min",
            |value| value > self.range_min,
        )?;
        check("depth sigma", self.sigma, "0 m or more", |value| value >= 0.0)
    }

    /// Fills one depth a pixel from the inverses of the true ones; an inverse of 0 is nothing at all.
    pub(crate) fn measure(&self, inverses: &[f32], noise: &Noise, depths: &mut [f32]) {
        let readings = depths.chunks_mut(2).zip(inverses.chunks(2));
        for (pair, (depths, inverses)) in readings.enumerate() {
            let is_noisy = self.sigma > 0.0 && inverses.iter().any(|inverse| *inverse > 0.0);
            let errors = if is_noisy {
                noise.normals(pair as u32)
            } else {
                [0.0; 2]
            };
            for ((depth, inverse), error) in depths.iter_mut().zip(inverses).zip(errors) {
                let distance = (*inverse > 0.0).then(|| 1.0 / f64::from(*inverse));
                let error = distance.map_or(0.0, |distance| self.sigma * distance * distance * error);
                *depth = super::reading(distance, error, self.range_min, self.range_max);
            }
        }
    }
}
