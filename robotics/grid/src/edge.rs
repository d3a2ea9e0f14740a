//! The edge of a map over which a robot leaves it, to a goal outside. It plans no way.

use crate::costmap::Costmap;
use crate::field::Field;
use crate::geometry::Cell;
use crate::price::Prices;

/// Returns the cell on the edge of the map over which the way to a place outside is the cheapest, and what that way costs:
/// the price from `start` to the cell and the straight distance from there to `goal`, in cells; of several as cheap, the
/// first. `goal` is in metres. `None` if no way leads from `start` to the edge. Takes a field of the whole map.
#[must_use]
pub fn edge_toward(costs: &Costmap, prices: &Prices, start: Cell, goal: (f64, f64)) -> Option<(Cell, f64)> {
    let mut field = Field::new(costs, prices, start).ok()?;
    field.settle();
    let geometry = costs.geometry();
    let beyond = |cell| {
        let (x, y) = geometry.center(cell);
        libm::hypot(goal.0 - x, goal.1 - y) / geometry.resolution()
    };
    let (right, top) = (geometry.width() - 1, geometry.height() - 1);
    let across = (0..=right).flat_map(|x| [Cell::new(x, 0), Cell::new(x, top)]);
    let up = (0..=top).flat_map(|y| [Cell::new(0, y), Cell::new(right, y)]);
    across
        .chain(up)
        .filter_map(|cell| Some((cell, field.price(cell)? + beyond(cell))))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::{LETHAL, UNKNOWN};
    use crate::maps::costmap;
    use crate::price::Unknown;

    const OPEN: Unknown = Unknown::Open;

    /// The cell for a robot in the middle of a map of 5 × 5 cells of 1 m.
    fn edge(walls: &[(u32, u32)], goal: (f64, f64), unknown: Unknown) -> Option<Cell> {
        let mut costs = [UNKNOWN; 25];
        (costs[12], costs[13]) = (0, 0);
        for (x, y) in walls {
            costs[(y * 5 + x) as usize] = LETHAL;
        }
        let prices = Prices::new(1.0, unknown);
        edge_toward(&costmap(5, &costs), &prices, Cell::new(2, 2), goal).map(|(cell, _)| cell)
    }

    #[test]
    fn it_is_on_the_side_of_the_goal_and_round_an_obstacle() {
        assert_eq!(edge(&[], (40.5, 2.5), OPEN), Some(Cell::new(4, 2)));
        assert_eq!(edge(&[], (2.5, -40.5), OPEN), Some(Cell::new(2, 0)));
        assert_eq!(edge(&[], (40.5, 40.5), OPEN), Some(Cell::new(4, 4)));
        let wall = [(4, 2), (4, 3), (4, 4)];
        assert_eq!(edge(&wall, (9.5, 2.5), OPEN), Some(Cell::new(4, 1)));
    }

    #[test]
    fn it_is_not_the_nearest_one_if_the_way_there_is_long() {
        // A wall down from the top: the goal is straight above what is behind it.
        let wall = [(3, 4), (3, 3), (3, 2), (3, 1)];
        assert_eq!(edge(&wall, (4.5, 9.5), OPEN), Some(Cell::new(2, 4)));
    }

    #[test]
    fn there_is_none_in_a_closed_room_and_where_the_unknown_is_closed() {
        let ring: Vec<(u32, u32)> = (1..4)
            .flat_map(|at| [(at, 1), (at, 3), (1, at), (3, at)])
            .collect();
        assert_eq!(edge(&ring, (40.5, 2.5), OPEN), None);
        assert_eq!(edge(&[], (40.5, 2.5), Unknown::Closed), None);
        assert_eq!(edge(&[(2, 2)], (40.5, 2.5), OPEN), None, "from an obstacle");
    }

    #[test]
    fn its_price_is_that_of_the_way_and_the_rest() {
        let map = costmap(5, &[0; 25]);
        let prices = Prices::new(1.0, Unknown::Closed);
        let (cell, price) = edge_toward(&map, &prices, Cell::new(2, 2), (10.5, 2.5)).expect("an edge");
        assert_eq!(cell, Cell::new(4, 2));
        assert!((price - 8.0).abs() < 1e-6, "{price} cells");
    }
}
