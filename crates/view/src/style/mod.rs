//! How things look everywhere: colors of states and meanings in light and dark, and the units that people like.

mod colors;
pub(crate) mod time;
mod units;

use eframe::egui;

pub(crate) use colors::{color_of, exact, state};
pub(crate) use units::{Angle, Length, Units};

/// What all windows of a frame share.
#[derive(Clone, Debug)]
pub(crate) struct Style {
    /// Dark or light.
    pub(crate) dark: bool,
    /// The units in which numbers are shown.
    pub(crate) units: Units,
}

impl Style {
    /// As the context is now.
    pub(crate) fn of(ctx: &egui::Context, units: Units) -> Self {
        Self {
            dark: ctx.global_style().visuals.dark_mode,
            units,
        }
    }
}
