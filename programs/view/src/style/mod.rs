//! The common style of all windows: colors of states and meanings in light and dark, and the user's units.

mod colors;
pub(crate) mod time;
mod units;

use eframe::egui;

pub(crate) use colors::{color_of, exact, severity, state};
pub(crate) use units::{Angle, Length, Units};

/// The style that all windows of a frame share.
#[derive(Clone, Debug)]
pub(crate) struct Style {
    /// Whether the theme is dark.
    pub(crate) dark: bool,
    /// Units of displayed numbers.
    pub(crate) units: Units,
}

impl Style {
    /// The style of the context's current theme.
    pub(crate) fn of(ctx: &egui::Context, units: Units) -> Self {
        Self {
            dark: ctx.global_style().visuals.dark_mode,
            units,
        }
    }
}
