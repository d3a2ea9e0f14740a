//! Persons that a schema tracks around a robot.

use crate::{Header, Padding, Point2D, Seq, Value};

/// A person.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Person")]
pub struct Person {
    /// The number of the person, from 1, as long as the schema is awake.
    pub id: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The position.
    pub position: Point2D,
    /// The velocity along x and y.
    #[value(unit = "m/s")]
    pub velocity: [f64; 2],
    /// Standard deviation of the position along each axis.
    #[value(unit = "m")]
    pub deviation: f64,
    /// How probable it is that this is a person, 0 to 1.
    pub confidence: f64,
    /// How long the person has not been seen.
    #[value(unit = "s")]
    pub unseen: f64,
}

/// The persons around a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Persons")]
pub struct Persons {
    /// Time of the scan, and the frame of the positions.
    pub header: Header,
    /// The persons.
    pub persons: Seq<Person, 32>,
}
