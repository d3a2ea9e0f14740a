//! Times as text, and names cut to a width.

use jde_core::Nanos;
use ratatui::text::Span;

pub use jde_app::period::{format_duration, format_setting, parse as period};

/// Returns a time since the start in seconds: "12.345 s".
pub fn format_time(nanos: Nanos) -> String {
    format!("{:.3} s", nanos as f64 / 1e9)
}

/// Cuts or pads a text to a width in columns of the terminal.
pub(super) fn pad_or_cut(text: &str, width: usize) -> String {
    let mut fitted = cut(text, width);
    fitted.extend(std::iter::repeat_n(' ', width - columns(&fitted)));
    fitted
}

/// Cuts a text to a width in columns of the terminal. An ellipsis marks the cut.
pub fn cut(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for letter in text.chars() {
        let longer = format!("{kept}{letter}");
        if columns(&longer) + 1 > width {
            break;
        }
        kept = longer;
    }
    if width > 0 {
        kept.push('…');
    }
    kept
}

/// Cuts a text to a width in columns of the terminal and keeps its end. An ellipsis marks the cut.
pub fn cut_start(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.to_owned();
    }
    let ends = text.char_indices().map(|(start, _)| &text[start..]);
    let kept = ends.skip(1).find(|end| columns(end) < width);
    let ellipsis = if width > 0 { "…" } else { "" };
    format!("{ellipsis}{}", kept.unwrap_or_default())
}

/// Returns how many columns of the terminal a text takes.
pub fn columns(text: &str) -> usize {
    Span::raw(text).width()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_cut_and_padded_to_columns() {
        assert_eq!(pad_or_cut("goon", 6), "goon  ");
        assert_eq!(pad_or_cut("safe-navigation", 6), "safe-…");
        assert_eq!(pad_or_cut("走行走行", 6), "走行… ");
        assert_eq!(pad_or_cut("x", 0), "");
    }

    #[test]
    fn a_text_is_cut_at_its_start() {
        assert_eq!(cut_start("goon", 6), "goon");
        assert_eq!(cut_start("safe-navigation", 6), "…ation");
        assert_eq!(cut_start("走行走行", 6), "…走行");
        assert_eq!(cut_start("goon", 1), "…");
        assert_eq!(cut_start("goon", 0), "");
    }
}
