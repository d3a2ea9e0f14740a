//! Rasterises a drawing on light paper.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash,
    Transform,
};

use crate::{Align, Drawing, ElementKind, Fill, LineStyle};

/// Longest side, pixels.
const MAX_SIDE: f32 = 16_384.0;

impl Drawing {
    /// Rasterises the drawing with `scale` pixels per unit.
    pub(crate) fn pixels(&self, scale: f32) -> Pixmap {
        let side = |units: f32| (units * scale).round().clamp(1.0, MAX_SIDE) as u32;
        let pixmap = Pixmap::new(side(self.width), side(self.height));
        let mut pixmap = pixmap.expect("no side is 0 or more than a picture can have");
        pixmap.fill(Color::WHITE);
        let mut rasterizer = Rasterizer {
            pixmap,
            mask: None,
            scale: Transform::from_scale(scale, scale),
        };
        for element in &self.marks {
            rasterizer.clip(element.clip);
            match &element.what {
                ElementKind::Fill(shape, ink) => {
                    if let Some(path) = shape.path() {
                        rasterizer.fill(&path, *ink);
                    }
                }
                ElementKind::Stroke(shape, line) => {
                    if let Some(path) = shape.path() {
                        rasterizer.stroke(&path, *line);
                    }
                }
                ElementKind::Text {
                    text,
                    size,
                    at: (x, y),
                    align,
                    ink,
                } => {
                    let width = self.font.width(text, *size);
                    let left = match align {
                        Align::Left => *x,
                        Align::Middle => x - width / 2.0,
                        Align::Right => x - width,
                    };
                    if let Some(outline) = self.font.outline(text, *size, (left, *y)) {
                        rasterizer.fill(&outline, *ink);
                        // The typeface is light and made for larger sizes; a thin stroke improves legibility.
                        rasterizer.stroke(&outline, LineStyle::new(*ink, size / 50.0));
                    }
                }
                ElementKind::Note(_) => {}
            }
        }
        rasterizer.pixmap
    }
}

struct Rasterizer {
    pixmap: Pixmap,
    mask: Option<(Rect, Mask)>,
    scale: Transform,
}

impl Rasterizer {
    fn clip(&mut self, to: Option<Rect>) {
        if self.mask.as_ref().map(|(rect, _)| *rect) == to {
            return;
        }
        self.mask = to.and_then(|rect| {
            let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
            let path = PathBuilder::from_rect(rect);
            mask.fill_path(&path, FillRule::Winding, false, self.scale);
            Some((rect, mask))
        });
    }

    fn fill(&mut self, path: &Path, ink: Fill) {
        let mask = self.mask.as_ref().map(|(_, mask)| mask);
        self.pixmap
            .fill_path(path, &paint(ink), FillRule::Winding, self.scale, mask);
    }

    fn stroke(&mut self, path: &Path, line: LineStyle) {
        let stroke = Stroke {
            width: line.width,
            line_cap: if line.dash.is_some() {
                LineCap::Butt
            } else {
                LineCap::Round
            },
            line_join: LineJoin::Round,
            dash: line.dash.and_then(|dash| StrokeDash::new(dash.to_vec(), 0.0)),
            ..Stroke::default()
        };
        let mask = self.mask.as_ref().map(|(_, mask)| mask);
        self.pixmap
            .stroke_path(path, &paint(line.ink), &stroke, self.scale, mask);
    }
}

fn paint(ink: Fill) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    let color = ink.tone.light();
    let alpha = (ink.opacity * 255.0).round() as u8;
    paint.set_color_rgba8(color.red(), color.green(), color.blue(), alpha);
    paint
}
