//! Charts over time: bands of states, lines of numbers, and the time axis below. The callers place them.

mod axis;
mod bands;
mod lines;

pub(crate) use axis::{numbers as axis_numbers, seconds, time_axis, time_grid};
pub(crate) use bands::{Bands, NAMES, NUMBERS};
pub(crate) use lines::{charts, small_chart};

/// A part of the drawing, units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    pub(crate) left: f32,
    pub(crate) top: f32,
    pub(crate) width: f32,
    pub(crate) height: f32,
}

impl Area {
    pub(crate) fn right(self) -> f32 {
        self.left + self.width
    }

    pub(crate) fn bottom(self) -> f32 {
        self.top + self.height
    }
}

/// Text size of names and numbers, units.
pub(crate) const TEXT: f32 = 16.0;
/// Text size of minor labels, units.
pub(crate) const SMALL: f32 = 14.0;
