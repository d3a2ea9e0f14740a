//! Applications inside another program, which stays in charge: it loads and starts them, lets time pass, and reads,
//! writes and operates by name. The C API and the package for Python are two faces of this crate.
//!
//! It prints nothing, handles no signal and never ends the process. All functions may be called from any thread, and
//! nothing of the caller runs on a thread of the robot.

mod application;
mod error;
mod lease;
mod names;
mod observation;
mod operations;
mod run;
mod state;
#[cfg(test)]
mod tests;

pub use application::{LoadedApplication, StartOptions};
pub use error::Error;
pub use names::{LivePort, split_name};
pub use run::{FOREVER, Run, Stop};
