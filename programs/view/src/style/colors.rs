//! Colors by meaning, readable on light and on dark backgrounds. States differ in brightness as well as in
//! hue.

use eframe::egui::Color32;
use jde_core::State;
use jde_panel::{Color, Ink};
use jde_timeline::Severity;

use super::Style;

/// The color of a state.
pub(crate) fn state(state: State, style: &Style) -> Color32 {
    match (state, style.dark) {
        (State::Slept, true) => Color32::from_rgb(70, 74, 82),
        (State::Slept, false) => Color32::from_rgb(206, 210, 216),
        (State::Checking, true) => Color32::from_rgb(66, 112, 168),
        (State::Checking, false) => Color32::from_rgb(134, 174, 220),
        (State::Ready, true) => Color32::from_rgb(226, 176, 60),
        (State::Ready, false) => Color32::from_rgb(214, 152, 20),
        (State::Winner, true) => Color32::from_rgb(76, 196, 112),
        (State::Winner, false) => Color32::from_rgb(26, 138, 66),
    }
}

/// A color by its meaning.
pub(crate) fn color_of(color: Ink, style: &Style) -> Color32 {
    let (dark, light) = match color {
        Ink::Plain => (Color32::from_gray(225), Color32::from_gray(25)),
        Ink::Faint => (Color32::from_gray(115), Color32::from_gray(160)),
        Ink::Accent => (Color32::from_rgb(100, 165, 245), Color32::from_rgb(20, 95, 190)),
        Ink::Good => (Color32::from_rgb(76, 196, 112), Color32::from_rgb(26, 138, 66)),
        Ink::Warn => (Color32::from_rgb(236, 178, 60), Color32::from_rgb(176, 112, 0)),
        Ink::Bad => (Color32::from_rgb(245, 100, 90), Color32::from_rgb(190, 35, 30)),
        Ink::Goal => (Color32::from_rgb(220, 120, 235), Color32::from_rgb(145, 40, 165)),
        Ink::Seen => (Color32::from_rgb(90, 205, 215), Color32::from_rgb(0, 120, 135)),
    };
    if style.dark { dark } else { light }
}

/// The color of what is as good or bad as this.
pub(crate) fn severity(severity: Severity) -> Ink {
    match severity {
        Severity::Good => Ink::Good,
        Severity::Warning => Ink::Warn,
        Severity::Bad => Ink::Bad,
    }
}

/// A color of a panel.
pub(crate) fn exact(color: Color, style: &Style) -> Color32 {
    match color {
        Color::Ink(meaning) => color_of(meaning, style),
        Color::Exact([red, green, blue, alpha]) => Color32::from_rgba_unmultiplied(red, green, blue, alpha),
    }
}
