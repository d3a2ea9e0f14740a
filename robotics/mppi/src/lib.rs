//! Model predictive path integral control of a base in the plane: many sequences of commands are sampled around
//! the last best one, rolled out with the limits of the base, and averaged by their costs (Williams et al.,
//! "Information theoretic MPC for model-based reinforcement learning", ICRA 2017).
//!
//! The crate has no clock, reads no port, starts no thread, and allocates nothing after [`Controller::new`].
//! The same seed and the same arguments give the same commands to the bit. Everything is in one frame of the
//! caller, in metres, radians and seconds, which must be near the robot, since numbers have 32 bits.
//!
//! It proposes a command. Whether the base can stop in time is for the caller to check.

mod base;
mod clearance;
mod controller;
mod critics;
mod guide;
mod smooth;

pub use base::{Base, Disc, Motion};
pub use clearance::Clearance;
pub use controller::{Controller, Shape, Spread};
pub use critics::{Situation, Weights};
pub use guide::Guide;

/// Velocities ahead and to the left, m/s, and the turn rate, rad/s.
pub type Command = [f32; 3];
