//! Text as outlines, filled like other shapes. It is sharp at every size and needs no second rasteriser.
//!
//! One typeface, left to right, without kerning, for labels and names. It does no typesetting.

use epaint_default_fonts::UBUNTU_LIGHT;
use skrifa::charmap::Charmap;
use skrifa::metrics::{GlyphMetrics, Metrics};
use skrifa::outline::{DrawSettings, OutlineGlyphCollection, OutlinePen};
use skrifa::prelude::{LocationRef, Size};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use tiny_skia::{Path, PathBuilder};

/// The typeface of the pictures, in its own units.
pub struct Font {
    letters: Charmap<'static>,
    metrics: Metrics,
    widths: GlyphMetrics<'static>,
    outlines: OutlineGlyphCollection<'static>,
}

impl Default for Font {
    /// Reads the built-in typeface.
    fn default() -> Self {
        let font = FontRef::new(UBUNTU_LIGHT).expect("the built-in typeface is valid, as a test checks");
        let (size, regular) = (Size::unscaled(), LocationRef::default());
        Self {
            letters: font.charmap(),
            metrics: font.metrics(size, regular),
            widths: font.glyph_metrics(size, regular),
            outlines: font.outline_glyphs(),
        }
    }
}

impl Font {
    /// The width of a text in pixels, for a size in pixels.
    #[must_use]
    pub fn width(&self, text: &str, size: f32) -> f32 {
        text.chars().map(|letter| self.advance(letter)).sum::<f32>() * self.scale(size)
    }

    /// The height of a capital letter in pixels.
    pub(crate) fn capital(&self, size: f32) -> f32 {
        self.metrics.cap_height.unwrap_or(self.metrics.ascent) * self.scale(size)
    }

    /// Shortens a text to the available width, with an ellipsis in place of the missing letters.
    #[must_use]
    pub fn fitted(&self, text: &str, size: f32, width_limit: f32) -> String {
        let fits = |units: f32| units * self.scale(size) <= width_limit;
        let ellipsis = self.advance('…');
        let (mut units, mut kept_end) = (0.0, None);
        for (place, letter) in text.char_indices() {
            if fits(units + ellipsis) {
                kept_end = Some(place);
            }
            units += self.advance(letter);
            if !fits(units) {
                return kept_end.map_or_else(String::new, |kept_end| format!("{}…", &text[..kept_end]));
            }
        }
        text.to_owned()
    }

    /// The outline of a text whose baseline begins at a point of the picture; none for a text without ink.
    pub(crate) fn outline(&self, text: &str, size: f32, (x, y): (f32, f32)) -> Option<Path> {
        let mut pen = Pen {
            path: PathBuilder::new(),
            x,
            y,
            scale: self.scale(size),
        };
        for letter in text.chars() {
            if let Some(outline) = self.outlines.get(self.glyph(letter)) {
                let unscaled = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
                // What is drawn before an error stays. The glyphs of the built-in typeface cause none.
                let _ = outline.draw(unscaled, &mut pen);
            }
            pen.x += self.advance(letter) * pen.scale;
        }
        pen.path.finish()
    }

    /// The advance of a letter, in the typeface's units.
    fn advance(&self, letter: char) -> f32 {
        self.widths.advance_width(self.glyph(letter)).unwrap_or(0.0)
    }

    /// The glyph of a letter, or the replacement glyph for unknown letters.
    fn glyph(&self, letter: char) -> GlyphId {
        self.letters.map(letter).unwrap_or_default()
    }

    fn scale(&self, size: f32) -> f32 {
        size / f32::from(self.metrics.units_per_em)
    }
}

/// Converts the typeface's units, y up, into pixels, y down.
struct Pen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_of_a_text_fits_its_width() {
        let font = Font::default();
        let bounds = font.outline("goon 42 %", 20.0, (100.0, 50.0)).unwrap().bounds();
        assert!(bounds.left() >= 99.0 && bounds.right() <= 100.0 + font.width("goon 42 %", 20.0) + 1.0);
        assert!(bounds.top() < 50.0 - font.capital(20.0) * 0.9 && bounds.bottom() > 50.0);
    }

    #[test]
    fn a_text_is_shortened_to_the_available_width() {
        let font = Font::default();
        assert_eq!(font.fitted("goon", 20.0, 100.0), "goon");
        let short = font.fitted("a schema of a very long name", 20.0, 100.0);
        assert!(
            short.ends_with('…') && font.width(&short, 20.0) <= 100.0,
            "{short}"
        );
        let kept_end = short.chars().count() - 1;
        let one_more: String = "a schema of a very long name"
            .chars()
            .take(kept_end + 1)
            .collect();
        assert!(font.width(&(one_more + "…"), 20.0) > 100.0, "{short}");
        assert_eq!(font.fitted("goon", 20.0, 1.0), "");
        assert_eq!(font.fitted("goon", 20.0, font.width("goon", 20.0)), "goon");
        let endless = font.fitted(&"m".repeat(1_000_000), 20.0, 100.0);
        assert!(endless.ends_with('…') && endless.len() < 20, "{endless}");
    }

    #[test]
    fn a_text_without_ink_has_no_outline() {
        assert!(Font::default().outline("", 20.0, (0.0, 0.0)).is_none());
        assert!(Font::default().outline("  ", 20.0, (0.0, 0.0)).is_none());
    }

    #[test]
    fn the_typeface_contains_the_letters_of_the_legend() {
        let font = Font::default();
        for letter in "aZ09 %·<().,-−éñ…µ".chars() {
            assert!(font.letters.map(letter).is_some(), "{letter}");
        }
    }
}
