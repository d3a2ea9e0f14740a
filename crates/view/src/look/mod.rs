//! How things look everywhere: colors of states and meanings in light and dark, and the units that people like.

mod ink;
pub(crate) mod time;
mod units;

use eframe::egui;

pub(crate) use ink::{exact, ink, state};
pub(crate) use units::{Angle, Length, Units};

/// What all windows of a frame share.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    /// Dark or light.
    pub(crate) dark: bool,
    /// The units in which numbers are shown.
    pub(crate) units: Units,
}

impl Look {
    /// As the context is now.
    pub(crate) fn of(ctx: &egui::Context, units: Units) -> Self {
        Self {
            dark: ctx.global_style().visuals.dark_mode,
            units,
        }
    }
}
