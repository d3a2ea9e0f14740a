//! The transforms between a robot's frames: those that a jde robot publishes, and the tree that others publish.

mod history;
mod listener;
mod messages;
mod tree;

pub(crate) use listener::{Listener, to_nanos, to_stamp};
pub(crate) use messages::{Placed, Transforms, message, range_messages};
pub(crate) use tree::{LookupError, Published, Tree};

#[cfg(test)]
mod tests;
