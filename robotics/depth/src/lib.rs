//! What points in space tell of the floor around a robot: obstacles in a band of heights, edges where the floor ends, and
//! what is free, as a laser scan that is level.
//!
//! Points are in a level frame with its origin on the floor below the sensor: x ahead, y to the left, z up, m. The crate
//! has no clock and corrects no pose.

mod floor;
mod lacks;
mod level;
mod ports;

pub use floor::{FloorScan, Limits, LimitsError};
pub use lacks::Lacks;
pub use level::Level;
pub use ports::FloorPorts;

#[cfg(test)]
mod tests;
