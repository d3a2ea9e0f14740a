//! The progress of an application, and facts that only a simulator knows.

use crate::{Padding, Pose2D, Text, Twist, Value};

/// An application's task and its progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Mission")]
pub struct Mission {
    /// 0 running, 1 done, 2 failed.
    pub state: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Number of targets reached.
    pub reached: u32,
    /// Number of targets in total.
    pub total: u32,
    /// Reason of a failure, or a description of the task.
    pub note: Text<64>,
    /// The present target, in the frame of the odometry.
    pub target: Pose2D,
    /// Distance to the present target.
    #[value(unit = "m")]
    pub distance: f64,
}

/// True state of a simulated robot, independent of its sensors; for measurement, not for control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Truth")]
pub struct Truth {
    /// Pose in the world.
    pub pose: Pose2D,
    /// Velocity, in its own frame.
    pub twist: Twist,
    /// Distance from its edge to the nearest solid object.
    #[value(unit = "m")]
    pub clearance: f64,
    /// Least clearance so far.
    #[value(unit = "m")]
    pub min_clearance: f64,
    /// Contacts with solid objects, each counted once.
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
