//! What a place in the picture is in the world: directions, and the distance of a ball from how large it looks. It knows neither
//! colours nor where the camera sits.
//!
//! A pinhole without distortion, as `sim/camera` is: x to the right, y down, z into the picture, with the focal length
//! `width/2 / tan(field_of_view/2)` in pixels.

use core::f64::consts::TAU;

use crate::blob::Run;

/// A pinhole camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    focal: f64,
    middle: [f64; 2],
}

/// What a mass of pixels is for the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sight {
    /// Toward its middle in the frame of the camera, of any length.
    pub(crate) toward: [f64; 3],
    /// The part of the sphere of view that it covers, sr.
    pub(crate) solid_angle: f64,
}

impl Lens {
    pub(crate) fn new([width, height]: [usize; 2], field_of_view: f64) -> Self {
        let middle = [width as f64 / 2.0, height as f64 / 2.0];
        Self {
            focal: middle[0] / (field_of_view / 2.0).tan(),
            middle,
        }
    }

    /// What these pixels are together. Each counts by the solid angle it covers, so that a ball is as large at the edge of the
    /// picture, where it looks like an egg, as in the middle.
    pub(crate) fn sight<'run>(&self, runs: impl Iterator<Item = &'run Run>) -> Sight {
        let mut sight = Sight::default();
        for run in runs {
            let y = (run.row as f64 + 0.5 - self.middle[1]) / self.focal;
            for column in run.columns[0]..run.columns[1] {
                let x = (column as f64 + 0.5 - self.middle[0]) / self.focal;
                let square = 1.0 + x * x + y * y;
                let length = square.sqrt();
                let part = 1.0 / (square * length * self.focal * self.focal);
                sight.solid_angle += part;
                for (sum, axis) in sight.toward.iter_mut().zip([x, y, 1.0]) {
                    *sum += part * axis / length;
                }
            }
        }
        sight
    }

    /// Column and row at which the camera sees what is in a direction ahead of it.
    pub(crate) fn pixel(&self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        [
            self.middle[0] + self.focal * x / z,
            self.middle[1] + self.focal * y / z,
        ]
    }
}

impl Sight {
    /// Bearing to the left and elevation, rad, for a camera on a head that looks `pan` to the left and `tilt` down, rad.
    pub(crate) fn angles(&self, pan: f64, tilt: f64) -> [f64; 2] {
        let [right, down, into] = self.toward;
        let (sin, cos) = tilt.sin_cos();
        let (ahead, up) = (cos * into - sin * down, -sin * into - cos * down);
        let bearing = pan + (-right).atan2(ahead);
        let elevation = up.atan2(ahead.hypot(right));
        [jde_schema::types::normalize_angle(bearing), elevation]
    }

    /// How far the middle of a ball of that radius is that covers so much of the view, m.
    pub(crate) fn distance(&self, radius: f64) -> f64 {
        let cos = 1.0 - self.solid_angle / TAU;
        radius / (1.0 - cos * cos).sqrt()
    }
}
