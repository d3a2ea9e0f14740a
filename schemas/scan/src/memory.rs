//! What was noticed and cannot be noticed now: what was touched, an edge, and what was seen where no laser looks.

use core::time::Duration;
use std::collections::BTreeMap;

use jde_schema::types::{Point2D, Pose2D};

/// Side of a cell of which one point is remembered, m.
const CELL: f64 = 0.05;
/// How far from the base it remembers, m. What is farther is seen again before the robot is there.
const REACH: f64 = 2.0;

/// What a point is known by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    /// A laser sees it, and sees whether it is gone.
    Light,
    /// A bumper or a cliff sensor: a laser passes over it.
    Touch,
}

#[derive(Clone, Copy, Debug)]
struct Noticed {
    point: Point2D,
    time: Duration,
    sense: Sense,
}

/// Points in the frame of the odometry.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    cells: BTreeMap<(i64, i64), Noticed>,
}

impl Memory {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.cells.clear();
    }

    /// Adds a point that was noticed at a time. A touch is not replaced by light.
    pub(crate) fn add(&mut self, point: Point2D, time: Duration, sense: Sense) {
        let cell = ((point.x / CELL).floor() as i64, (point.y / CELL).floor() as i64);
        let noticed = Noticed { point, time, sense };
        let kept = self.cells.entry(cell).or_insert(noticed);
        if kept.sense == Sense::Light || sense == Sense::Touch {
            *kept = noticed;
        }
    }

    /// Forgets what is older than `age`, what is far from the base, and what light showed at a place that is `seen`
    /// now.
    pub(crate) fn retain(
        &mut self,
        base: &Pose2D,
        now: Duration,
        age: Duration,
        seen: impl Fn(&Point2D) -> bool,
    ) {
        self.cells.retain(|_, noticed| {
            let point = &noticed.point;
            now.saturating_sub(noticed.time) <= age
                && (point.x - base.x).hypot(point.y - base.y) <= REACH
                && (noticed.sense == Sense::Touch || !seen(point))
        });
    }

    /// Returns what it remembers.
    pub(crate) fn points(&self) -> impl Iterator<Item = &Point2D> {
        self.cells.values().map(|noticed| &noticed.point)
    }
}
