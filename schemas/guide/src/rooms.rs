//! Rooms as values of application files.

use jde_schema::prelude::*;

/// A room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Room")]
pub struct Room {
    /// What people call it.
    pub name: Text<28>,
    /// Where the robot waits in it, in the frame of the map.
    pub place: Pose2D,
}

/// The rooms of a building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Rooms")]
pub struct Rooms {
    /// The rooms.
    pub rooms: Seq<Room, 32>,
}

impl Rooms {
    /// Returns the room of a name.
    pub(crate) fn find(&self, name: &str) -> Option<Room> {
        self.rooms.iter().find(|room| room.name.as_str() == name).copied()
    }

    /// Returns the names, for a person.
    pub(crate) fn names(&self) -> String {
        let names = self.rooms.iter().map(|room| format!("`{}`", room.name.as_str()));
        names.collect::<Vec<_>>().join(", ")
    }

    /// Returns a route through all rooms.
    pub(crate) fn route(&self) -> Route {
        Route {
            poses: self.rooms.iter().map(|room| room.place).collect(),
        }
    }
}
