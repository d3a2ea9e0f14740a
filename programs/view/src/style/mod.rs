//! The common style of all windows: colors of states and meanings in light and dark, and the user's units.

mod colors;
pub(crate) mod time;
mod units;

use eframe::egui;

#[cfg(test)]
pub(crate) use colors::contrast;
pub(crate) use colors::{color_of, exact, severity, state, text_on};
pub(crate) use units::{Angle, Length, Units};

/// The style that all windows of a frame share.
#[derive(Clone, Debug)]
pub(crate) struct Style {
    /// Whether the theme is dark.
    pub(crate) dark: bool,
    /// Units of displayed numbers.
    pub(crate) units: Units,
}

/// Gives egui's own widgets the colors of both themes.
pub(crate) fn install(ctx: &egui::Context) {
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        let style = Style {
            dark: theme == egui::Theme::Dark,
            units: Units::default(),
        };
        ctx.set_visuals_of(theme, colors::visuals(theme, &style));
    }
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
