//! The lighting of a world: one distant light, and ambient light.
//!
//! There are no shadows, and the distance of a thing makes no difference.

use crate::color::Color;

/// The colour of the sky, and the direction of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Light {
    /// The unit vector toward the light, in the frame of the world.
    pub(crate) direction: [f64; 3],
    pub(crate) sky: Color,
}

/// The ambient light on every face.
const AMBIENT: f64 = 0.64;
/// The extra light on a face that looks straight into the light.
const DIRECT: f64 = 0.36;
/// The extra light on a face that looks straight away from the light: light that surfaces there reflect.
const RETURNED: f64 = 0.14;

impl Default for Light {
    fn default() -> Self {
        Self {
            // High, behind and to the left of a viewer who looks along x: the four sides of a box differ.
            direction: [-0.48, 0.36, 0.8],
            sky: Color::new(196, 214, 232),
        }
    }
}

impl Light {
    /// Returns the colour of a face with a unit normal: Lambert's law.
    pub(crate) fn shade(&self, color: Color, normal: [f64; 3]) -> [u8; 3] {
        let facing: f64 = (0..3).map(|axis| normal[axis] * self.direction[axis]).sum();
        let strength = AMBIENT + DIRECT * facing.max(0.0) + RETURNED * (-facing).max(0.0);
        [color.r, color.g, color.b].map(|part| scale(part, strength))
    }
}

/// Scales a component of a colour, rounded.
fn scale(part: u8, strength: f64) -> u8 {
    (f64::from(part) * strength + 0.5) as u8
}
