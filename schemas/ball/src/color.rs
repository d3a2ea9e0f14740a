//! Selects the pixels of the ball's colour. It ignores neighbouring pixels; `blob` connects them.

use core::f32::consts::{FRAC_PI_3, TAU};
use core::ops::RangeInclusive;

/// Limits of hue (rad; 0 is red, 2π/3 green), saturation and value (0 to 1).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limits {
    /// From the first hue upward to the second, through 2π if the second is smaller.
    pub(crate) hue: [f32; 2],
    pub(crate) saturation: RangeInclusive<f32>,
    pub(crate) value: RangeInclusive<f32>,
}

impl Limits {
    /// Whether a red-green-blue pixel is within all limits.
    pub(crate) fn contain(&self, [r, g, b]: [u8; 3]) -> bool {
        let (most, least) = (r.max(g).max(b), r.min(g).min(b));
        let (value, spread) = (f32::from(most), f32::from(most - least));
        // This rejects most pixels before the costly computation of the hue.
        if !self.value.contains(&(value / 255.0)) || !self.saturation.contains(&(spread / value.max(1.0))) {
            return false;
        }
        if most == least {
            // Grey has no hue. It counts if the limits of saturation admit it.
            return true;
        }
        let part = |a: u8, b: u8| (f32::from(a) - f32::from(b)) / spread;
        let sixth = if most == r {
            part(g, b)
        } else if most == g {
            2.0 + part(b, r)
        } else {
            4.0 + part(r, g)
        };
        let above = |from: f32| (sixth * FRAC_PI_3 - from).rem_euclid(TAU);
        let [from, to] = self.hue;
        above(from) <= (to - from).rem_euclid(TAU) || to - from >= TAU
    }
}
