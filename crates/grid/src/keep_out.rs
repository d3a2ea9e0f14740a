//! Places where the robot must not go although nothing stands there: their cells count as occupied.

use crate::geometry::{Cell, Geometry};
use crate::occupancy::{Occupancy, OccupancyGrid};

impl OccupancyGrid {
    /// Makes all cells occupied that a polygon touches. Its corners are in the world, in metres; it closes by
    /// itself, and edges that cross count by the even-odd rule. Returns how many cells were not occupied.
    ///
    /// Cells whose centre is within half a diagonal of an edge belong to it, so that no part of the polygon
    /// is left out. A polygon with a corner that is not finite, or without corners, touches no cell.
    pub fn keep_out(&mut self, polygon: &[(f64, f64)]) -> usize {
        let geometry = *self.geometry();
        let corners: Vec<(f64, f64)> = polygon.iter().map(|&corner| geometry.to_grid(corner)).collect();
        let Some((columns, rows)) = extent(&corners, &geometry) else {
            return 0;
        };
        let mut changed = 0;
        for y in rows.0..rows.1 {
            for x in columns.0..columns.1 {
                if touches(&corners, (f64::from(x) + 0.5, f64::from(y) + 0.5)) {
                    changed += usize::from(self.set(Cell::new(x, y), Occupancy::Occupied));
                }
            }
        }
        changed
    }
}

/// The columns and rows around the corners, each from the first to behind the last.
type Extent = ((u32, u32), (u32, u32));

fn extent(corners: &[(f64, f64)], geometry: &Geometry) -> Option<Extent> {
    if corners.is_empty() || !corners.iter().all(|(x, y)| x.is_finite() && y.is_finite()) {
        return None;
    }
    // A conversion to an integer keeps to the limits of its type.
    let range = |values: &mut dyn Iterator<Item = f64>, size: u32| {
        let (least, most) = values.fold((f64::MAX, f64::MIN), |(least, most), v| {
            (least.min(v), most.max(v))
        });
        let (first, last) = (libm::floor(least - 1.0) as u32, libm::ceil(most + 1.0) as u32);
        (first.min(size), last.min(size))
    };
    Some((
        range(&mut corners.iter().map(|corner| corner.0), geometry.width()),
        range(&mut corners.iter().map(|corner| corner.1), geometry.height()),
    ))
}

/// Returns whether a cell with this centre touches the polygon; all are in columns and rows.
fn touches(corners: &[(f64, f64)], (x, y): (f64, f64)) -> bool {
    let mut inside = false;
    let closed = corners.iter().zip(corners.iter().cycle().skip(1));
    for (&(ax, ay), &(bx, by)) in closed {
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx * dx + dy * dy;
        let along = if length > 0.0 {
            (((x - ax) * dx + (y - ay) * dy) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (away_x, away_y) = (ax + along * dx - x, ay + along * dy - y);
        // Half the diagonal, squared.
        if away_x * away_x + away_y * away_y <= 0.5 {
            return true;
        }
        if (ay > y) != (by > y) && x < ax + (y - ay) / dy * dx {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> OccupancyGrid {
        let geometry = Geometry::new(10, 10, 1.0, (-5.0, -5.0, 0.0)).expect("valid");
        OccupancyGrid::filled(geometry, Occupancy::Free)
    }

    fn occupied(grid: &OccupancyGrid, x: f64, y: f64) -> bool {
        grid.geometry()
            .cell_at((x, y))
            .is_some_and(|cell| grid.get(cell) == Occupancy::Occupied)
    }

    #[test]
    fn a_polygon_fills_its_cells_and_no_others() {
        let mut grid = grid();
        let square = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
        assert!(grid.keep_out(&square) >= 16);
        for (x, y, expected) in [
            (0.5, 0.5, true),
            (1.9, -1.9, true),
            (3.5, 0.5, false),
            (-4.5, 4.5, false),
        ] {
            assert_eq!(occupied(&grid, x, y), expected, "{x}, {y}");
        }
        assert_eq!(grid.keep_out(&square), 0, "already occupied");
    }

    #[test]
    fn a_line_and_a_point_occupy_what_they_touch() {
        let mut grid = grid();
        assert!(grid.keep_out(&[(-4.5, 0.5), (4.5, 0.5)]) >= 10);
        assert!((-4..=4).all(|x| occupied(&grid, f64::from(x) + 0.5, 0.5)));
        assert!(grid.keep_out(&[(0.5, -3.5)]) >= 1);
        assert!(occupied(&grid, 0.5, -3.5));
    }

    #[test]
    fn polygons_outside_and_without_finite_corners_occupy_nothing() {
        let mut grid = grid();
        for polygon in [
            &[][..],
            &[(f64::NAN, 0.0), (1.0, 1.0)],
            &[(f64::INFINITY, 0.0), (1.0, 1.0)],
            &[(50.0, 50.0), (60.0, 50.0), (60.0, 60.0)],
            &[(-60.0, -60.0), (-50.0, -60.0), (-50.0, -50.0)],
        ] {
            assert_eq!(grid.keep_out(polygon), 0, "{polygon:?}");
        }
    }
}
