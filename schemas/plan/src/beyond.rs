//! A target off a map that grows: over which cell of its edge the robot leaves the map. A target that no map has is refused.

use jde_grid::{Cell, Geometry, MAX_CELLS, Prices, Route as Way, edge_toward};

use crate::followed::Followed;
use crate::points::apart;
use crate::situation::Situation;

/// How near the robot comes to the edge of a map, m: what its sensors see from there has made the map larger before.
const EDGE_REACHED: f64 = 1.0;

/// By how much another way over the edge must be cheaper before the robot takes it, in cells: two ways round an obstacle
/// differ by less from one plan to the next.
const CHEAPER: f64 = 20.0;

/// Where the map is left on the way to a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exit {
    /// The target.
    of: (f64, f64),
    /// The place on the edge of the map, m.
    place: (f64, f64),
}

/// Refuses a target that is off every map in which the robot is.
pub(crate) fn check_distance(
    geometry: &Geometry,
    robot: (f64, f64),
    target: (f64, f64),
) -> Result<(), Situation> {
    let side = (MAX_CELLS as f64).sqrt() * geometry.resolution();
    let ((column, row), (to_column, to_row)) = (geometry.to_grid(robot), geometry.to_grid(target));
    let cells = (to_column - column).abs().max((to_row - row).abs());
    if cells * geometry.resolution() > side {
        let distance = apart(robot, target);
        return Err(Situation::TooFar { distance, side });
    }
    Ok(())
}

/// Returns the way to the edge of the map: to the place of before while that is on the edge and no other way is much cheaper,
/// else to the best one.
///
/// # Errors
/// If no way leads off the map.
pub(crate) fn way_off(
    kept: &mut Option<Exit>,
    (followed, prices): (&Followed, &Prices),
    start: Cell,
    target: (f64, f64),
    mut way_to: impl FnMut(Cell) -> Option<Way>,
) -> Result<Way, Situation> {
    let costs = followed.costs();
    let geometry = costs.geometry();
    let before = kept.take().filter(|exit| exit.of == target);
    let (cell, least) = edge_toward(costs, prices, start, target).ok_or(Situation::NoWayOff)?;
    if let Some(exit) = before
        && let Some(same) = geometry
            .cell_at(exit.place)
            .filter(|&same| geometry.is_on_edge(same))
        && let Some(way) = way_to(same)
        && way.price + apart(exit.place, target) / geometry.resolution() <= least + CHEAPER
    {
        *kept = Some(exit);
        return Ok(way);
    }
    let place = geometry.center(cell);
    *kept = Some(Exit { of: target, place });
    way_to(cell).ok_or(Situation::NoWayOff)
}

/// Says what a path to the edge is: the robot is there if it is short.
///
/// # Errors
/// If the robot is at the edge.
pub(crate) fn toward(length: f64, cut: bool, left: f64) -> Result<Situation, Situation> {
    match length < EDGE_REACHED {
        true => Err(Situation::AtEdge),
        false => Ok(Situation::Toward { length, cut, left }),
    }
}
