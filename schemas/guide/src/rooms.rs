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

    /// # Errors
    /// A room without a name, or two rooms of one name.
    pub(crate) fn check(&self) -> Result<(), String> {
        for (index, room) in self.rooms.iter().enumerate() {
            let name = room.name.as_str();
            if name.is_empty() {
                return Err(format!("room {} has no name: give it one", index + 1));
            }
            if self.rooms[..index].iter().any(|other| other.name == room.name) {
                return Err(format!("two rooms are called `{name}`: rename one"));
            }
        }
        Ok(())
    }

    /// Returns a route through all rooms.
    pub(crate) fn route(&self) -> Route {
        Route {
            poses: self.rooms.iter().map(|room| room.place).collect(),
        }
    }
}
