//! Shapes that can be filled and stroked. Knows no colour.

use tiny_skia::{Path, PathBuilder, Rect};

/// Units to the right and down.
pub type Point = (f32, f32);

/// A shape.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawnShape {
    /// A line through points.
    Line(Vec<Point>),
    /// An area between points.
    Area(Vec<Point>),
    /// A disc: its centre and radius.
    Disc(Point, f32),
    /// An upright rectangle.
    Box(Rect),
}

impl DrawnShape {
    /// A rectangle; none if it has no size.
    #[must_use]
    pub fn bar(x: f32, y: f32, width: f32, height: f32) -> Option<Self> {
        Rect::from_xywh(x, y, width, height).map(Self::Box)
    }

    /// The shape as a path; none if it has no extent.
    pub(crate) fn path(&self) -> Option<Path> {
        match self {
            Self::Line(points) => path_through(points, false),
            Self::Area(points) => path_through(points, true),
            Self::Disc((x, y), radius) => PathBuilder::from_circle(*x, *y, *radius),
            Self::Box(rect) => Some(PathBuilder::from_rect(*rect)),
        }
    }
}

fn path_through(points: &[Point], closed: bool) -> Option<Path> {
    let [(x, y), rest @ ..] = points else { return None };
    let mut path = PathBuilder::new();
    path.move_to(*x, *y);
    for (x, y) in rest {
        path.line_to(*x, *y);
    }
    if closed {
        path.close();
    }
    path.finish()
}
