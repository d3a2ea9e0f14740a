//! Drives to a coloured thing on the floor. It avoids no obstacles: another schema must brake.

use jde_schema::prelude::*;
use jde_schema::types::{ColorBlob, ColorBlobs};

/// Oldest picture to steer by.
const MAX_AGE: Duration = Duration::from_millis(500);

/// Drives the base toward the nearest area of a colour on the floor, more slowly as it gets nearer, and stops
/// at a distance. Ready while there is one farther away than that.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Approach {
    /// The areas, with their places on the floor.
    #[import(trigger)]
    blobs: Import<ColorBlobs>,
    /// The number of the colour, from 0 in the order of the ranges of `see/color`.
    #[modulation(default = 0)]
    color: Modulation<u32>,
    /// Distance at which it stops, from the middle of the base along the floor.
    #[modulation(default = 0.7, unit = "m", min = 0.0)]
    distance: Modulation<f64>,
    /// Additional distance at which it starts again.
    #[modulation(default = 0.1, unit = "m", min = 0.0)]
    margin: Modulation<f64>,
    /// Highest speed.
    #[modulation(default = 0.3, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speed per metre of remaining distance.
    #[modulation(default = 0.5, unit = "1/s", min = 0.0)]
    gain: Modulation<f64>,
    /// Turn rate per radian to the thing.
    #[modulation(default = 1.0, unit = "1/s", min = 0.0)]
    turn: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 0.6, unit = "rad/s", min = 0.0)]
    turn_rate: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    far: Hysteresis,
}

impl Schema for Approach {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(nearest) = self.nearest(cx) else {
            self.far.reset();
            return Ok(false.into());
        };
        let stop = self.distance.get(cx);
        let far = self.far.above(
            libm::hypot(nearest.x, nearest.y),
            stop + self.margin.get(cx),
            stop,
        );
        Ok(far.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = self.nearest(cx).map_or(Twist::ZERO, |nearest| {
            let bearing = libm::atan2(nearest.y, nearest.x);
            let remaining = libm::hypot(nearest.x, nearest.y) - self.distance.get(cx);
            let fastest = self.turn_rate.get(cx);
            let speed = (self.gain.get(cx) * remaining).clamp(0.0, self.speed.get(cx));
            Twist::planar(
                speed * libm::cos(bearing).max(0.0),
                (self.turn.get(cx) * bearing).clamp(-fastest, fastest),
            )
        });
        self.base.command(cx, twist);
        Ok(())
    }
}

impl Approach {
    /// Returns the nearest area of the colour on the floor, if the picture is recent.
    fn nearest(&self, cx: &Context) -> Option<ColorBlob> {
        let blobs = self.blobs.get(cx).filter(|blobs| blobs.age(cx) <= MAX_AGE)?;
        let color = self.color.get(cx);
        let standing = blobs
            .blobs
            .iter()
            .filter(|blob| blob.color == color && blob.on_floor.get());
        let distance = |blob: &ColorBlob| libm::hypot(blob.x, blob.y);
        standing
            .copied()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}
