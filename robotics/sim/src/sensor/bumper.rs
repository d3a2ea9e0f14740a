//! Bumper rings: the segments of the body that touch something.
//!
//! The sides, where the wheels are, have none.

use crate::geometry::{Pose2, wrap_angle};

/// The middles of the front segments in degrees, from left to right. The rear segments are the same, turned
/// by half a turn. A segment extends half way to its neighbours; the outer ones extend as far to their other
/// side.
pub const BUMPER_HEADINGS: [f64; 5] = [52.0, 19.0, 0.0, -19.0, -52.0];

/// The pressed bumpers, clockwise as seen from above: the numbering of the Pioneer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bumpers {
    /// At the front, from left to right.
    pub front: [bool; 5],
    /// At the rear, from the robot's right to its left.
    pub rear: [bool; 5],
}

impl Bumpers {
    /// Returns whether any is pressed.
    pub fn any(&self) -> bool {
        self.front.iter().chain(&self.rear).any(|&pressed| pressed)
    }
}

/// Returns the bumpers of a body at `pose` that face the points of contact.
pub(crate) fn from_contacts(pose: Pose2, touched: impl Iterator<Item = [f64; 2]>) -> Bumpers {
    let mut bumpers = Bumpers::default();
    for point in touched {
        let heading = libm::atan2(point[1] - pose.y, point[0] - pose.x) - pose.heading;
        let ahead = wrap_angle(heading).to_degrees();
        let behind = wrap_angle(heading + std::f64::consts::PI).to_degrees();
        if let Some(segment) = segment(ahead) {
            bumpers.front[segment] = true;
        }
        if let Some(segment) = segment(behind) {
            bumpers.rear[segment] = true;
        }
    }
    bumpers
}

fn segment(degrees: f64) -> Option<usize> {
    // Half way between neighbours; each outermost edge mirrors the inner edge of its segment.
    const EDGES: [f64; 6] = [68.5, 35.5, 9.5, -9.5, -35.5, -68.5];
    (0..5).find(|&index| degrees <= EDGES[index] && degrees > EDGES[index + 1])
}
