//! Policies: networks that decide by what a robot senses. A text file states which numbers go into a network, in which
//! order and how they are scaled, and what its outputs command; training and driving read the same file by this code.
//!
//! The crate reads files and values, and runs a network. It reads no port, commands nothing, and judges no command. The same
//! values give the same decision to the bit.

mod choices;
mod chunk;
mod doubt;
mod file;
mod numbers;
mod observe;
mod output;
mod pixels;
mod policy;
mod read;
mod runner;
mod scale;
mod sources;

pub use chunk::ChunkRule;
pub use file::{Axis, COMMAND_AXES};
pub use numbers::{Numbers, collect};
pub use observe::{Observer, Values};
pub use policy::Policy;
pub use runner::{Decision, Runner};

#[cfg(test)]
mod tests;
