//! A drawing: strokes, areas and texts in units of its own. [`raster`] converts it into pixels and [`svg`]
//! into a part of a page, so that both show the same.
//!
//! It knows no metres and seconds; its callers convert those into units.

pub(crate) mod color_role;
mod font;
mod raster;
mod shape;
#[cfg(feature = "recordings")]
mod svg;

use tiny_skia::Rect;

pub(crate) use color_role::ColorRole;
pub(crate) use font::Font;
pub(crate) use shape::{Point, Shape};

/// A colour and its opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fill {
    pub(crate) tone: ColorRole,
    /// 0 is invisible, 1 hides what is below.
    pub(crate) opacity: f32,
}

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) ink: Fill,
    /// Width, units.
    pub(crate) width: f32,
    /// Lengths of dash and gap, units; `None` for a solid line.
    pub(crate) dash: Option<[f32; 2]>,
}

/// The side of its point on which a text is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    Left,
    Middle,
    Right,
}

/// The elements, from bottom to top.
pub(crate) struct Drawing {
    width: f32,
    height: f32,
    marks: Vec<Element>,
    clip: Option<Rect>,
    font: Font,
}

/// One element.
struct Element {
    what: ElementKind,
    /// The rectangle outside of which nothing is drawn.
    clip: Option<Rect>,
}

enum ElementKind {
    Fill(Shape, Fill),
    Stroke(Shape, Line),
    Text {
        text: String,
        size: f32,
        at: Point,
        align: Align,
        ink: Fill,
    },
    /// The tooltip of the following elements, until the next note.
    Note(Option<String>),
}

impl From<ColorRole> for Fill {
    fn from(tone: ColorRole) -> Self {
        Self { tone, opacity: 1.0 }
    }
}

impl ColorRole {
    /// The colour with this opacity.
    pub(crate) fn faded(self, opacity: f32) -> Fill {
        Fill {
            tone: self,
            opacity: opacity.clamp(0.0, 1.0),
        }
    }
}

impl Line {
    pub(crate) fn new(ink: impl Into<Fill>, width: f32) -> Self {
        Self {
            ink: ink.into(),
            width,
            dash: None,
        }
    }

    pub(crate) fn dashed(self, line: f32, gap: f32) -> Self {
        Self {
            dash: Some([line, gap]),
            ..self
        }
    }
}

impl Drawing {
    pub(crate) fn new(width: f32, height: f32) -> Self {
        Self {
            width: width.max(1.0),
            height: height.max(1.0),
            marks: Vec::new(),
            clip: None,
            font: Font::new(),
        }
    }

    /// Restricts drawing to a rectangle, or lifts the restriction.
    pub(crate) fn clip(&mut self, to: Option<Rect>) {
        self.clip = to;
    }

    pub(crate) fn fill(&mut self, shape: Shape, ink: impl Into<Fill>) {
        self.add(ElementKind::Fill(shape, ink.into()));
    }

    pub(crate) fn stroke(&mut self, shape: Shape, line: Line) {
        self.add(ElementKind::Stroke(shape, line));
    }

    /// Draws a line through points; a dot if all points are the same.
    pub(crate) fn polyline(&mut self, points: &[Point], line: Line) {
        let Some(first) = points.first() else { return };
        // A line between equal points has no length to stroke.
        if points.iter().any(|point| point != first) {
            self.stroke(Shape::Line(points.to_vec()), line);
        } else {
            self.disc(*first, line.width / 2.0, line.ink);
        }
    }

    pub(crate) fn polygon(&mut self, points: &[Point], ink: impl Into<Fill>) {
        self.fill(Shape::Area(points.to_vec()), ink);
    }

    pub(crate) fn disc(&mut self, at: Point, radius: f32, ink: impl Into<Fill>) {
        self.fill(Shape::Disc(at, radius), ink);
    }

    pub(crate) fn ring(&mut self, at: Point, radius: f32, line: Line) {
        self.stroke(Shape::Disc(at, radius), line);
    }

    /// Fills a rectangle; draws nothing if it has no size.
    pub(crate) fn bar(&mut self, (x, y): Point, width: f32, height: f32, ink: impl Into<Fill>) {
        if let Some(rect) = Rect::from_xywh(x, y, width, height) {
            self.fill(Shape::Box(rect), ink);
        }
    }

    /// Draws a text on its baseline.
    pub(crate) fn text(&mut self, text: &str, size: f32, at: Point, align: Align, ink: impl Into<Fill>) {
        self.add(ElementKind::Text {
            text: text.to_owned(),
            size,
            at,
            align,
            ink: ink.into(),
        });
    }

    /// Draws a text with its capital letters centred at a height.
    pub(crate) fn label(&mut self, text: &str, size: f32, (x, y): Point, align: Align, ink: impl Into<Fill>) {
        let base = y + self.font.capital(size) / 2.0;
        self.text(text, size, (x, base), align, ink);
    }

    /// Sets the tooltip of the following elements, or none.
    pub(crate) fn note(&mut self, note: Option<String>) {
        self.add(ElementKind::Note(note));
    }

    /// The width of a text, units.
    pub(crate) fn width(&self, text: &str, size: f32) -> f32 {
        self.font.width(text, size)
    }

    /// Shortens a text to the available width, with an ellipsis in place of the missing letters.
    pub(crate) fn fitted(&self, text: &str, size: f32, width: f32) -> String {
        self.font.fitted(text, size, width)
    }

    fn add(&mut self, what: ElementKind) {
        self.marks.push(Element {
            what,
            clip: self.clip,
        });
    }
}
