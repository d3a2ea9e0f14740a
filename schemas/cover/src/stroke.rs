//! A stroke that is driven: its points in metres, and how far the robot has come.

use jde_grid::{Geometry, Route as Way, Stroke};
use jde_schema::prelude::*;

/// By how much the path may leave the centres of the cells, in cells.
const TOLERANCE: f64 = 0.5;
/// The longest stroke, in cells, so that a path has room for its points.
const MAX_CELLS: usize = 400;
/// Least decrease of the distance to the next point that counts as nearer, m.
const MIN_PROGRESS: f64 = 0.05;

/// How long a robot stands at the end before the rest counts as skipped.
const SKIP_TIME: Duration = Duration::from_secs(3);

/// A stroke under way.
pub(crate) struct Driven {
    /// The way to the stroke and along it.
    points: Vec<(f64, f64)>,
    /// How many points lead to the stroke.
    to: usize,
    /// The centres of its cells.
    cells: Vec<(f64, f64)>,
    /// The next point.
    next: usize,
    /// Whether the robot was away from the end after it reached the stroke: a contour ends where it begins.
    was_away: bool,
    /// The least distance to it so far, m, since when, and where the robot was.
    nearest: (f64, Duration, Pose2D),
}

impl Driven {
    pub(crate) fn new(mut stroke: Stroke, geometry: &Geometry, now: Duration) -> Self {
        stroke.cells.truncate(MAX_CELLS);
        let cells: Vec<(f64, f64)> = stroke.cells.iter().map(|&cell| geometry.center(cell)).collect();
        let along = |points: Vec<(f64, f64)>| Way { points, price: 0.0 }.simplified(TOLERANCE).points;
        let to = along(stroke.way);
        let centers = stroke
            .cells
            .iter()
            .map(|cell| (f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5));
        let count = to.len();
        let points = to.into_iter().chain(along(centers.collect()));
        Self {
            points: points.map(|point| geometry.to_world(point)).collect(),
            to: count,
            cells,
            next: 0,
            was_away: false,
            nearest: (f64::INFINITY, now, Pose2D::ORIGIN),
        }
    }

    /// Takes the robot's place. A robot that has left the end and stands there again has skipped what was before: it was driven
    /// along in part, or the path comes back along itself.
    pub(crate) fn advance(&mut self, robot: &Pose2D, tolerance: f64, now: Duration) {
        while let Some(&(x, y)) = self.points.get(self.next) {
            let distance = libm::hypot(x - robot.x, y - robot.y);
            if distance > tolerance {
                if distance < self.nearest.0 - MIN_PROGRESS {
                    self.nearest = (distance, now, *robot);
                }
                let is_there = robot.distance_to(&self.end()) <= tolerance;
                self.was_away |= self.next > self.to && !is_there;
                if is_there && self.was_away && now.saturating_sub(self.nearest.1) >= SKIP_TIME {
                    self.next = self.points.len();
                }
                return;
            }
            self.next += 1;
            self.nearest = (f64::INFINITY, now, *robot);
        }
    }

    /// The place `ahead` of where the robot came nearest to the next point, if it has come no nearer for `patience`.
    pub(crate) fn stuck(&self, now: Duration, patience: Duration, ahead: f64) -> Option<(f64, f64)> {
        let &(x, y) = self.points.get(self.next)?;
        let (_, since, from) = self.nearest;
        let direction = from.bearing_to(&Pose2D::new(x, y, 0.0)) + from.theta;
        let place = (
            from.x + ahead * libm::cos(direction),
            from.y + ahead * libm::sin(direction),
        );
        (now.saturating_sub(since) >= patience).then_some(place)
    }

    pub(crate) const fn is_at_end(&self) -> bool {
        self.next >= self.points.len()
    }

    /// The centres of its cells, m.
    pub(crate) fn cells(&self) -> &[(f64, f64)] {
        &self.cells
    }

    /// The points of the path that are not reached, m.
    pub(crate) fn ahead(&self) -> &[(f64, f64)] {
        &self.points[self.next..]
    }

    /// The points of the path, m.
    pub(crate) fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    pub(crate) fn end(&self) -> Pose2D {
        self.points
            .last()
            .map_or(Pose2D::ORIGIN, |&(x, y)| Pose2D::new(x, y, 0.0))
    }

    /// The points of the path that is driven now: to the stroke, or along it. They are apart, since the one may lead back along
    /// the other.
    pub(crate) fn path(&self) -> &[(f64, f64)] {
        if self.next < self.to {
            &self.points[..self.to]
        } else {
            &self.points[self.to..]
        }
    }
}
