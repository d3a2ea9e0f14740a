//! Motion in the plane among what a laser sees: the outline of a robot, the points of a scan around it, its
//! motion under limits of acceleration, and whether it can stop before it touches a point; and what of the odometry and
//! of sensors is no motion and no measurement.
//!
//! The crate has no clock, reads no port and decides no behaviour. Points and outlines are in the frame of
//! the base (REP-103), in metres.

mod frozen;
mod outline;
mod scan_points;
mod stopping;
mod surroundings;
mod travel;

pub use frozen::Frozen;
pub use outline::{FootprintError, Outline};
pub use scan_points::ScanPoints;
pub use stopping::{Maneuver, Stopping};
pub use surroundings::{MAX_POINTS, Surroundings};
pub use travel::{Limits, Travel, arc, check_time, is_finite, is_jump, jumped};
