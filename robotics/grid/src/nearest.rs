//! The open cell next to a closed one: where a robot that is too close to an obstacle can go, and which cell near a
//! goal can be reached.

use std::collections::VecDeque;

use crate::costmap::{Costmap, INSCRIBED};
use crate::geometry::{Cell, SIDES};
use crate::price::Prices;

/// Returns the open cell nearest to `from`, if there is one within `reach` cells; `from` itself if it is open.
///
/// From `from` to it leads a way on which the robot's centre is in no obstacle, although the robot may touch
/// some.
#[must_use]
pub fn nearest_open(costs: &Costmap, prices: &Prices, from: Cell, reach: f64) -> Option<Cell> {
    let geometry = costs.geometry();
    if !geometry.contains(from) {
        return None;
    }
    let mut seen = vec![false; geometry.cells()];
    let mut open: Vec<Cell> = Vec::new();
    let mut due = vec![from];
    while let Some(cell) = due.pop() {
        if prices.at(costs, cell) > 0 {
            open.push(cell);
            continue;
        }
        for (x, y) in SIDES {
            let next = cell.offset(x, y).filter(|&next| geometry.contains(next));
            if let Some(next) = next.filter(|&next| square(next, from) <= reach * reach)
                && (costs.get(next) == INSCRIBED || prices.at(costs, next) > 0)
                && !core::mem::replace(&mut seen[geometry.index(next)], true)
            {
                due.push(next);
            }
        }
    }
    open.into_iter()
        .min_by(|&a, &b| square(a, from).total_cmp(&square(b, from)))
}

/// Returns the cell nearest to `goal` of those to which a way over open cells leads from `start`, if there is one
/// within `reach` cells of `goal`; of several as near, the first of the grid. Takes a time in proportion to the cells
/// that are reached.
#[must_use]
pub fn nearest_reachable(
    costs: &Costmap,
    prices: &Prices,
    start: Cell,
    goal: Cell,
    reach: f64,
) -> Option<Cell> {
    let geometry = costs.geometry();
    let is_open = |cell: Cell| geometry.contains(cell) && prices.at(costs, cell) > 0;
    // In the order of their distance from the start, so that no more than a frontier is kept.
    let mut due = VecDeque::from_iter(Some(start).filter(|&start| is_open(start)));
    let mut seen = vec![false; geometry.cells()];
    let mut best: Option<(f64, usize)> = None;
    while let Some(cell) = due.pop_front() {
        let found = (square(cell, goal), geometry.index(cell));
        if found.0 <= reach * reach && best.is_none_or(|best| found < best) {
            best = Some(found);
        }
        for (x, y) in SIDES {
            if let Some(next) = cell.offset(x, y).filter(|&next| is_open(next))
                && !core::mem::replace(&mut seen[geometry.index(next)], true)
            {
                due.push_back(next);
            }
        }
    }
    best.map(|(_, index)| geometry.cell(index))
}

/// The square of the distance between two cells.
fn square(a: Cell, b: Cell) -> f64 {
    f64::from(a.x.abs_diff(b.x)).powi(2) + f64::from(a.y.abs_diff(b.y)).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::{LETHAL, UNKNOWN};
    use crate::geometry::Geometry;
    use crate::price::Unknown;

    /// `#` an obstacle, `o` too close to one, `?` unknown.
    fn nearest(row: &str, from: u32, reach: f64) -> Option<u32> {
        let (costs, prices) = costmap(row);
        nearest_open(&costs, &prices, Cell::new(from, 0), reach).map(|cell| cell.x)
    }

    fn costmap(row: &str) -> (Costmap, Prices) {
        let costs: Vec<u8> = row
            .bytes()
            .map(|symbol| match symbol {
                b'#' => LETHAL,
                b'o' => INSCRIBED,
                b'?' => UNKNOWN,
                _ => 0,
            })
            .collect();
        let geometry = Geometry::new(costs.len() as u32, 1, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        (
            Costmap::with_costs(geometry, &costs),
            Prices::new(1.0, Unknown::Closed),
        )
    }

    #[test]
    fn the_nearest_that_can_be_reached_is_not_in_a_pocket() {
        let (costs, prices) = costmap("?....ooo..o#");
        let nearest = |start, goal, reach| {
            let (start, goal) = (Cell::new(start, 0), Cell::new(goal, 0));
            nearest_reachable(&costs, &prices, start, goal, reach).map(|cell| cell.x)
        };
        assert_eq!(nearest(2, 8, 4.0), Some(4), "not the pocket");
        assert_eq!(nearest(2, 8, 3.9), None);
        assert_eq!(nearest(2, 3, 0.0), Some(3), "the goal itself");
        let ring = crate::maps::costmap(5, &[[0; 5], [0, LETHAL, LETHAL, LETHAL, 0], [0; 5]].concat());
        for start in [0, 4, 10, 14].map(|index| ring.geometry().cell(index)) {
            let found = nearest_reachable(&ring, &prices, start, Cell::new(2, 1), 1.0);
            assert_eq!(found, Some(Cell::new(2, 0)), "of two, the first, from {start:?}");
        }
        assert_eq!(nearest(9, 2, 6.0), Some(8));
        assert_eq!(nearest(5, 4, 9.0), None, "from an obstacle");
        assert_eq!(nearest(12, 4, 9.0), None, "from outside");
    }

    #[test]
    fn it_is_the_nearest_on_the_same_side_of_an_obstacle() {
        assert_eq!(nearest("..ooo#o..", 4, 5.0), Some(1), "not through the obstacle");
        assert_eq!(nearest("..ooo....", 4, 5.0), Some(5));
        assert_eq!(nearest("..ooo#o..", 5, 5.0), Some(7), "out of an obstacle");
        assert_eq!(nearest("..ooo", 0, 5.0), Some(0), "open itself");
    }

    #[test]
    fn there_is_none_beyond_the_reach_in_the_unknown_and_outside() {
        assert_eq!(nearest("..ooo#", 4, 2.0), None);
        assert_eq!(nearest("?ooo#", 3, 9.0), None);
        assert_eq!(nearest("#oo#", 1, 9.0), None);
        assert_eq!(nearest("....", 7, 9.0), None);
    }
}
