//! Converts between pixels and directions, and computes the distance of a ball from its apparent size. It
//! does not depend on colours or on the position of the camera.
//!
//! x is to the right, y down, z into the picture. Places in a picture are columns and rows in px from its upper left
//! corner, so that the middle of the first pixel is at (0.5, 0.5).

use core::f64::consts::TAU;

use crate::blob::PixelRun;
use crate::distortion::Distortion;

/// A camera: a pinhole of two focal lengths in pixels and a place of the optical axis, behind a lens that may distort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraModel {
    pub(crate) focal: [f64; 2],
    pub(crate) middle: [f64; 2],
    pub(crate) distortion: Distortion,
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
    /// Returns the camera of pictures of some columns and rows without distortion, like `sim/camera`, with a horizontal
    /// field of view in rad: the focal length is `width/2 / tan(field_of_view/2)`.
    #[must_use]
    pub fn new([width, height]: [usize; 2], field_of_view: f64) -> Self {
        let middle = [width as f64 / 2.0, height as f64 / 2.0];
        Self {
            focal: [middle[0] / libm::tan(field_of_view / 2.0); 2],
            middle,
            distortion: Distortion::None,
        }
    }

    /// Returns the focal lengths, px, of the camera without its distortion.
    #[must_use]
    pub const fn focal(&self) -> [f64; 2] {
        self.focal
    }

    /// Returns column and row of the optical axis.
    #[must_use]
    pub const fn middle(&self) -> [f64; 2] {
        self.middle
    }

    /// Returns where a place of the picture would be without distortion; `None` where the lens shows nothing.
    #[must_use]
    pub fn undistorted(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let undone = self.distortion.undo(self.plane(place))?;
        Some([0, 1].map(|axis| self.middle[axis] + self.focal[axis] * undone[axis]))
    }

    /// Returns the direction and size of these pixels together. Each pixel counts by the solid angle that it
    /// covers, so that a ball has the same size at the edge of the picture, where it appears elongated, as in
    /// the middle. A pixel where the lens shows nothing does not count.
    #[must_use]
    pub fn observe<'run>(&self, runs: impl Iterator<Item = &'run PixelRun>) -> Observation {
        let mut observation = Observation::default();
        for run in runs {
            for column in run.columns[0]..run.columns[1] {
                let place = self.plane([column as f64 + 0.5, run.row as f64 + 0.5]);
                let Some([x, y]) = self.distortion.undo(place) else {
                    continue;
                };
                let (_, [[xx, xy], [yx, yy]]) = self.distortion.apply([x, y]);
                let square = 1.0 + x * x + y * y;
                let length = square.sqrt();
                let part =
                    1.0 / (square * length * self.focal[0] * self.focal[1] * (xx * yy - xy * yx).abs());
                observation.solid_angle += part;
                for (sum, axis) in observation.direction.iter_mut().zip([x, y, 1.0]) {
                    *sum += part * axis / length;
                }
            }
        }
        observation
    }

    /// Returns the direction of a place in the picture, in the frame of the camera; `None` where the lens shows nothing.
    /// Its length is above 1.
    #[must_use]
    pub fn ray(&self, place: [f64; 2]) -> Option<[f64; 3]> {
        let [x, y] = self.distortion.undo(self.plane(place))?;
        Some([x, y, 1.0])
    }

    /// Returns column and row of a direction in the frame of the camera; `None` if it points away from the picture. The
    /// place may be outside the picture.
    #[must_use]
    pub fn pixel(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        let (seen, [[xx, xy], [yx, yy]]) = self.distortion.apply([x / z, y / z]);
        let place = [0, 1].map(|axis| self.middle[axis] + self.focal[axis] * seen[axis]);
        // A lens that turns around shows the direction nowhere, but its polynomial has a place for it.
        let is_shown = z > 0.0 && xx * yy - xy * yx > 0.0;
        (is_shown && place.iter().all(|axis| axis.is_finite())).then_some(place)
    }

    /// Returns the place in the plane one unit before the pinhole.
    fn plane(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (place[axis] - self.middle[axis]) / self.focal[axis])
    }
}

impl Observation {
    /// Returns bearing (positive to the left) and elevation, rad, for a camera on a head that is turned by
    /// `pan` to the left and `tilt` down, rad.
    #[must_use]
    pub fn angles(&self, pan: f64, tilt: f64) -> [f64; 2] {
        let [right, down, into] = self.direction;
        let (sin, cos) = libm::sincos(tilt);
        let (ahead, up) = (cos * into - sin * down, -sin * into - cos * down);
        let bearing = pan + libm::atan2(-right, ahead);
        let elevation = libm::atan2(up, libm::hypot(ahead, right));
        [jde_types::normalize_angle(bearing), elevation]
    }

    /// Returns the distance to the middle of a ball of this radius that covers this solid angle, m.
    #[must_use]
    pub fn distance(&self, radius: f64) -> f64 {
        let cos = 1.0 - self.solid_angle / TAU;
        radius / (1.0 - cos * cos).sqrt()
    }
}
