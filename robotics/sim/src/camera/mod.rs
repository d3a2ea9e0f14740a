//! Cameras: pictures of the world in true perspective, under any pan and tilt.
//!
//! Flat faces are filled row by row against a depth buffer. Round things are computed by one ray a pixel, so
//! that a ball is round at any distance. The cheaper method, one column of wall for each column of pixels,
//! would bend under a tilt. All arithmetic is that of IEEE 754 and libm: the same world gives the same bytes
//! anywhere.
//!
//! The depth buffer is also what a depth camera measures. There is no model of blur or shadows. A picture never shows
//! the robot that carries the camera.

mod canvas;
mod figure;
mod flat;
mod floor;
mod lens;
mod light;
mod noise;
mod renderer;
mod round;
mod tag;
mod view;

pub use lens::Lens;
pub(crate) use lens::Warp;
pub(crate) use light::Light;
pub(crate) use noise::add_noise;
pub(crate) use renderer::Renderer;

use crate::error::{WorldError, check};
use crate::geometry::Pose2;
use crate::head::{Head, HeadConfig};
pub(crate) use view::View;

/// A camera on a robot. By default 320 x 240 pixels on the pan-tilt head.
///
/// Its frame is the optical frame of REP-103: x to the right of the picture, y down, z into it. With a yaw of
/// 0 it looks ahead.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraConfig {
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// The angle from the left edge of the picture to the right one, in radians. Pixels are square.
    pub field_of_view: f64,
    /// The part that carries it.
    pub mount: CameraMount,
    /// Its place on the carrying part: ahead, to the left and up, in metres.
    pub place: [f64; 3],
    /// Its angle to the left on the carrying part, in radians.
    pub yaw: f64,
    /// Its angle downwards, after that, in radians.
    pub tilt: f64,
    /// The place of its axis, and its distortion.
    pub lens: Lens,
    /// Standard deviation of each part of a colour, in steps of the 256.
    pub noise: f64,
    /// Separates the noise of several cameras of one robot.
    pub stream: u16,
}

/// The part that carries a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraMount {
    /// The body: `place` is in the robot's frame, above the floor.
    Body,
    /// The pan-tilt head: `place` is in the frame of the head, from the point where both axes cross, and
    /// turns with it.
    #[default]
    Head,
}

impl Default for CameraConfig {
    fn default() -> Self {
        Self {
            width: 320,
            height: 240,
            // The Canon VC-C4 at its widest: 47.5 degrees.
            field_of_view: 47.5f64.to_radians(),
            mount: CameraMount::default(),
            place: [0.0; 3],
            yaw: 0.0,
            tilt: 0.0,
            lens: Lens::default(),
            noise: 0.0,
            stream: 0,
        }
    }
}

impl CameraConfig {
    /// Returns the pixels of a picture.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Returns the bytes of a picture: three a pixel.
    pub fn bytes(&self) -> usize {
        3 * self.pixels()
    }

    /// Returns the focal length in pixels: the factor from the tangent of an angle to pixels.
    pub fn focal_length(&self) -> f64 {
        self.width as f64 / 2.0 / libm::tan(self.field_of_view / 2.0)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is invalid.
    pub fn check(&self) -> Result<(), WorldError> {
        let pixels = |value: f64| (1.0..=4096.0).contains(&value);
        check("camera width", self.width as f64, "1 to 4096 pixels", pixels)?;
        check("camera height", self.height as f64, "1 to 4096 pixels", pixels)?;
        check(
            "camera field_of_view",
            self.field_of_view,
            "0.01 to 3.1 rad",
            |value| (0.01..=3.1).contains(&value),
        )?;
        for (what, value) in ["camera place.x", "camera place.y", "camera place.z"]
            .into_iter()
            .zip(self.place)
        {
            check(what, value, "a finite number, at most 100 m", |value| {
                value.abs() <= 100.0
            })?;
        }
        check("camera yaw", self.yaw, "a finite number", |_| true)?;
        check("camera tilt", self.tilt, "a finite number", |_| true)?;
        check("camera noise", self.noise, "0 to 100", |value| {
            (0.0..=100.0).contains(&value)
        })?;
        for value in self.lens.principal {
            check("camera principal point", value, "-4096 to 4096 pixels", |value| {
                value.abs() <= 4096.0
            })?;
        }
        for (what, value) in ["camera k1", "camera k2", "camera p1", "camera p2", "camera k3"]
            .into_iter()
            .zip(self.lens.distortion)
        {
            check(what, value, "a finite number, at most 100", |value| {
                value.abs() <= 100.0
            })?;
        }
        let is_one_to_one = !self.lens.distorts() || Warp::new(self).is_some();
        let folds = "a lens that shows each point once, and at most three times the width and height";
        check("camera k1", self.lens.distortion[0], folds, |_| is_one_to_one)
    }

    /// Returns the place of the optical axis in the picture, in pixels from its upper left corner.
    pub fn center(&self) -> [f64; 2] {
        let [right, down] = self.lens.principal;
        [self.width as f64 / 2.0 + right, self.height as f64 / 2.0 + down]
    }

    /// Returns the picture of a pinhole that a distorting lens needs; `None` for a lens that does not distort.
    pub(crate) fn warp(&self) -> Option<Warp<'_>> {
        self.lens.distorts().then(|| Warp::new(self)).flatten()
    }

    /// Returns the view from a robot at a pose, with its head at the given angles: that of the pinhole.
    pub(crate) fn view(&self, robot: Pose2, (head, mount): (Head, &HeadConfig)) -> View {
        let warp = self.warp();
        let (size, center) = match &warp {
            Some(warp) => (warp.size, warp.center),
            None => ([self.width, self.height], self.center()),
        };
        let base = View::new(
            [robot.x, robot.y, 0.0],
            robot.heading,
            self.focal_length(),
            (size, center),
        );
        let carrier = match self.mount {
            CameraMount::Body => base,
            CameraMount::Head => base.moved(mount.mount).panned(head.pan).tilted(head.tilt),
        };
        carrier.moved(self.place).panned(self.yaw).tilted(self.tilt)
    }
}
