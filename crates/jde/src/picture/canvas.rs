//! White paper of a size in pixels, and the few strokes that the picture is made of.
//!
//! It refuses to know metres; `frame` turns those into pixels.

use tiny_skia::{
    ColorU8, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash,
    Transform,
};

use super::font::Font;

/// How a line is drawn.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) color: ColorU8,
    /// Pixels.
    pub(super) width: f32,
    /// Pixels of line and of gap; `None` is a whole line.
    pub(super) dash: Option<[f32; 2]>,
}

/// Where a text stands beside its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

/// The paper.
pub(super) struct Canvas {
    pixmap: Pixmap,
    clip: Option<Mask>,
    font: Font,
}

impl Line {
    pub(super) fn new(color: ColorU8, width: f32) -> Self {
        Self {
            color,
            width,
            dash: None,
        }
    }

    pub(super) fn dashed(self, line: f32, gap: f32) -> Self {
        Self {
            dash: Some([line, gap]),
            ..self
        }
    }
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let mut pixmap =
            Pixmap::new(width.max(1), height.max(1)).expect("a frame has a size that fits in memory");
        pixmap.fill(tiny_skia::Color::WHITE);
        Self {
            pixmap,
            clip: None,
            font: Font::new(),
        }
    }

    pub(super) fn into_pixmap(self) -> Pixmap {
        self.pixmap
    }

    /// Lets ink only fall inside a rectangle, or everywhere again.
    pub(super) fn clip(&mut self, to: Option<Rect>) {
        self.clip = to.and_then(|rect| {
            let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
            mask.fill_path(
                &PathBuilder::from_rect(rect),
                FillRule::Winding,
                false,
                Transform::identity(),
            );
            Some(mask)
        });
    }

    pub(super) fn fill(&mut self, path: &Path, color: ColorU8) {
        let fill = FillRule::Winding;
        self.pixmap
            .fill_path(path, &ink(color), fill, Transform::identity(), self.clip.as_ref());
    }

    pub(super) fn stroke(&mut self, path: &Path, line: &Line) {
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
        self.pixmap.stroke_path(
            path,
            &ink(line.color),
            &stroke,
            Transform::identity(),
            self.clip.as_ref(),
        );
    }

    /// Draws a line through points; one point alone is a dot.
    pub(super) fn polyline(&mut self, points: &[(f32, f32)], line: &Line) {
        match points {
            [] => {}
            [alone] => self.disc(*alone, line.width / 2.0, line.color),
            [(x, y), rest @ ..] => {
                let mut path = PathBuilder::new();
                path.move_to(*x, *y);
                for (x, y) in rest {
                    path.line_to(*x, *y);
                }
                // A way that never leaves its place has no length to stroke.
                match path
                    .finish()
                    .filter(|path| path.bounds().width() + path.bounds().height() > 0.0)
                {
                    Some(path) => self.stroke(&path, line),
                    None => self.disc((*x, *y), line.width / 2.0, line.color),
                }
            }
        }
    }

    pub(super) fn polygon(&mut self, points: &[(f32, f32)], color: ColorU8) {
        if let Some(path) = closed(points) {
            self.fill(&path, color);
        }
    }

    pub(super) fn disc(&mut self, (x, y): (f32, f32), radius: f32, color: ColorU8) {
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            self.fill(&path, color);
        }
    }

    pub(super) fn ring(&mut self, (x, y): (f32, f32), radius: f32, line: &Line) {
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            self.stroke(&path, line);
        }
    }

    pub(super) fn dot(&mut self, square: Rect, color: ColorU8) {
        self.pixmap
            .fill_rect(square, &ink(color), Transform::identity(), self.clip.as_ref());
    }

    /// Writes a text at its base line.
    pub(super) fn text(&mut self, text: &str, size: f32, (x, y): (f32, f32), align: Align, color: ColorU8) {
        let width = self.font.width(text, size);
        let left = match align {
            Align::Left => x,
            Align::Middle => x - width / 2.0,
            Align::Right => x - width,
        };
        if let Some(outline) = self.font.outline(text, size, (left, y)) {
            self.fill(&outline, color);
            // The typeface is a light one, made for larger sizes: a hair of ink more reads better.
            self.stroke(&outline, &Line::new(color, size / 50.0));
        }
    }

    /// Writes a text with the middle of its capital letters at a height.
    pub(super) fn label(&mut self, text: &str, size: f32, (x, y): (f32, f32), align: Align, color: ColorU8) {
        let base = y + self.font.capital(size) / 2.0;
        self.text(text, size, (x, base), align, color);
    }
}

/// Closes points to an area; nothing without three of them.
pub(super) fn closed(points: &[(f32, f32)]) -> Option<Path> {
    let [(x, y), rest @ ..] = points else { return None };
    let mut path = PathBuilder::new();
    path.move_to(*x, *y);
    for (x, y) in rest {
        path.line_to(*x, *y);
    }
    path.close();
    path.finish()
}

fn ink(color: ColorU8) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(color.red(), color.green(), color.blue(), color.alpha());
    paint
}
