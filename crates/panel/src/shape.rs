//! What is drawn on a canvas, in metres and radians.

use serde::{Deserialize, Serialize};

/// A shape of a canvas. All coordinates are finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Through points in turn.
    Line {
        /// Less than two show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// From the last back to the first.
        closed: bool,
        /// How.
        stroke: Stroke,
    },
    /// Each by itself.
    Points {
        /// Where.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// Color, and diameter in points of the screen.
        stroke: Stroke,
    },
    /// A circle.
    Circle {
        /// Its middle.
        center: [f64; 2],
        /// Its radius, m; not negative.
        radius: f64,
        /// Filled.
        filled: bool,
        /// How.
        stroke: Stroke,
    },
    /// What is between corners, filled; convex.
    Polygon {
        /// Less than three show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 2]>,
        /// Of what.
        color: Color,
    },
    /// A line with a head.
    Arrow {
        /// From.
        from: [f64; 2],
        /// To, where the head is.
        to: [f64; 2],
        /// How.
        stroke: Stroke,
    },
    /// A text of constant size on the screen.
    Label {
        /// Where its left lower corner is.
        at: [f64; 2],
        /// What it says.
        text: String,
        /// In what.
        color: Color,
    },
    /// The outline of the robot that the application drives, as the viewer draws it.
    Robot {
        /// x, y and heading.
        pose: [f64; 3],
    },
}

/// What part of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Area {
    /// Least x and y, m.
    pub least: [f64; 2],
    /// Greatest x and y, m; each above the least.
    pub greatest: [f64; 2],
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stroke {
    /// Its color.
    pub color: Color,
    /// Its width in points of the screen, whatever the zoom; positive.
    pub width: f32,
}

/// A color: one that fits the viewer's theme, or an exact one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Color {
    /// Readable in light and in dark.
    Ink(Ink),
    /// Red, green, blue, and how opaque.
    Exact([u8; 4]),
}

/// Colors by their meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ink {
    /// As text.
    #[default]
    Plain,
    /// Less than the rest.
    Faint,
    /// What this is about.
    Accent,
    /// All is well; free.
    Good,
    /// Something is off; near.
    Warn,
    /// Something failed; in the way.
    Bad,
    /// What attracts: targets.
    Goal,
    /// What was measured.
    Seen,
}

/// What people do that a panel wants to hear of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wants {
    /// Clicks.
    pub clicks: bool,
    /// Drags; without it a drag moves the view.
    pub drags: bool,
    /// Keys, while it has the focus.
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
