//! Where the mark is, from all that was seen of it. Near sightings count more than far ones, and new ones more than old
//! ones, since the odometry drifts.

use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

/// The weight that is left of a sighting after the next one.
const KEPT_WEIGHT: f64 = 0.97;
/// The least weight of a direction that is ambiguous: straight before a mark, all are.
const AMBIGUOUS_WEIGHT: f64 = 0.02;

/// The place of the mark in the frame of the odometry.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sighting {
    place: [Mean; 2],
    /// The direction in which the mark faces, relative to the first sighting.
    facing: Mean,
    first: f64,
    last: Option<Duration>,
}

/// A mean that forgets.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    value: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        self.weight = KEPT_WEIGHT * self.weight + weight;
        self.value += weight / self.weight * (value - self.value);
    }
}

impl Sighting {
    /// Adds that a base at a pose saw the mark: its place and the direction in which it faces, in the frame of the base.
    /// What is not finite is left out.
    pub(crate) fn add(&mut self, base: &Pose2D, seen: &Pose2D, ambiguity: f64, time: Duration) {
        let range = libm::hypot(seen.x, seen.y);
        let mark = base.transform(seen);
        // The error of a range grows with the square of the range, and so does that of a direction.
        let variance = range.max(0.1).powi(4);
        if !mark.is_finite() || !variance.is_finite() {
            return;
        }
        let weight = 1.0 / variance;
        self.place[0].add(mark.x, weight);
        self.place[1].add(mark.y, weight);
        if self.last.is_none() {
            self.first = mark.theta;
        }
        let clear = (1.0 - ambiguity).max(AMBIGUOUS_WEIGHT);
        self.facing
            .add(normalize_angle(mark.theta - self.first), weight * clear);
        self.last = Some(time);
    }

    /// Returns whether the mark was seen, however long ago.
    pub(crate) fn is_known(&self) -> bool {
        self.last.is_some()
    }

    /// Returns the place of the mark and the direction in which it faces; `None` before it was seen, and when that is
    /// longer ago than `patience`.
    pub(crate) fn place(&self, now: Duration, patience: Duration) -> Option<Pose2D> {
        let known = now.saturating_sub(self.last?) <= patience;
        let facing = normalize_angle(self.first + self.facing.value);
        known.then(|| Pose2D::new(self.place[0].value, self.place[1].value, facing))
    }
}
