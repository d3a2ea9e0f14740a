//! The sensors of the robots, each sampled when it is read.
//!
//! Reading changes nothing: the same sensor at the same time gives the same values, noise included.

mod bumper;
mod delivery;
mod depth;
mod imu;
mod laser;
mod line;
mod position;
mod sonar;

pub use bumper::{BUMPER_HEADINGS, Bumpers};
pub use delivery::Delivery;
pub use depth::DepthConfig;
pub use imu::{ImuConfig, ImuReading};
pub use laser::{LaserConfig, LaserTurn, NoReturn};
pub use line::LineSensorConfig;
pub use position::PositionConfig;
pub use sonar::SonarConfig;

pub(crate) use bumper::from_contacts;

/// Returns the reading of a range finder for a true distance and an error, after ROS REP-117: plus infinity
/// for nothing within its range, minus infinity for something too near to measure.
fn reading(distance: Option<f64>, error: f64, min: f64, max: f64) -> f32 {
    match distance.map(|distance| distance + error) {
        Some(range) if range < min => f32::NEG_INFINITY,
        Some(range) if range <= max => range as f32,
        Some(_) | None => f32::INFINITY,
    }
}
