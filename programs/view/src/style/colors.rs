//! Colors by meaning, readable on light and on dark backgrounds: every text has a contrast of 4.5 to 1. States differ in
//! brightness as well as in hue.

use eframe::egui::{Color32, Theme, Visuals};
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
        Ink::Faint => (Color32::from_gray(158), Color32::from_gray(96)),
        Ink::Accent => (Color32::from_rgb(112, 174, 248), Color32::from_rgb(20, 90, 182)),
        Ink::Good => (Color32::from_rgb(76, 196, 112), Color32::from_rgb(14, 106, 48)),
        Ink::Warn => (Color32::from_rgb(236, 178, 60), Color32::from_rgb(134, 80, 0)),
        Ink::Bad => (Color32::from_rgb(255, 124, 114), Color32::from_rgb(184, 30, 26)),
        Ink::Goal => (Color32::from_rgb(226, 132, 240), Color32::from_rgb(140, 36, 160)),
        Ink::Seen => (Color32::from_rgb(90, 205, 215), Color32::from_rgb(0, 100, 114)),
    };
    if style.dark { dark } else { light }
}

/// The color of a text on a colored ground: black or white, whichever has more contrast.
pub(crate) fn text_on(ground: Color32) -> Color32 {
    let contrasts = [Color32::BLACK, Color32::WHITE].map(|text| contrast(text, ground));
    if contrasts[0] > contrasts[1] {
        Color32::BLACK
    } else {
        Color32::WHITE
    }
}

/// The contrast of two opaque colors, from 1 to 21, by the definition of WCAG 2.
pub(crate) fn contrast(one: Color32, other: Color32) -> f32 {
    let luminance = |color: Color32| {
        let [red, green, blue, _] = color.to_array().map(|part| {
            let part = f32::from(part) / 255.0;
            if part <= 0.04045 {
                part / 12.92
            } else {
                ((part + 0.055) / 1.055).powf(2.4)
            }
        });
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    };
    let (one, other) = (luminance(one), luminance(other));
    (one.max(other) + 0.05) / (one.min(other) + 0.05)
}

/// The colors of egui's own widgets in a theme, readable as the others.
pub(super) fn visuals(theme: Theme, style: &Style) -> Visuals {
    let mut visuals = theme.default_visuals();
    let text = if style.dark { 196 } else { 60 };
    visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(text);
    visuals.weak_text_color = Some(color_of(Ink::Faint, style));
    visuals.warn_fg_color = color_of(Ink::Warn, style);
    visuals.error_fg_color = color_of(Ink::Bad, style);
    visuals.hyperlink_color = color_of(Ink::Accent, style);
    visuals
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
