//! The points of a path in metres. It plans nothing.

use jde_grid::{Geometry, Route as Way};

/// By how much a path may leave the planned way, in cells: far below what a cell itself leaves open.
const TOLERANCE: f64 = 0.25;

/// Returns the points of a way. Its ends are robot and target themselves, not the centres of their cells; a target in an
/// obstacle or off the map is not its end.
pub(crate) fn points(geometry: &Geometry, way: &Way, [robot, target]: [(f64, f64); 2]) -> Vec<(f64, f64)> {
    let way = way.simplified(TOLERANCE);
    let mut points: Vec<_> = way.points.iter().map(|&point| geometry.to_world(point)).collect();
    let end = points
        .pop()
        .filter(|&end| geometry.cell_at(end) != geometry.cell_at(target));
    points.push(end.unwrap_or(target));
    if points.len() > 1 {
        points[0] = robot;
    } else {
        points.insert(0, robot);
    }
    points
}

/// Returns the length of a line through these points.
pub(crate) fn length(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|pair| apart(pair[0], pair[1])).sum()
}

/// Returns the distance between two points.
pub(crate) fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    libm::hypot(b.0 - a.0, b.1 - a.1)
}
