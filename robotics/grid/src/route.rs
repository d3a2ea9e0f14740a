//! What a planner returns: a way in columns and rows, or why there is none.

use crate::costmap::Costmap;
use crate::geometry::Cell;
use crate::price::Prices;

/// A point in columns and rows, with fractions: (0.5, 0.5) is the centre of the first cell.
pub type Point = (f64, f64);

/// A way from the start to the goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Its points in columns and rows, both ends included; straight between them.
    pub points: Vec<Point>,
    /// Its price, in cells: its length where no cell has a cost.
    pub price: f64,
}

/// Why there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The start is not in the grid.
    #[error("the robot is outside the map")]
    StartOutside,
    /// The robot touches an obstacle at the start, or the cell is unknown and closed.
    #[error("the robot is in an obstacle of the map")]
    StartClosed,
    /// The goal is not in the grid.
    #[error("the goal is outside the map")]
    GoalOutside,
    /// The robot would touch an obstacle at the goal, or the cell is unknown and closed.
    #[error("the goal is in an obstacle of the map")]
    GoalClosed,
    /// Obstacles separate both.
    #[error("no way leads to the goal")]
    Unreachable,
}

impl Route {
    /// Returns the length in cells.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.points
            .windows(2)
            .map(|pair| libm::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1))
            .sum()
    }

    /// Removes points while the way stays within `tolerance` cells of all removed ones (Douglas and Peucker,
    /// "Algorithms for the reduction of the number of points", 1973). Both ends stay.
    #[must_use]
    pub fn simplified(&self, tolerance: f64) -> Self {
        let points = &self.points;
        let mut kept = vec![false; points.len()];
        let mut spans = Vec::new();
        if let Some(last) = points.len().checked_sub(1) {
            (kept[0], kept[last]) = (true, true);
            spans.push((0, last));
        }
        while let Some((first, last)) = spans.pop() {
            let between = (first + 1..last).map(|at| (at, away(points[at], points[first], points[last])));
            let farthest = between.max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((at, _)) = farthest.filter(|&(_, distance)| distance > tolerance) {
                kept[at] = true;
                spans.extend([(first, at), (at, last)]);
            }
        }
        let kept = points
            .iter()
            .zip(kept)
            .filter_map(|(&point, kept)| kept.then_some(point));
        Self {
            points: kept.collect(),
            price: self.price,
        }
    }
}

/// Checks that a robot may be at both ends.
pub(crate) fn check_ends(costs: &Costmap, prices: &Prices, start: Cell, goal: Cell) -> Result<(), PlanError> {
    let inside = |cell| costs.geometry().contains(cell);
    if !inside(goal) {
        Err(PlanError::GoalOutside)
    } else if prices.at(costs, goal) == 0 {
        Err(PlanError::GoalClosed)
    } else if !inside(start) {
        Err(PlanError::StartOutside)
    } else if prices.at(costs, start) == 0 {
        Err(PlanError::StartClosed)
    } else {
        Ok(())
    }
}

/// Returns the centre of a cell.
pub(crate) fn center(cell: Cell) -> Point {
    (f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5)
}

/// The distance of a point to a segment.
pub(crate) fn away((x, y): Point, (ax, ay): Point, (bx, by): Point) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 {
        (((x - ax) * dx + (y - ay) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(ax + along * dx - x, ay + along * dy - y)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn points_on_a_line_are_removed_and_corners_stay() {
        let points = vec![(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0)];
        let route = Route { points, price: 4.0 };
        assert_eq!(route.length(), 4.0);
        assert_eq!(route.simplified(0.1).points, [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        for points in [vec![], vec![(1.0, 1.0)]] {
            let route = Route { points, price: 0.0 };
            assert_eq!(route.simplified(0.1), route);
            assert_eq!(route.length(), 0.0);
        }
    }

    proptest! {
        #[test]
        fn no_removed_point_is_farther_away_than_the_tolerance(
            points in prop::collection::vec((0.0..50.0f64, 0.0..50.0f64), 2..60),
            tolerance in 0.0..5.0f64,
        ) {
            let route = Route { points, price: 0.0 };
            let short = route.simplified(tolerance);
            for &point in &route.points {
                let nearest = short.points.windows(2).map(|pair| away(point, pair[0], pair[1]));
                prop_assert!(nearest.fold(f64::MAX, f64::min) <= tolerance + 1e-9);
            }
        }
    }
}
