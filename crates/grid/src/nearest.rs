//! The open cell next to a closed one: where a robot that is too close to an obstacle can go, and what of a goal
//! beside an obstacle can be reached.

use crate::costmap::{Costmap, INSCRIBED};
use crate::geometry::Cell;
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
    let square = |cell: Cell| {
        let (x, y) = (cell.x.abs_diff(from.x), cell.y.abs_diff(from.y));
        f64::from(x).powi(2) + f64::from(y).powi(2)
    };
    let mut seen = vec![false; geometry.cells()];
    let mut open: Vec<Cell> = Vec::new();
    let mut due = vec![from];
    while let Some(cell) = due.pop() {
        if prices.at(costs, cell) > 0 {
            open.push(cell);
            continue;
        }
        for (x, y) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            let next = cell.offset(x, y).filter(|&next| geometry.contains(next));
            if let Some(next) = next.filter(|&next| square(next) <= reach * reach)
                && (costs.get(next) == INSCRIBED || prices.at(costs, next) > 0)
                && !core::mem::replace(&mut seen[geometry.index(next)], true)
            {
                due.push(next);
            }
        }
    }
    open.into_iter().min_by(|&a, &b| square(a).total_cmp(&square(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::{LETHAL, UNKNOWN};
    use crate::geometry::Geometry;
    use crate::price::Unknown;

    /// `#` an obstacle, `o` too close to one, `?` unknown.
    fn nearest(row: &str, from: u32, reach: f64) -> Option<u32> {
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
        let costs = Costmap::with_costs(geometry, &costs);
        let prices = Prices::new(1.0, Unknown::Closed);
        nearest_open(&costs, &prices, Cell::new(from, 0), reach).map(|cell| cell.x)
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
