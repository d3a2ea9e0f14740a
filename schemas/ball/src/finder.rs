//! The perceptive schema that finds the ball in pictures. It commands nothing and remembers only the last
//! ball.

use jde_schema::prelude::*;
use jde_vision::{Blobs, CameraGeometry, CameraPorts, ColorRange, Pixels};

use crate::ball::Ball;

/// Finds a ball of one colour in the pictures of a camera: the largest connected component of that colour
/// that is round.
///
/// The distance follows from the apparent size, so a ball that is half hidden appears farther than it is, by
/// at most half. The light may change as far as the limits of colour allow. A picture of 320 x 240 pixels
/// takes 0.7 ms, one of 640 x 480 takes 3 ms.
#[derive(Describe)]
#[schema(perceptive, period = "33ms", budget = "33ms")]
pub struct Finder {
    /// The pictures, encoded as "rgb8" or "bgr8".
    #[import]
    image: Import<Image>,
    #[ports]
    camera: CameraPorts,
    /// The measured position of the head that carries the camera. If it is not bound, the camera looks
    /// straight ahead and angles are in the camera's frame.
    #[import(optional)]
    pan_tilt: Import<PanTilt>,
    /// First hue of the range; red is 0, yellow 60 and green 120 degrees.
    #[modulation(default = 14_f64.to_radians(), unit = "rad", min = 0.0, max = core::f64::consts::TAU)]
    hue_from: Modulation<f64>,
    /// Last hue of the range; smaller than the first if the range contains red.
    #[modulation(default = 36_f64.to_radians(), unit = "rad", min = 0.0, max = core::f64::consts::TAU)]
    hue_to: Modulation<f64>,
    /// Lowest saturation: 0 is grey, 1 is pure colour.
    #[modulation(default = 0.75, min = 0.0, max = 1.0)]
    saturation_from: Modulation<f64>,
    /// Highest saturation.
    #[modulation(default = 1.0, min = 0.0, max = 1.0)]
    saturation_to: Modulation<f64>,
    /// Lowest value: 0 is black, 1 is the camera's brightest.
    #[modulation(default = 0.25, min = 0.0, max = 1.0)]
    value_from: Modulation<f64>,
    /// Highest value.
    #[modulation(default = 1.0, min = 0.0, max = 1.0)]
    value_to: Modulation<f64>,
    /// Fewest pixels of a ball.
    #[modulation(default = 20, unit = "px", min = 1)]
    pixels: Modulation<u32>,
    /// Least share that a ball fills of the disc around it: 1 is a whole ball, 0.5 is half of one.
    #[modulation(default = 0.45, min = 0.0, max = 1.0)]
    roundness: Modulation<f64>,
    /// Radius of the ball.
    #[modulation(default = 0.11, unit = "m", min = 0.001)]
    radius: Modulation<f64>,
    /// The position of the ball. Retracted while there are no pictures, or while the position of the head or a
    /// bound `camera_info` is unknown.
    #[export(validity = "1s")]
    ball: Export<Ball>,
    /// Sequence number of the last picture, and the ball that was published for it.
    last: Option<(u64, Ball)>,
    /// Time of the last picture with the ball, or of the first picture.
    since: Duration,
    blobs: Blobs,
    geometry: CameraGeometry,
}

impl Schema for Finder {
    fn awake(&mut self, cx: &Context) -> Result {
        self.geometry = self.camera.geometry(cx)?;
        // The last position is out of date after a sleep.
        self.last = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let image = self.image.get(cx).filter(|_| !self.camera.is_unknown(cx));
        let (Some(image), Some([pan, tilt])) = (image, self.camera_direction(cx)) else {
            if self.last.take().is_some() {
                self.ball.retract(cx);
            }
            return Ok(());
        };
        let ball = match self.last {
            Some((sequence, _)) if sequence == image.sequence() => return Ok(()),
            Some((_, ball)) => ball,
            None => {
                self.since = image.time();
                Ball::default()
            }
        };
        let pixels = Pixels::of(&image).map_err(|error| format!("import `image`: {error}"))?;
        let size = pixels.size();
        let limits = self.limits(cx);
        let (min_pixels, roundness) = (self.pixels.get(cx) as usize, self.roundness.get(cx));
        let found = self.blobs.largest(
            size,
            |row, column| limits.contains(pixels.at(row, column)),
            |component| component.count >= min_pixels && component.roundness() >= roundness,
        );
        let camera = self.camera.model(cx, &self.geometry, size)?;
        let found = found.map(|(component, runs)| (component.count as u32, camera.observe(runs)));
        if found.is_some() {
            self.since = image.time();
        }
        let frame = if self.pan_tilt.is_bound(cx) {
            "base_link"
        } else {
            "camera"
        };
        let ball = Ball {
            header: Header::new(image.time(), frame),
            seen: found.is_some().into(),
            count: found.map_or(0, |(count, _)| count),
            unseen: image.time().saturating_sub(self.since).as_secs_f64(),
            ..ball
        };
        let ball = found.map_or(ball, |(_, observation)| {
            let [bearing, elevation] = observation.angles(pan, tilt);
            let [column, row] = camera.pixel(observation.direction).unwrap_or_default();
            Ball {
                bearing,
                elevation,
                distance: observation.distance(self.radius.get(cx)),
                column,
                row,
                ..ball
            }
        });
        self.last = Some((image.sequence(), ball));
        self.ball.write_at(cx, ball, image.time());
        Ok(())
    }
}

impl Inspect for Finder {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.camera.inspect(cx, problems);
    }
}

impl Finder {
    /// Returns pan and tilt of the camera, rad; `None` while a bound head has no value.
    fn camera_direction(&self, cx: &Context) -> Option<[f64; 2]> {
        if !self.pan_tilt.is_bound(cx) {
            return Some([0.0; 2]);
        }
        self.pan_tilt.get(cx).map(|head| [head.pan, head.tilt])
    }

    fn limits(&self, cx: &Context) -> ColorRange {
        let part = |modulation: &Modulation<f64>| modulation.get(cx) as f32;
        ColorRange {
            hue: [part(&self.hue_from), part(&self.hue_to)],
            saturation: part(&self.saturation_from)..=part(&self.saturation_to),
            value: part(&self.value_from)..=part(&self.value_to),
        }
    }
}
