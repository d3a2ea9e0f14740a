//! Frontiers: where what is known to be free borders on what is unknown (Yamauchi, "A frontier-based approach for
//! autonomous exploration", 1997). It does not know which of them a robot can reach.

use crate::geometry::{Cell, SIDES};
use crate::occupancy::{Occupancy, OccupancyGrid};
use crate::window::Window;

/// Returns the frontiers of a grid, each as its cells: the free cells with an unknown one beside them, connected by
/// sides and corners. What is outside the grid is unknown.
///
/// The order is that of their first cells, row by row from the origin. Takes a time in proportion to the cells of the
/// grid.
#[must_use]
pub fn frontiers(grid: &OccupancyGrid) -> Vec<Vec<Cell>> {
    let geometry = grid.geometry();
    let mut is_open = vec![false; geometry.cells()];
    let mut open = Vec::new();
    for row in Window::known(grid).iter().flat_map(|known| known.rows(geometry)) {
        let mut cell = geometry.cell(row.start);
        for index in row {
            if grid.cells()[index] == Occupancy::Free && has_unknown_side(grid, cell) {
                is_open[index] = true;
                open.push(cell);
            }
            cell.x += 1;
        }
    }
    let mut found = Vec::new();
    for first in open {
        if !core::mem::take(&mut is_open[geometry.index(first)]) {
            continue;
        }
        let mut cells = vec![first];
        let mut at = 0;
        while let Some(&cell) = cells.get(at) {
            at += 1;
            for (x, y) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
                if let Some(next) = cell.offset(x, y).filter(|&next| geometry.contains(next))
                    && core::mem::take(&mut is_open[geometry.index(next)])
                {
                    cells.push(next);
                }
            }
        }
        found.push(cells);
    }
    found
}

/// Whether a cell beside this one is unknown.
fn has_unknown_side(grid: &OccupancyGrid, cell: Cell) -> bool {
    let is_unknown = |next: Option<Cell>| next.is_none_or(|next| grid.get(next) == Occupancy::Unknown);
    SIDES.iter().any(|&(x, y)| is_unknown(cell.offset(x, y)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::Geometry;

    /// `.` free, `#` occupied, `?` unknown; the first row is that of the origin.
    fn grid(rows: &[&str]) -> OccupancyGrid {
        let size = (rows[0].len() as u32, rows.len() as u32);
        let geometry = Geometry::new(size.0, size.1, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let numbers: Vec<i8> = rows
            .iter()
            .flat_map(|row| row.bytes())
            .map(|symbol| match symbol {
                b'.' => 0,
                b'#' => 100,
                _ => -1,
            })
            .collect();
        OccupancyGrid::from_ros(geometry, &numbers).expect("as many as cells")
    }

    #[test]
    fn a_door_to_the_unknown_is_a_frontier_and_a_wall_is_none() {
        let found = frontiers(&grid(&["#####??", "#...#??", "#....??", "#...#??", "#####??"]));
        assert_eq!(found, [vec![Cell::new(4, 2)]]);
        assert!(frontiers(&grid(&["???", "?#?", "???"])).is_empty());
    }

    #[test]
    fn what_touches_at_a_corner_is_one_frontier_and_the_edge_of_the_grid_borders_on_the_unknown() {
        let found = frontiers(&grid(&["#####", "#.??#", "##.?#", "#####"]));
        assert_eq!(found, [vec![Cell::new(1, 1), Cell::new(2, 2)]]);
        assert_eq!(frontiers(&grid(&["###", "..#", "###"])), [vec![Cell::new(0, 1)]]);
    }

    proptest! {
        #[test]
        fn they_are_the_connected_parts_of_the_free_cells_beside_unknown_ones(
            width in 1_u32..12,
            numbers in prop::collection::vec(prop_oneof![Just(0_i8), Just(-1), Just(100)], 1..140),
        ) {
            let height = numbers.len() as u32 / width;
            prop_assume!(height > 0);
            let geometry = Geometry::new(width, height, 1.0, (0.0, 0.0, 0.0)).expect("valid");
            let numbers = &numbers[..geometry.cells()];
            let grid = OccupancyGrid::from_ros(geometry, numbers).expect("as many as cells");
            let at = |x: i64, y: i64| match (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y) {
                true => numbers[(y * i64::from(width) + x) as usize],
                false => -1,
            };
            let expected: Vec<Cell> = (0..geometry.cells())
                .map(|index| geometry.cell(index))
                .filter(|cell| {
                    let (x, y) = (i64::from(cell.x), i64::from(cell.y));
                    at(x, y) == 0 && [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(dx, dy)| at(x + dx, y + dy) == -1)
                })
                .collect();
            let found = frontiers(&grid);
            let mut all: Vec<Cell> = found.iter().flatten().copied().collect();
            all.sort_by_key(|&cell| geometry.index(cell));
            prop_assert_eq!(all, expected);
            let touch = |a: &Cell, b: &Cell| a.x.abs_diff(b.x) <= 1 && a.y.abs_diff(b.y) <= 1;
            for (number, cells) in found.iter().enumerate() {
                for other in &found[number + 1..] {
                    prop_assert!(!cells.iter().any(|a| other.iter().any(|b| touch(a, b))), "two are one");
                }
                let mut reached = vec![cells[0]];
                let mut left = cells[1..].to_vec();
                while let Some(next) = left.iter().position(|cell| reached.iter().any(|at| touch(at, cell))) {
                    reached.push(left.swap_remove(next));
                }
                prop_assert!(left.is_empty(), "one is two");
            }
        }
    }
}
