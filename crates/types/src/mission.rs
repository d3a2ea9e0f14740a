//! The progress of an application, and facts that only a simulator knows.

use crate::{Padding, Pose2D, Text, Twist, Value};

/// What an application has been asked to do, and how far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Mission")]
pub struct Mission {
    /// 0 running, 1 done, 2 failed.
    pub state: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Targets reached.
    pub reached: u32,
    /// Targets in all.
    pub total: u32,
    /// Why it failed, or what it is about.
    pub note: Text<64>,
    /// The present target, in the frame of the odometry.
    pub target: Pose2D,
    /// How far it is.
    #[value(unit = "m")]
    pub distance: f64,
}

/// What is true of a simulated robot, whatever its sensors say; for measuring, not for steering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Truth")]
pub struct Truth {
    /// Where it is in the world.
    pub pose: Pose2D,
    /// How it moves, in its own frame.
    pub twist: Twist,
    /// From its edge to the nearest solid thing.
    #[value(unit = "m")]
    pub clearance: f64,
    /// The least that clearance has been.
    #[value(unit = "m")]
    pub min_clearance: f64,
    /// Contacts with solid things, each counted once.
    pub collisions: u64,
}

impl Mission {
    /// State: it is under way.
    pub const RUNNING: u8 = 0;
    /// State: all targets are reached.
    pub const DONE: u8 = 1;
    /// State: it cannot be done; the note gives the reason.
    pub const FAILED: u8 = 2;
}
