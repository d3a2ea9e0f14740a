//! The figure of a person who stands or walks: where the legs are.
//!
//! Where a person goes is the business of `mover`.

use std::f64::consts::TAU;

use crate::color::Color;
use crate::geometry::Pose2;
use crate::shape::Outline;
use crate::solid::Solid;

/// Metres that a person walks with two steps, left and right.
const GAIT: f64 = 1.3;

/// A person as it stands or walks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Person {
    /// Where it is and faces.
    pub(crate) pose: Pose2,
    /// How far the left leg is ahead of the body, as a part of the longest stride, from -1 to 1; the right one is as far behind.
    pub(crate) stride: f64,
    pub(crate) radius: f64,
    pub(crate) height: f64,
    pub(crate) color: Color,
}

impl Person {
    /// How far each leg swings, beside the radius of the body.
    const SWING: f64 = 0.6;
    /// How far each leg is from the middle, beside the radius of the body.
    const ASIDE: f64 = 0.4;
    /// How thick a leg is, beside the radius of the body.
    const LEG: f64 = 0.26;

    /// The middles of both legs, left and right, and their radius; always within the body.
    pub(crate) fn feet(&self) -> ([[f64; 2]; 2], f64) {
        let foot = |side: f64| {
            let ahead = side * self.stride * Self::SWING * self.radius;
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

/// The swing of the legs after so many metres of walking.
pub(crate) fn stride(walked: f64) -> f64 {
    libm::sin(TAU * walked / GAIT)
}
