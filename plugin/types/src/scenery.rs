//! The appearance of a simulated world, for external viewers. A robot has no such sensor: a schema that uses
//! these types for control works only in the simulator.

use crate::{Header, Padding, Pose2D, Seq, Text, Value};

/// A static or moving object on the floor of a simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Thing")]
pub struct Thing {
    /// Its name in the world's file, cut if it is long.
    pub name: Text<20>,
    /// Center on the floor, and heading.
    pub pose: Pose2D,
    /// Size along its own x: length of a wall, diameter of a round object.
    #[value(unit = "m")]
    pub length: f32,
    /// Size along its own y; 0 for a wall.
    #[value(unit = "m")]
    pub width: f32,
    /// Height above the floor.
    #[value(unit = "m")]
    pub height: f32,
    /// 0 a wall or a box, 1 a cylinder, 2 a ball, 3 a person, 4 a robot, 5 paint on the floor.
    pub form: u8,
    /// Its color in sRGB.
    pub red: u8,
    /// Its color in sRGB.
    pub green: u8,
    /// Its color in sRGB.
    pub blue: u8,
}

/// The static objects of a simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Scenery")]
pub struct Scenery {
    /// Time, and the frame of the world.
    pub header: Header,
    /// Number of objects that did not fit below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The objects.
    pub things: Seq<Thing, 1024>,
}

/// The moving and movable objects of a simulated world, without the robot that publishes them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Movers")]
pub struct Movers {
    /// Time, and the frame of the world.
    pub header: Header,
    /// Number of objects that did not fit below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The objects.
    pub things: Seq<Thing, 64>,
}

impl Thing {
    /// Form: a wall or a box.
    pub const BOX: u8 = 0;
    /// Form: a cylinder.
    pub const CYLINDER: u8 = 1;
    /// Form: a ball.
    pub const BALL: u8 = 2;
    /// Form: a person, on two legs.
    pub const PERSON: u8 = 3;
    /// Form: a robot.
    pub const ROBOT: u8 = 4;
    /// Form: a rectangle painted on the floor. Its height only tells which of two layers covers the
    /// other.
    pub const PAINT: u8 = 5;
}
