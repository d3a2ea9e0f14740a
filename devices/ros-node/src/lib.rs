//! A ROS 2 node over Zenoh, in the key layout of rmw_zenoh, without a ROS 2 installation: its names and keys, its
//! session, the clocks of both sides, and the messages, services and actions of ROS 2. It knows no schema and no application.

#![deny(missing_docs)]

mod action;
mod announcements;
mod attachment;
mod clock;
mod declare;
mod error;
pub mod hash;
pub mod interface;
mod keys;
mod latched;
pub mod names;
mod node;
mod outbox;
mod own;
mod publishers;
mod remaps;
mod requests;
mod send_queue;
mod services;
mod session;
mod settings;
mod shared;
mod sources;

pub use action::{Action, ActionClient, ActionServer, GoalEvent, GoalId, GoalStatus, ServerEvent};
pub use clock::{Clock, Measured};
pub use keys::{Announced, Direction, Middleware, NodeName, Quality, Service, Topic};
pub use node::{Arrival, Node, NodeConfig, NodeState, ReceivedMessage};
pub use remaps::Remaps;
pub use services::{Client, Request, Response};
pub use settings::{Settings, environment_connection, environment_domain, environment_middleware};

#[cfg(test)]
mod tests;
