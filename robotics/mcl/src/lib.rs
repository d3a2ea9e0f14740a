//! Adaptive Monte Carlo localization in the plane: where a robot is on a map, by its odometry and its laser (Fox,
//! "KLD-sampling: adaptive particle filters", NIPS 2001; Thrun, Burgard, Fox, "Probabilistic Robotics", 2005).
//!
//! The crate has no clock, reads no port and starts no thread. After [`Localizer::new`] it allocates nothing. The
//! same seed and the same calls give the same particles to the bit. Poses are in metres and radians; axes follow
//! ROS REP-103.

mod beams;
mod bins;
mod field;
mod fit;
mod localizer;
mod motion;
mod particles;
mod places;
mod random;
mod search;
mod sensor;
mod settings;
mod state;

#[cfg(test)]
mod tests;

pub use beams::{Beams, Blind};
pub use bins::bound;
pub use field::LikelihoodField;
pub use localizer::Localizer;
pub use motion::MotionNoise;
pub use particles::Estimate;
pub use sensor::{Model, Sensor};
pub use settings::{Limits, Settings};
pub use state::{Doubt, State};
