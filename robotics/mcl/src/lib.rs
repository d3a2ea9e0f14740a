//! Adaptive Monte Carlo localization in the plane: where a robot is on a map, by its odometry and its laser (Fox,
//! "KLD-sampling: adaptive particle filters", NIPS 2001; Thrun, Burgard, Fox, "Probabilistic Robotics", 2005).
//!
//! The crate has no clock, reads no port and starts no thread. After [`Localizer::new`] it allocates nothing. The
//! same seed and the same calls give the same particles to the bit. Poses are in metres and radians; axes follow
//! ROS REP-103.

mod beams;
mod bins;
mod field;
mod localizer;
mod motion;
mod particles;
mod random;
mod search;
mod sensor;

pub use beams::{Beams, Blind};
pub use bins::bound;
pub use field::Field;
pub use localizer::{Doubt, Limits, Localizer, Settings, State};
pub use motion::MotionNoise;
pub use particles::Estimate;
pub use sensor::{Model, Sensor};
