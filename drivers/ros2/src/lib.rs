//! ROS 2 over Zenoh, in the key layout of rmw_zenoh, without a ROS 2 installation: topics, services and actions of an application,
//! a ROS 2 robot as a base, transforms, and Nav2's action from both ends. The plugin is built separately, so each driver has its
//! own Zenoh session beside the executable's.
//!
//! Only iterations submit messages, so a schema that hangs falls silent on the network as well.

mod actions;
mod base;
mod camera_info;
mod clock_source;
mod compressed;
mod connection;
mod described;
mod drive;
mod follow;
mod goal;
mod goals;
mod messages;
mod navigate;
mod scan;
mod services;
mod settings;
mod tf;
mod topics;
mod transform;
mod velocity;
mod watchdog;

pub use actions::Actions;
pub use base::Base;
pub use follow::Follow;
pub use goals::Goals;
pub use navigate::Navigate;
pub use services::Services;
pub use topics::Topics;
pub use transform::Transform;
pub use watchdog::Watchdog;

jde_schema::export!(
    "ros2",
    "Connects to ROS 2 over Zenoh.",
    [
        Topics, Services, Actions, Base, Follow, Watchdog, Navigate, Goals, Transform
    ]
);

#[cfg(test)]
mod tests;
