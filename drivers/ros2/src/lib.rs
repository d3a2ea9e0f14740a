//! ROS 2 over Zenoh, in the key layout of rmw_zenoh, without a ROS 2 installation: the topics of a jde robot,
//! and a ROS 2 robot as a base. The plugin is built separately, so each driver has its own Zenoh session
//! beside the executable's.
//!
//! Only iterations submit messages, so a schema that hangs falls silent on the network as well.

mod base;
mod connection;
mod drive;
mod follow;
mod messages;
mod scan;
mod settings;
mod tf;
mod topics;
mod velocity;

pub use base::Base;
pub use follow::Follow;
pub use topics::Topics;

jde_schema::export!("ros2", "Connects to ROS 2 over Zenoh.", [Topics, Base, Follow]);

#[cfg(test)]
mod tests;
