//! What stands or moves in a world, as data for pictures and for the geometry behind the sensors.
//!
//! Nothing here draws.

use crate::color::Color;

/// The outline of a thing, in the frame of the world, in metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A wall without thickness.
    Segment {
        /// One end.
        from: [f64; 2],
        /// The other end.
        to: [f64; 2],
    },
    /// A solid rectangle.
    Box {
        /// Its middle.
        center: [f64; 2],
        /// Its whole extent along its own x and y.
        size: [f64; 2],
        /// The angle from the world's x axis to its own.
        angle: f64,
    },
    /// A solid disc.
    Circle {
        /// Its middle.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
    },
}

/// A thing of the world as it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape<'a> {
    /// The name in the world file; the things of a ROS map carry the name of its file.
    pub name: &'a str,
    /// Where it is and how big.
    pub outline: Outline,
    /// Its colour.
    pub color: Color,
    /// How far it reaches up from the floor, in metres.
    pub height: f64,
    /// Whether it may be elsewhere later: it moves on its own, or can be pushed.
    pub moving: bool,
}
