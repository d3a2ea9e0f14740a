//! The virtual force field of 2007, in metres: a formula, without memory and without a robot.

use jde_schema::types::{LaserScan, Pose2D};

/// How hard a return pushes, by its distance: up to the first number (m) as hard as the second.
const PUSH: [(f64, f64); 6] = [
    (0.25, 2.0),
    (0.5, 1.5),
    (0.75, 1.2),
    (1.0, 1.0),
    (2.0, 0.5),
    (3.0, 0.2),
];
/// The sum of the pushes of a scan with a beam each degree is divided by this.
const DIVISOR: f64 = 20.0;

/// The weights of the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    /// Weight of the pull.
    pub(crate) attraction: f64,
    /// Weight of the push.
    pub(crate) repulsion: f64,
    /// Distance beyond which the target pulls no harder, m.
    pub(crate) cap: f64,
    /// Stretches the distances of the table.
    pub(crate) reach: f64,
}

/// What pulls and what pushes, in the robot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Forces {
    /// The target's pull.
    pub(crate) pull: (f64, f64),
    /// The obstacles' push.
    pub(crate) push: (f64, f64),
}

impl Forces {
    /// Both together.
    pub(crate) fn sum(&self) -> (f64, f64) {
        (self.pull.0 + self.push.0, self.pull.1 + self.push.1)
    }
}

impl Field {
    /// Pull and push in the robot's frame, for a target in that frame.
    pub(crate) fn forces(&self, target: &Pose2D, laser: &LaserScan) -> Forces {
        let distance = target.x.hypot(target.y);
        let pull = if distance > 0.0 {
            self.attraction * distance.min(self.cap) / distance
        } else {
            0.0
        };
        // Twice as many beams must not push twice as hard.
        let beam = f64::from(laser.angle_increment).abs().to_degrees();
        let weight = self.repulsion * beam / DIVISOR;
        let (x, y) = laser.points().fold((0.0, 0.0), |(x, y), point| {
            let push = weight * self.push(point.range);
            (x + push * point.angle.cos(), y + push * point.angle.sin())
        });
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
