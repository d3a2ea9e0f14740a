//! Converts between pixels and directions, and computes the distance of a ball from its apparent size. It
//! does not depend on colours or on the position of the camera.
//!
//! The model is a pinhole without distortion, like `sim/camera`: x to the right, y down, z into the picture.
//! The focal length in pixels is `width/2 / tan(field_of_view/2)`.

use core::f64::consts::TAU;

use crate::blob::Run;

/// A pinhole camera.
#[derive(Clone, Copy, Debug)]
pub struct CameraModel {
    focal: f64,
    middle: [f64; 2],
}

/// The direction and apparent size of a component of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Direction to its middle in the frame of the camera, of any length.
    pub direction: [f64; 3],
    /// The solid angle that it covers, sr.
    pub solid_angle: f64,
}

impl CameraModel {
    /// Returns the camera of pictures of some columns and rows, with a horizontal field of view in rad.
    #[must_use]
    pub fn new([width, height]: [usize; 2], field_of_view: f64) -> Self {
        let middle = [width as f64 / 2.0, height as f64 / 2.0];
        Self {
            focal: middle[0] / (field_of_view / 2.0).tan(),
            middle,
        }
    }

    /// Returns the direction and size of these pixels together. Each pixel counts by the solid angle that it
    /// covers, so that a ball has the same size at the edge of the picture, where it appears elongated, as in
    /// the middle.
    #[must_use]
    pub fn observe<'run>(&self, runs: impl Iterator<Item = &'run Run>) -> Observation {
        let mut observation = Observation::default();
        for run in runs {
            let y = (run.row as f64 + 0.5 - self.middle[1]) / self.focal;
            for column in run.columns[0]..run.columns[1] {
                let x = (column as f64 + 0.5 - self.middle[0]) / self.focal;
                let square = 1.0 + x * x + y * y;
                let length = square.sqrt();
                let part = 1.0 / (square * length * self.focal * self.focal);
                observation.solid_angle += part;
                for (sum, axis) in observation.direction.iter_mut().zip([x, y, 1.0]) {
                    *sum += part * axis / length;
                }
            }
        }
        observation
    }

    /// Returns the direction of a place in the picture, column and row in px from the upper left corner, in
    /// the frame of the camera. Its length is above 1.
    #[must_use]
    pub fn ray(&self, [column, row]: [f64; 2]) -> [f64; 3] {
        [
            (column - self.middle[0]) / self.focal,
            (row - self.middle[1]) / self.focal,
            1.0,
        ]
    }

    /// Returns column and row of a direction in the frame of the camera, px from the upper left corner; `None`
    /// if it points away from the picture. The place may be outside the picture.
    #[must_use]
    pub fn pixel(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        let place = [
            self.middle[0] + self.focal * x / z,
            self.middle[1] + self.focal * y / z,
        ];
        (z > 0.0 && place.iter().all(|axis| axis.is_finite())).then_some(place)
    }
}

impl Observation {
    /// Returns bearing (positive to the left) and elevation, rad, for a camera on a head that is turned by
    /// `pan` to the left and `tilt` down, rad.
    #[must_use]
    pub fn angles(&self, pan: f64, tilt: f64) -> [f64; 2] {
        let [right, down, into] = self.direction;
        let (sin, cos) = tilt.sin_cos();
        let (ahead, up) = (cos * into - sin * down, -sin * into - cos * down);
        let bearing = pan + (-right).atan2(ahead);
        let elevation = up.atan2(ahead.hypot(right));
        [jde_types::normalize_angle(bearing), elevation]
    }

    /// Returns the distance to the middle of a ball of this radius that covers this solid angle, m.
    #[must_use]
    pub fn distance(&self, radius: f64) -> f64 {
        let cos = 1.0 - self.solid_angle / TAU;
        radius / (1.0 - cos * cos).sqrt()
    }
}
