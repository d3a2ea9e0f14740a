//! What was noticed and may not be noticed now: what was touched, an edge, what a sonar heard, and what was seen where no
//! laser looks.

use core::time::Duration;
use std::collections::BTreeMap;

use jde_schema::types::{Point2D, Pose2D};

/// Side of a cell of which one point of each sense is remembered, m.
const CELL: f64 = 0.05;
/// How far from the base it remembers, m. What is farther is noticed again before the robot is there.
const REACH: f64 = 2.0;

/// What a point is known by. Only the sensor that showed it can show that it is gone: another one may look over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Sense {
    /// The laser of this number in the list.
    Light(usize),
    /// A sonar, by the number of its value in the list and its number in the ring.
    Sound(usize, usize),
    /// A bumper or a cliff sensor, which notices it only there.
    Touch,
}

/// A point in the frame of the odometry, when it was noticed and by what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noticed {
    pub(crate) point: Point2D,
    pub(crate) time: Duration,
    pub(crate) sense: Sense,
}

/// Points in the frame of the odometry.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    cells: BTreeMap<(i64, i64, Sense), Noticed>,
}

impl Memory {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.cells.clear();
    }

    /// Adds a point that was noticed.
    pub(crate) fn add(&mut self, noticed: Noticed) {
        let Noticed { point, sense, .. } = noticed;
        let cell = |part: f64| (part / CELL).floor() as i64;
        self.cells.insert((cell(point.x), cell(point.y), sense), noticed);
    }

    /// Forgets what is older than `age`, what is far from the base, and what its sensor shows to be `gone` now.
    pub(crate) fn retain(
        &mut self,
        base: &Pose2D,
        now: Duration,
        age: Duration,
        gone: impl Fn(&Noticed) -> bool,
    ) {
        self.cells.retain(|_, noticed| {
            let point = &noticed.point;
            now.saturating_sub(noticed.time) <= age
                && libm::hypot(point.x - base.x, point.y - base.y) <= REACH
                && !gone(noticed)
        });
    }

    /// Takes what was touched along where the pose of the base jumps from `before` to `now`, because the robot still stands
    /// at it, and forgets the rest.
    pub(crate) fn jump(&mut self, before: &Pose2D, now: &Pose2D) {
        for (_, mut noticed) in core::mem::take(&mut self.cells) {
            if noticed.sense == Sense::Touch {
                let local = before.localize(&Pose2D::new(noticed.point.x, noticed.point.y, 0.0));
                let Pose2D { x, y, .. } = now.transform(&local);
                noticed.point = Point2D { x, y };
                self.add(noticed);
            }
        }
    }

    /// Returns what it remembers.
    pub(crate) fn points(&self) -> impl Iterator<Item = &Point2D> {
        self.cells.values().map(|noticed| &noticed.point)
    }
}
