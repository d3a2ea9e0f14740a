//! How a world is lit: one distant light, and what comes back from all around.
//!
//! Casts no shadows; how far a thing is makes no difference.

use crate::color::Color;

/// What a world looks like where nothing stands, and where its light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Light {
    /// The unit vector toward the light, in the frame of the world.
    pub(crate) direction: [f64; 3],
    pub(crate) floor: Color,
    pub(crate) sky: Color,
}

/// What a face gets from all around.
const AMBIENT: f64 = 0.64;
/// What a face gets from the light that it looks into.
const DIRECT: f64 = 0.36;
/// What a face gets that looks straight away from the light, from what the light falls on there.
const RETURNED: f64 = 0.14;

impl Default for Light {
    fn default() -> Self {
        Self {
            // From high ahead and to the left of one who looks along x: the four sides of a box differ.
            direction: [-0.48, 0.36, 0.8],
            floor: Color::new(150, 143, 131),
            sky: Color::new(196, 214, 232),
        }
    }
}

impl Light {
    /// The colour of a face with a unit normal: Lambert's law.
    pub(crate) fn shade(&self, color: Color, normal: [f64; 3]) -> [u8; 3] {
        let facing: f64 = (0..3).map(|axis| normal[axis] * self.direction[axis]).sum();
        let strength = AMBIENT + DIRECT * facing.max(0.0) + RETURNED * (-facing).max(0.0);
        [color.r, color.g, color.b].map(|part| scale(part, strength))
    }
}

/// A part of a colour under a light of some strength, rounded.
fn scale(part: u8, strength: f64) -> u8 {
    (f64::from(part) * strength + 0.5) as u8
}
