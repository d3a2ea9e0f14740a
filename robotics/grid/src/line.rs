//! The cells that a straight line between the centres of two cells passes, in exact arithmetic.

use crate::geometry::Cell;

/// Calls `visit` for every cell that the line from `from` to `to` passes, in this order and with the share of
/// the line that lies in the cell; the shares add up to 1. Where the line passes a corner exactly, both cells
/// beside it are visited with the share 0, because nothing fits between two cells that meet at a corner.
///
/// Stops as soon as `visit` returns `false`. Returns whether it never did.
pub fn walk(from: Cell, to: Cell, mut visit: impl FnMut(Cell, f64) -> bool) -> bool {
    let (dx, dy) = (u64::from(from.x.abs_diff(to.x)), u64::from(from.y.abs_diff(to.y)));
    let right = |x: u32| if to.x >= from.x { x + 1 } else { x - 1 };
    let up = |y: u32| if to.y >= from.y { y + 1 } else { y - 1 };
    // Half a column, and half a row, as a share of the line.
    let halves = |size: u64| 0.5 / size as f64;
    let (half_column, half_row) = (halves(dx), halves(dy));
    let (mut cell, mut across, mut along, mut share) = (from, 0, 0, 0.0);
    while across < dx || along < dy {
        let (next_column, next_row) = ((2 * across + 1) * dy, (2 * along + 1) * dx);
        let mut next = cell;
        let until = if next_column <= next_row {
            (2 * across + 1) as f64 * half_column
        } else {
            (2 * along + 1) as f64 * half_row
        };
        if next_column <= next_row {
            next.x = right(cell.x);
            across += 1;
        }
        if next_row <= next_column {
            next.y = up(cell.y);
            along += 1;
        }
        if !visit(cell, until - share) {
            return false;
        }
        if next_column == next_row
            && !(visit(Cell::new(next.x, cell.y), 0.0) && visit(Cell::new(cell.x, next.y), 0.0))
        {
            return false;
        }
        (cell, share) = (next, until);
    }
    visit(cell, 1.0 - share)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cells(from: (u32, u32), to: (u32, u32)) -> Vec<(u32, u32)> {
        let mut cells = Vec::new();
        let whole = walk(Cell::new(from.0, from.1), Cell::new(to.0, to.1), |cell, _| {
            cells.push((cell.x, cell.y));
            true
        });
        assert!(whole);
        cells
    }

    #[test]
    fn a_diagonal_visits_the_cells_beside_its_corners() {
        assert_eq!(cells((1, 1), (1, 1)), [(1, 1)]);
        assert_eq!(cells((0, 1), (1, 0)), [(0, 1), (1, 1), (0, 0), (1, 0)]);
        assert_eq!(cells((3, 0), (1, 0)), [(3, 0), (2, 0), (1, 0)]);
        assert_eq!(cells((0, 0), (2, 1)), [(0, 0), (1, 0), (1, 1), (2, 1)]);
    }

    #[test]
    fn it_stops_at_the_first_refusal() {
        let mut visited = 0;
        assert!(!walk(Cell::new(0, 0), Cell::new(9, 3), |_, _| {
            visited += 1;
            visited < 4
        }));
        assert_eq!(visited, 4);
    }

    proptest! {
        #[test]
        fn it_is_connected_and_its_shares_add_up_to_1(
            a in (0u32..60, 0u32..60), b in (0u32..60, 0u32..60),
        ) {
            let (from, to) = (Cell::new(a.0, a.1), Cell::new(b.0, b.1));
            let (mut sum, mut last) = (0.0, from);
            walk(from, to, |cell, share| {
                assert!(share >= 0.0);
                assert!(cell.x.abs_diff(last.x) <= 1 && cell.y.abs_diff(last.y) <= 1);
                sum += share;
                last = cell;
                true
            });
            prop_assert_eq!(last, to);
            prop_assert!((sum - 1.0).abs() < 1e-12);
            let mut forth = cells(a, b);
            let mut back = cells(b, a);
            forth.sort_unstable();
            back.sort_unstable();
            prop_assert_eq!(forth, back, "the same cells from either end");
        }
    }
}
