//! The virtual force field of 2007, in metres. It is a pure formula: it keeps no state and commands no robot.

use jde_schema::types::{LaserScan, Pose2D};

/// The push of a return by its distance: the second number applies below the first (m).
const PUSH: [(f64, f64); 6] = [
    (0.25, 2.0),
    (0.5, 1.5),
    (0.75, 1.2),
    (1.0, 1.0),
    (2.0, 0.5),
    (3.0, 0.2),
];
/// Divisor of the summed pushes of a scan with one beam per degree.
const DIVISOR: f64 = 20.0;

/// The weights of the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FieldWeights {
    /// Weight of the target's pull.
    pub(crate) attraction: f64,
    /// Weight of the obstacles' push.
    pub(crate) repulsion: f64,
    /// Distance beyond which the target's pull no longer grows, m.
    pub(crate) cap: f64,
    /// Factor on the distances of the table.
    pub(crate) reach: f64,
}

/// The two forces, in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Forces {
    /// The target's pull.
    pub(crate) pull: (f64, f64),
    /// The obstacles' push.
    pub(crate) push: (f64, f64),
}

impl Forces {
    /// The sum of both forces.
    pub(crate) fn sum(&self) -> (f64, f64) {
        (self.pull.0 + self.push.0, self.pull.1 + self.push.1)
    }
}

impl FieldWeights {
    /// Returns pull and push in the robot's frame, for a target in that frame.
    pub(crate) fn forces(&self, target: &Pose2D, laser: &LaserScan) -> Forces {
        let distance = libm::hypot(target.x, target.y);
        let pull = if distance > 0.0 {
            self.attraction * distance.min(self.cap) / distance
        } else {
            0.0
        };
        // The push must not depend on the number of beams.
        let beam = f64::from(laser.angle_increment).abs().to_degrees();
        let weight = self.repulsion * beam / DIVISOR;
        let (mut x, mut y) = (0.0, 0.0);
        for point in laser.points() {
            let push = weight * self.push(point.range);
            // Most returns are too far to push, and the sine costs more than all else.
            if push != 0.0 {
                x += push * libm::cos(point.angle);
                y += push * libm::sin(point.angle);
            }
        }
        Forces {
            pull: (pull * target.x, pull * target.y),
            push: (-x, -y),
        }
    }

    fn push(&self, range: f64) -> f64 {
        let step = PUSH.iter().find(|(reach, _)| range < reach * self.reach);
        step.map_or(0.0, |(_, push)| *push)
    }
}
