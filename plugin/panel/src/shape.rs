//! The shapes of a canvas, in metres and radians.

use serde::{Deserialize, Serialize};

/// A shape of a canvas. All coordinates are finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A line through points, in order.
    Line {
        /// The points. Fewer than two show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// Whether the last point is connected to the first.
        closed: bool,
        /// Its color and width.
        stroke: Stroke,
    },
    /// Separate points.
    Points {
        /// The positions.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// Color, and diameter in points of the screen.
        stroke: Stroke,
    },
    /// A circle.
    Circle {
        /// Its center.
        center: [f64; 2],
        /// Its radius, m; not negative.
        radius: f64,
        /// Whether it is filled.
        filled: bool,
        /// Its color and width.
        stroke: Stroke,
    },
    /// A filled convex polygon.
    Polygon {
        /// Its corners. Fewer than three show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// Its color.
        color: Color,
    },
    /// A line with an arrowhead.
    Arrow {
        /// The start.
        from: [f64; 2],
        /// The end, with the arrowhead.
        to: [f64; 2],
        /// Its color and width.
        stroke: Stroke,
    },
    /// A text of constant size on the screen.
    Label {
        /// The position of its lower left corner.
        at: [f64; 2],
        /// The text.
        text: String,
        /// Its color.
        color: Color,
    },
    /// The outline of the robot that the application drives, as the viewer draws it.
    Robot {
        /// x and y in metres, heading in radians.
        pose: [f64; 3],
    },
}

/// A rectangle of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Area {
    /// Least x and y, m.
    pub least: [f64; 2],
    /// Greatest x and y, m; each above the least.
    pub greatest: [f64; 2],
}

/// The color and width of a line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stroke {
    /// Its color.
    pub color: Color,
    /// Its width in points of the screen, independent of the zoom; positive.
    pub width: f32,
}

/// A color: one that fits the viewer's theme, or an exact one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Color {
    /// A color of the theme, readable on light and on dark backgrounds.
    Ink(Ink),
    /// Red, green, blue and opacity.
    Exact([u8; 4]),
}

/// Colors by their meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ink {
    /// The color of text.
    #[default]
    Plain,
    /// Less prominent than the rest.
    Faint,
    /// The main subject.
    Accent,
    /// All is well; free.
    Good,
    /// A warning; near.
    Warn,
    /// Something failed; an obstacle.
    Bad,
    /// Targets, which attract.
    Goal,
    /// Measurements.
    Seen,
}

/// The gestures that a widget accepts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wants {
    /// Clicks.
    pub clicks: bool,
    /// Drags; otherwise a drag moves the view.
    pub drags: bool,
    /// Keys, while the widget has the focus.
    pub keys: bool,
}

impl From<Ink> for Color {
    fn from(ink: Ink) -> Self {
        Self::Ink(ink)
    }
}

impl Default for Stroke {
    fn default() -> Self {
        Self {
            color: Ink::Plain.into(),
            width: 1.5,
        }
    }
}
