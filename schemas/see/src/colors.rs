//! Ranges of colour as values of application files.

use std::fmt;

use jde_schema::prelude::*;
use jde_vision::ColorRange;

/// A range of colour, with its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ColorLimits")]
pub struct ColorLimits {
    /// What people call it.
    pub name: Text<20>,
    /// First hue; red is 0, yellow 60 and green 120 degrees.
    #[value(unit = "rad")]
    pub hue_from: f64,
    /// Last hue; smaller than the first if the range contains red.
    #[value(unit = "rad")]
    pub hue_to: f64,
    /// Lowest saturation: 0 is grey, 1 is pure colour.
    pub saturation_from: f64,
    /// Highest saturation.
    pub saturation_to: f64,
    /// Lowest value: 0 is black, 1 is the camera's brightest.
    pub value_from: f64,
    /// Highest value.
    pub value_to: f64,
}

/// The colours to find.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Colors")]
pub struct Colors {
    /// The ranges. They may overlap.
    pub ranges: Seq<ColorLimits, 8>,
}

impl ColorLimits {
    /// The orange of balls and cones.
    const ORANGE: Self = Self {
        name: Text::new("orange"),
        hue_from: 14_f64.to_radians(),
        hue_to: 36_f64.to_radians(),
        saturation_from: 0.75,
        saturation_to: 1.0,
        value_from: 0.25,
        value_to: 1.0,
    };

    /// Returns these limits with another range.
    pub(crate) fn with(self, range: &ColorRange) -> Self {
        Self {
            hue_from: range.hue[0].into(),
            hue_to: range.hue[1].into(),
            saturation_from: (*range.saturation.start()).into(),
            saturation_to: (*range.saturation.end()).into(),
            value_from: (*range.value.start()).into(),
            value_to: (*range.value.end()).into(),
            ..self
        }
    }

    pub(crate) fn range(&self) -> ColorRange {
        ColorRange {
            hue: [self.hue_from as f32, self.hue_to as f32],
            saturation: self.saturation_from as f32..=self.saturation_to as f32,
            value: self.value_from as f32..=self.value_to as f32,
        }
    }
}

impl Colors {
    /// Orange alone.
    pub(crate) fn orange() -> Self {
        Self {
            ranges: core::iter::once(ColorLimits::ORANGE).collect(),
        }
    }
}

/// The line of an application file that states these colours.
impl fmt::Display for Colors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("colors = { ranges = [")?;
        for (number, limits) in self.ranges.iter().enumerate() {
            if number > 0 {
                f.write_str(", ")?;
            }
            let ColorLimits {
                name,
                hue_from,
                hue_to,
                saturation_from,
                saturation_to,
                value_from,
                value_to,
            } = limits;
            write!(
                f,
                "[{:?}, \"{:.0} deg\", \"{:.0} deg\", {saturation_from:.2}, {saturation_to:.2}, {value_from:.2}, {value_to:.2}]",
                name.as_str(),
                hue_from.to_degrees(),
                hue_to.to_degrees(),
            )?;
        }
        f.write_str("] }")
    }
}
