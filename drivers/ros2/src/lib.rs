//! ROS 2 over Zenoh, in the key layout of rmw_zenoh, without a ROS 2 installation: topics of a robot of ours, and a ROS 2 robot
//! as a base. A plugin is built apart, so each driver has a session of Zenoh of its own beside the executable's.
//!
//! Whatever is sent was handed over by an iteration: a schema that hangs falls silent on the network as well.

mod attachment;
mod base;
mod clock;
mod drive;
mod follow;
mod keys;
mod messages;
mod names;
mod node;
mod scan;
mod session;
mod settings;
mod shared;
mod tf;
mod topics;
mod wire;

pub use base::Base;
pub use follow::Follow;
pub use topics::Topics;

jde_schema::export!("ros2", "Speaks to ROS 2 over Zenoh.", [Topics, Base, Follow]);

#[cfg(test)]
mod tests;
