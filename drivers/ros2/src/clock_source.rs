//! The clock of the stamps in ROS 2.

use jde_schema::prelude::*;

/// The topic of the time of a simulation, for all nodes of a domain.
pub(crate) const TOPIC: &str = "/clock";

/// The clock of the stamps, for a driver that follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(crate) enum FollowedClock {
    /// That of the machine.
    Wall,
    /// That of `/clock`.
    Follow,
}

/// The clock of the stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(crate) enum ClockSource {
    /// That of the machine.
    Wall,
    /// That of `/clock`.
    Follow,
    /// That of the application, which is published on `/clock`.
    Publish,
}

/// The time of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "rosgraph_msgs/msg/Clock")]
pub(crate) struct ClockMessage {
    pub(crate) clock: Time,
}

impl From<FollowedClock> for ClockSource {
    fn from(clock: FollowedClock) -> Self {
        match clock {
            FollowedClock::Wall => Self::Wall,
            FollowedClock::Follow => Self::Follow,
        }
    }
}
