//! Motion in the plane among what a laser sees: the outline of a robot, the points of a scan around it, its
//! motion under limits of acceleration and with a lag, and whether it can stop before it touches a point; where the base
//! was when a sensor saw something; and what of the odometry and of sensors is no motion and no measurement.
//!
//! The crate has no clock, reads no port and decides no behaviour. Points and outlines are in the frame of
//! the base (REP-103), in metres.

mod dynamics;
mod frozen;
mod history;
mod momentum;
mod outline;
mod scan_points;
mod setpoint;
mod stopping;
mod surroundings;
mod travel;

pub use dynamics::{BaseDynamics, DynamicsError};
pub use frozen::Frozen;
pub use history::{OdometryHistory, Sweep, scan_duration};
pub use momentum::{Momentum, Motors};
pub use outline::{FootprintError, Outline};
pub use scan_points::ScanPoints;
pub use setpoint::Setpoint;
pub use stopping::{Maneuver, Stopping};
pub use surroundings::{MAX_POINTS, Surroundings};
pub use travel::{Travel, arc, is_finite, is_jump, jumped};
