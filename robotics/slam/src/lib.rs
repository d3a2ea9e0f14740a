//! Simultaneous localization and mapping in the plane: a map of what a laser sees, and where the robot is on it.
//!
//! A scan is matched with the scans near it: by correlation (Olson, "Real-time correlative scan matching", 2009) with
//! branch and bound (Hess et al., "Real-time loop closure in 2D LIDAR SLAM", 2016), then by lines through its points
//! (Censi, "An ICP variant using a point-to-line metric", 2008). Scans at new places become keyframes, the nodes of a
//! graph whose edges are such matches (Grisetti et al., "A tutorial on graph-based SLAM", 2010). A place that is
//! reached again closes a loop, once several matches there agree; a loop that contradicts all others loses its weight
//! (Agarwal et al., "Robust map optimization using dynamic covariance scaling", 2013).
//!
//! Everything is a function of its arguments: the crate has no clock, no thread and no I/O. A call does a bounded part
//! of the work. Units are metres and radians; axes follow ROS REP-103, frames REP-105.

mod continued;
mod correlation;
mod draw;
mod graph;
mod icp;
mod loops;
mod matrix;
mod scan;
mod slam;
mod sparse;
mod surface;
#[cfg(test)]
mod world;

pub use continued::Continuation;
pub use correlation::{Match, Window};
pub use draw::MapDrawing;
pub use graph::{Edge, Graph, Relation};
pub use icp::{Fit, Guess};
pub use matrix::Matrix;
pub use scan::{Scan, SurfacePoint};
pub use slam::{Anchor, Settings, Slam, State};
pub use surface::Surface;
