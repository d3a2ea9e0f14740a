//! The way out of a zone, for a robot that stands in one. It plans to no goal.

use crate::costmap::Costmap;
use crate::field::Field;
use crate::geometry::Cell;
use crate::price::Prices;
use crate::route::Route;

/// Returns the cheapest way over the costs `base` from a cell to one that is open in `costs`, of the same
/// geometry; `None` if there is no such way. Takes a field of the whole map.
#[must_use]
pub fn way_out(base: &Costmap, costs: &Costmap, prices: &Prices, from: Cell) -> Option<Route> {
    let mut field = Field::new(base, prices, from).ok()?;
    field.settle();
    let geometry = costs.geometry();
    let (_, out) = (0..geometry.cells())
        .map(|index| geometry.cell(index))
        .filter(|&cell| prices.at(costs, cell) > 0)
        .filter_map(|cell| Some((field.price(cell)?, cell)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut way = field.route(out).ok()?;
    way.points.reverse();
    Some(way)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::{INSCRIBED, LETHAL};
    use crate::maps::costmap;
    use crate::price::Unknown;

    #[test]
    fn it_leads_around_an_obstacle_to_the_nearest_cell_by_way() {
        let prices = Prices::new(1.0, Unknown::Closed);
        let (w, z) = (LETHAL, INSCRIBED);
        // A wall within the zone: beyond it lies the nearest open cell in a straight line.
        let base = costmap(6, &[0, 0, 0, w, 0, 0, 0, 0, 0, 0, 0, 0]);
        let mut zoned = [z; 12];
        (zoned[3], zoned[4], zoned[6]) = (w, 0, 0);
        let from = Cell::new(2, 0);
        let way = way_out(&base, &costmap(6, &zoned), &prices, from).expect("a way");
        let ends = (way.points.first(), way.points.last());
        assert_eq!(ends, (Some(&(2.5, 0.5)), Some(&(0.5, 1.5))));
        assert_eq!(way_out(&base, &costmap(6, &[z; 12]), &prices, from), None);
        assert_eq!(way_out(&base, &base, &prices, Cell::new(3, 0)), None, "in a wall");
    }
}
