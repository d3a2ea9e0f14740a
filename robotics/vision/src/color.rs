//! Colours by hue, saturation and value, and ranges of them. It ignores neighbouring pixels; `blob` connects
//! them.

use core::f32::consts::{FRAC_PI_3, PI, TAU};
use core::ops::RangeInclusive;

/// How far the hue of a calibrated range exceeds its samples, rad: about the noise of a camera at rest.
const HUE_MARGIN: f32 = 8.0 * PI / 180.0;
/// How far saturation and value exceed the samples: light changes them more than the hue.
const MARGIN: f32 = 0.15;

/// The least saturation of a sample: below it the noise of a camera determines the hue.
const LEAST_SATURATION: f32 = 0.15;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hsv {
    /// From 0 (red) through 2π/3 (green) to below 2π, rad; `None` for grey.
    pub hue: Option<f32>,
    /// From 0 (grey) to 1 (pure colour).
    pub saturation: f32,
    /// From 0 (black) to 1.
    pub value: f32,
}

/// Limits of hue, saturation and value.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorRange {
    /// From the first hue upward to the second, through 2π if the second is smaller, rad.
    pub hue: [f32; 2],
    /// From 0 to 1.
    pub saturation: RangeInclusive<f32>,
    /// From 0 to 1.
    pub value: RangeInclusive<f32>,
}

impl Hsv {
    /// Returns the colour of a red-green-blue pixel.
    #[must_use]
    pub fn of(pixel: [u8; 3]) -> Self {
        let (most, least) = extremes(pixel);
        let (value, spread) = (f32::from(most), f32::from(most - least));
        Self {
            hue: hue(pixel),
            saturation: spread / value.max(1.0),
            value: value / 255.0,
        }
    }
}

impl ColorRange {
    /// Whether a red-green-blue pixel is within all limits. Grey has no hue; it is within them if those of the
    /// saturation admit it.
    #[must_use]
    pub fn contains(&self, pixel: [u8; 3]) -> bool {
        let (most, least) = extremes(pixel);
        let (value, spread) = (f32::from(most), f32::from(most - least));
        // Most pixels are rejected here, before the costly computation of the hue.
        if !self.value.contains(&(value / 255.0)) || !self.saturation.contains(&(spread / value.max(1.0))) {
            return false;
        }
        let [from, to] = self.hue;
        let above = |hue: f32| (hue - from).rem_euclid(TAU) <= (to - from).rem_euclid(TAU);
        hue(pixel).is_none_or(|hue| above(hue) || to - from >= TAU)
    }

    /// Returns the least range of all these red-green-blue pixels, and a margin for noise and light around it;
    /// `None` if all pixels are nearly grey. Those that are do not count.
    #[must_use]
    pub fn around(pixels: &[[u8; 3]]) -> Option<Self> {
        let colors = pixels.iter().map(|pixel| Hsv::of(*pixel));
        let colors: Vec<_> = colors
            .filter(|color| color.saturation >= LEAST_SATURATION)
            .collect();
        let reference = colors.first()?.hue?;
        // The hue is an angle: differences from one of the samples have an order.
        let turns = colors.iter().filter_map(|color| color.hue);
        let turns = turns.map(|hue| (hue - reference + PI).rem_euclid(TAU) - PI);
        let (least, most) = bounds(turns);
        let limits = |part: fn(&Hsv) -> f32| {
            let (least, most) = bounds(colors.iter().map(part));
            (least - MARGIN).max(0.0)..=(most + MARGIN).min(1.0)
        };
        Some(Self {
            hue: [least - HUE_MARGIN, most + HUE_MARGIN].map(|turn| (reference + turn).rem_euclid(TAU)),
            saturation: limits(|color| color.saturation),
            value: limits(|color| color.value),
        })
    }
}

fn bounds(numbers: impl Iterator<Item = f32>) -> (f32, f32) {
    numbers.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), number| {
        (least.min(number), most.max(number))
    })
}

fn extremes([r, g, b]: [u8; 3]) -> (u8, u8) {
    (r.max(g).max(b), r.min(g).min(b))
}

/// Returns the hue of a pixel, rad; `None` for grey.
fn hue(pixel: [u8; 3]) -> Option<f32> {
    let (most, least) = extremes(pixel);
    let [r, g, b] = pixel;
    let spread = f32::from(most - least);
    let part = |a: u8, b: u8| (f32::from(a) - f32::from(b)) / spread;
    let sixth = match most {
        _ if most == least => return None,
        most if most == r => part(g, b),
        most if most == g => 2.0 + part(b, r),
        _ => 4.0 + part(r, g),
    };
    Some((sixth * FRAC_PI_3).rem_euclid(TAU))
}
