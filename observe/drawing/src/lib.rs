//! Drawings without a screen: strokes, areas and texts in units of their own. The same drawing becomes pixels
//! ([`Picture`]) and a part of a page ([`Drawing::svg`]). A [`map`] is the drawing of a drive.
//!
//! A drawing knows no metres and seconds; its callers convert those into units. This crate reads no recording and prints
//! nothing.

mod color_role;
mod font;
pub mod map;
mod picture;
mod raster;
mod round;
mod shape;
mod svg;
pub mod text;

use tiny_skia::Rect;

pub use color_role::{ColorRole, style};
pub use font::Font;
pub use picture::{Picture, PictureError};
pub use round::round_up;
pub use shape::{DrawnShape, Point};

/// A colour and its opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// The colour.
    pub tone: ColorRole,
    /// 0 is invisible, 1 hides what is below.
    pub opacity: f32,
}

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    /// The colour of the line.
    pub ink: Fill,
    /// Width, units.
    pub width: f32,
    /// Lengths of dash and gap, units; `None` for a solid line.
    pub dash: Option<[f32; 2]>,
}

/// The side of its point on which a text is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// The text begins there.
    Left,
    /// The middle of the text is there.
    Middle,
    /// The text ends there.
    Right,
}

/// The elements, from bottom to top.
pub struct Drawing {
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
    Fill(DrawnShape, Fill),
    Stroke(DrawnShape, LineStyle),
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
    #[must_use]
    pub fn faded(self, opacity: f32) -> Fill {
        Fill {
            tone: self,
            opacity: opacity.clamp(0.0, 1.0),
        }
    }
}

impl LineStyle {
    /// A solid line of a width in units.
    pub fn new(ink: impl Into<Fill>, width: f32) -> Self {
        Self {
            ink: ink.into(),
            width,
            dash: None,
        }
    }

    /// The same line with dashes and gaps of these lengths, units.
    #[must_use]
    pub fn dashed(self, line: f32, gap: f32) -> Self {
        Self {
            dash: Some([line, gap]),
            ..self
        }
    }
}

impl Drawing {
    /// An empty drawing of a size in units.
    #[must_use]
    pub fn new(width: f32, height: f32) -> Self {
        Self {
            width: width.max(1.0),
            height: height.max(1.0),
            marks: Vec::new(),
            clip: None,
            font: Font::default(),
        }
    }

    /// Restricts drawing to a rectangle, or lifts the restriction.
    pub fn clip(&mut self, to: Option<Rect>) {
        self.clip = to;
    }

    /// Fills a shape.
    pub fn fill(&mut self, shape: DrawnShape, ink: impl Into<Fill>) {
        self.add(ElementKind::Fill(shape, ink.into()));
    }

    /// Draws the outline of a shape.
    pub fn stroke(&mut self, shape: DrawnShape, line: LineStyle) {
        self.add(ElementKind::Stroke(shape, line));
    }

    /// Draws a line through points; a dot if all points are the same.
    pub fn polyline(&mut self, points: &[Point], line: LineStyle) {
        let Some(first) = points.first() else { return };
        // A line between equal points has no length to stroke.
        if points.iter().any(|point| point != first) {
            self.stroke(DrawnShape::Line(points.to_vec()), line);
        } else {
            self.disc(*first, line.width / 2.0, line.ink);
        }
    }

    /// Fills the area between points.
    pub fn polygon(&mut self, points: &[Point], ink: impl Into<Fill>) {
        self.fill(DrawnShape::Area(points.to_vec()), ink);
    }

    /// Fills a disc.
    pub fn disc(&mut self, at: Point, radius: f32, ink: impl Into<Fill>) {
        self.fill(DrawnShape::Disc(at, radius), ink);
    }

    /// Draws a circle.
    pub fn ring(&mut self, at: Point, radius: f32, line: LineStyle) {
        self.stroke(DrawnShape::Disc(at, radius), line);
    }

    /// Fills a rectangle; draws nothing if it has no size.
    pub fn bar(&mut self, (x, y): Point, width: f32, height: f32, ink: impl Into<Fill>) {
        if let Some(rect) = Rect::from_xywh(x, y, width, height) {
            self.fill(DrawnShape::Box(rect), ink);
        }
    }

    /// Draws a text on its baseline.
    pub fn text(&mut self, text: &str, size: f32, at: Point, align: Align, ink: impl Into<Fill>) {
        self.add(ElementKind::Text {
            text: text.to_owned(),
            size,
            at,
            align,
            ink: ink.into(),
        });
    }

    /// Draws a text with its capital letters centred at a height.
    pub fn label(&mut self, text: &str, size: f32, (x, y): Point, align: Align, ink: impl Into<Fill>) {
        let base = y + self.font.capital(size) / 2.0;
        self.text(text, size, (x, base), align, ink);
    }

    /// Sets the tooltip of the following elements, or none.
    pub fn note(&mut self, note: Option<String>) {
        self.add(ElementKind::Note(note));
    }

    /// The width of a text, units.
    #[must_use]
    pub fn width(&self, text: &str, size: f32) -> f32 {
        self.font.width(text, size)
    }

    /// Shortens a text to the available width, with an ellipsis in place of the missing letters.
    #[must_use]
    pub fn fitted(&self, text: &str, size: f32, width: f32) -> String {
        self.font.fitted(text, size, width)
    }

    fn add(&mut self, what: ElementKind) {
        self.marks.push(Element {
            what,
            clip: self.clip,
        });
    }
}
