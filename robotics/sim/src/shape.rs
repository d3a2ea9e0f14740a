//! The shapes of the things in a world, for pictures and for the geometry behind the sensors.
//!
//! This module draws nothing.

use crate::color::Color;
use crate::geometry::Pose2;

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
        /// Its full extent along its own x and y.
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
    /// Its place and size.
    pub outline: Outline,
    /// Its colour.
    pub color: Color,
    /// Its height above the floor, in metres.
    pub height: f64,
    /// Whether it may move later: on its own, or when it is pushed.
    pub moving: bool,
    /// Its appearance.
    pub figure: Figure,
}

/// The appearance of a thing on its outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Figure {
    /// The same outline from the floor up to its height.
    Upright,
    /// A ball.
    Ball,
    /// A person who faces `heading`, in the frame of the world.
    Person {
        /// Radians.
        heading: f64,
    },
}

impl Outline {
    /// Returns its middle with the direction of its own x axis, and its full extent along its own x and y.
    /// The x axis of a wall lies along the wall.
    pub fn placed(&self) -> (Pose2, [f64; 2]) {
        match *self {
            Self::Segment { from, to } => {
                let (x, y) = (to[0] - from[0], to[1] - from[1]);
                let middle = Pose2::new(
                    (from[0] + to[0]) / 2.0,
                    (from[1] + to[1]) / 2.0,
                    libm::atan2(y, x),
                );
                (middle, [libm::hypot(x, y), 0.0])
            }
            Self::Box { center, size, angle } => (Pose2::new(center[0], center[1], angle), size),
            Self::Circle { center, radius } => (Pose2::new(center[0], center[1], 0.0), [2.0 * radius; 2]),
        }
    }
}
