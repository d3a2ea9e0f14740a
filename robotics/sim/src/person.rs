//! The figure of a person who stands, walks or sits: where the legs are.
//!
//! `mover` decides where a person walks.

use std::f64::consts::TAU;

use crate::color::Color;
use crate::geometry::Pose2;
use crate::shape::Outline;
use crate::solid::Solid;

/// Metres that a person walks in two steps, left and right.
const GAIT: f64 = 1.3;

/// A person at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Person {
    /// Its place, and the direction that it faces.
    pub(crate) pose: Pose2,
    /// How far the left leg is ahead of the body, as a part of the longest stride, from -1 to 1. The right
    /// leg is as far behind.
    pub(crate) stride: f64,
    /// Whether it sits: both legs are ahead of the body.
    pub(crate) sits: bool,
    pub(crate) radius: f64,
    pub(crate) height: f64,
    pub(crate) color: Color,
    /// The colour of the balls that it holds up, if it does.
    pub(crate) raises: Option<Color>,
}

impl Person {
    /// How far each leg swings, as a part of the body's radius.
    const SWING: f64 = 0.6;
    /// The distance of each leg from the middle, as a part of the body's radius.
    const ASIDE: f64 = 0.4;
    /// The radius of a leg, as a part of the body's radius.
    const LEG: f64 = 0.26;

    /// Returns the middles of both legs, left and right, and their radius. The legs are always within the
    /// body.
    pub(crate) fn feet(&self) -> ([[f64; 2]; 2], f64) {
        let foot = |side: f64| {
            let stride = if self.sits { 1.0 } else { side * self.stride };
            let ahead = stride * Self::SWING * self.radius;
            let foot = self
                .pose
                .compose(Pose2::new(ahead, side * Self::ASIDE * self.radius, 0.0));
            [foot.x, foot.y]
        };
        ([foot(1.0), foot(-1.0)], Self::LEG * self.radius)
    }

    pub(crate) fn legs(&self) -> [Solid; 2] {
        let (feet, radius) = self.feet();
        feet.map(|center| Solid::new(&Outline::Circle { center, radius }))
    }
}

/// Returns the swing of the legs after `walked` metres.
pub(crate) fn stride(walked: f64) -> f64 {
    libm::sin(TAU * walked / GAIT)
}
