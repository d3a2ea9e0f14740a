//! What is drawn in a scene: x ahead, y left, z up (REP-103), metres and radians.

use serde::{Deserialize, Serialize};

use crate::Color;

/// A shape in space. All coordinates are finite, no size negative.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solid {
    /// Through points in turn.
    Line {
        /// Less than two show nothing.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 3]>,
        /// Its color.
        color: Color,
        /// Its width in points of the screen.
        width: f32,
    },
    /// Each by itself.
    Points {
        /// Where.
        #[serde(deserialize_with = "crate::bytes::points")]
        points: Vec<[f64; 3]>,
        /// Their color.
        color: Color,
        /// Diameter in points of the screen.
        width: f32,
    },
    /// A box.
    Box {
        /// Its middle.
        place: Place,
        /// Along x, y and z, m.
        size: [f64; 3],
        /// Its color.
        color: Color,
    },
    /// A sphere.
    Sphere {
        /// Its middle.
        center: [f64; 3],
        /// m.
        radius: f64,
        /// Its color.
        color: Color,
    },
    /// A cylinder along its z.
    Cylinder {
        /// Its middle.
        place: Place,
        /// m.
        radius: f64,
        /// m.
        height: f64,
        /// Its color.
        color: Color,
    },
    /// A line with a head.
    Arrow {
        /// From.
        from: [f64; 3],
        /// To, where the head is.
        to: [f64; 3],
        /// Its color.
        color: Color,
    },
    /// Corners of triangles, three by three, counter-clockwise from outside.
    Mesh {
        /// A multiple of three.
        #[serde(deserialize_with = "crate::bytes::points")]
        corners: Vec<[f64; 3]>,
        /// Its color.
        color: Color,
    },
    /// A text that faces whoever looks.
    Label {
        /// Where.
        at: [f64; 3],
        /// What it says.
        text: String,
        /// In what.
        color: Color,
    },
}

/// Where a solid is and how it is turned: about z (yaw), then y (pitch), then x (roll).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Its middle, m.
    pub at: [f64; 3],
    /// Roll, pitch and yaw, rad.
    pub turned: [f64; 3],
}
