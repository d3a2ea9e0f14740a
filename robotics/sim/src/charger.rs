//! Places on the floor where a robot charges.

use crate::geometry::Pose2;

/// A place where the battery of a robot is charged while the middle of the robot is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Charger {
    pub(crate) place: [f64; 2],
    /// Metres.
    pub(crate) radius: f64,
    /// Amperes.
    pub(crate) current: f64,
}

impl Charger {
    pub(crate) fn holds(&self, pose: Pose2) -> bool {
        libm::hypot(pose.x - self.place[0], pose.y - self.place[1]) <= self.radius
    }
}
