//! Fuses the odometry of wheels, a gyro and measured positions by an extended Kalman filter of the plane (Kalman, "A new
//! approach to linear filtering and prediction problems", 1960; Moore and Stouch, "A generalized extended Kalman filter
//! implementation for the Robot Operating System", IAS 2014). Measurements that come late are put in order, and those after
//! them are taken again.
//!
//! Beside the motion the filter estimates the gyro's bias and the constant errors of the wheels (Borenstein and Feng,
//! "Measurement and correction of systematic odometry errors in mobile robots", 1996). An error that stays the same is no
//! noise: were it taken for noise, the covariance would be far too small after some metres.
//!
//! The crate has no clock, reads no port and starts no thread. Units are metres, seconds and radians; axes follow ROS
//! REP-103.

mod filter;
mod matrix;
mod measurement;
mod state;
mod timeline;

pub use filter::{Filter, Outcome};
pub use measurement::{Heading, Measurement, Place, Position, Thresholds, Turn, Wheels};
pub use state::{Initial, ProcessNoise, State};
pub use timeline::{MAX_GAP, MAX_MEASUREMENTS, TimeError, Timeline};
