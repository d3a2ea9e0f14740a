//! The appearance of a simulated world, for external viewers. A robot has no such sensor: a schema that uses
//! these types for control works only in the simulator.

use crate::{Header, Padding, Pose2D, Seq, Text, Value};

/// Something that stands or moves on the floor of a simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Thing")]
pub struct Thing {
    /// Its name in the world's file, cut if it is long.
    pub name: Text<20>,
    /// Its middle on the floor, and where it faces.
    pub pose: Pose2D,
    /// Its extent along its own x: of a wall its length, of what is round its diameter.
    #[value(unit = "m")]
    pub length: f32,
    /// Its extent along its own y; 0 for a wall.
    #[value(unit = "m")]
    pub width: f32,
    /// How far it reaches up from the floor.
    #[value(unit = "m")]
    pub height: f32,
    /// 0 a wall or a box, 1 a cylinder, 2 a ball, 3 a person, 4 a robot.
    pub form: u8,
    /// Its color in sRGB.
    pub red: u8,
    /// Its color in sRGB.
    pub green: u8,
    /// Its color in sRGB.
    pub blue: u8,
}

/// What stands still in a simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Scenery")]
pub struct Scenery {
    /// When it was so, and the world's frame.
    pub header: Header,
    /// Things that found no room below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The things.
    pub things: Seq<Thing, 1024>,
}

/// What moves in a simulated world, or can be moved, but for the robot that tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Movers")]
pub struct Movers {
    /// When it was so, and the world's frame.
    pub header: Header,
    /// Things that found no room below.
    pub left_out: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The things.
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
}
