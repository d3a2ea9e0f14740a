//! The shapes of a scene: x ahead, y left, z up (REP-103), in metres and radians.

use serde::{Deserialize, Serialize};

use crate::Color;

/// A shape in space. All coordinates are finite, and no size is negative.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solid {
    /// A line through points, in order.
    Line {
        /// The points. Fewer than two show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 3]>,
        /// Its color.
        color: Color,
        /// Its width in points of the screen.
        width: f32,
    },
    /// Separate points.
    Points {
        /// The positions.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 3]>,
        /// Their color.
        color: Color,
        /// Diameter in points of the screen.
        width: f32,
    },
    /// A box.
    Box {
        /// Its center and orientation.
        place: Place,
        /// Sizes along x, y and z, m.
        size: [f64; 3],
        /// Its color.
        color: Color,
    },
    /// A sphere.
    Sphere {
        /// Its center.
        center: [f64; 3],
        /// Its radius, m.
        radius: f64,
        /// Its color.
        color: Color,
    },
    /// A cylinder along its z.
    Cylinder {
        /// Its center and orientation.
        place: Place,
        /// Its radius, m.
        radius: f64,
        /// Its height, m.
        height: f64,
        /// Its color.
        color: Color,
    },
    /// A line with an arrowhead.
    Arrow {
        /// The start.
        from: [f64; 3],
        /// The end, with the arrowhead.
        to: [f64; 3],
        /// Its color.
        color: Color,
    },
    /// Triangles.
    Mesh {
        /// Their corners, three per triangle, counter-clockwise as seen from outside.
        #[serde(deserialize_with = "crate::bytes::points")]
        corners: Vec<[f64; 3]>,
        /// Its color.
        color: Color,
    },
    /// A text that always faces the viewer.
    Label {
        /// The position.
        at: [f64; 3],
        /// The text.
        text: String,
        /// Its color.
        color: Color,
    },
}

/// The position and orientation of a solid. It is rotated about z (yaw), then y (pitch), then x (roll).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Its center, m.
    pub at: [f64; 3],
    /// Roll, pitch and yaw, rad.
    pub turned: [f64; 3],
}
