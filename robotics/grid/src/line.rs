//! The cells that a straight line between the centres of two cells passes, in exact arithmetic.

use crate::geometry::{Cell, Geometry};

/// Calls `visit` for every cell that the line from `from` to `to` passes, in this order and with the share of
/// the line that lies in the cell; the shares add up to 1. Where the line passes a corner exactly, both cells
/// beside it are visited with the share 0, because nothing fits between two cells that meet at a corner.
///
/// Stops as soon as `visit` returns `false`. Returns whether it never did.
#[inline]
pub fn walk(from: Cell, to: Cell, mut visit: impl FnMut(Cell, f64) -> bool) -> bool {
    let (dx, dy) = (i64::from(from.x.abs_diff(to.x)), i64::from(from.y.abs_diff(to.y)));
    let step = |from: u32, to: u32| if to >= from { 1 } else { -1 };
    let (right, up) = (step(from.x, to.x), step(from.y, to.y));
    // Half a column, and half a row, as a share of the line.
    let halves = |size: i64| 0.5 / size as f64;
    let (half_column, half_row) = (halves(dx), halves(dy));
    let (mut cell, mut across, mut along, mut share) = (from, 0, 0, 0.0);
    // The way to the next column less that to the next row, both times 2 dx dy: (2 across + 1) dy - (2 along + 1) dx.
    let mut lead = dy - dx;
    while across < dx || along < dy {
        let mut next = cell;
        let until = if lead <= 0 {
            (2 * across + 1) as f64 * half_column
        } else {
            (2 * along + 1) as f64 * half_row
        };
        let is_corner = lead == 0;
        let (enters_column, enters_row) = (lead <= 0, lead >= 0);
        if enters_column {
            next.x = cell.x.wrapping_add_signed(right);
            (across, lead) = (across + 1, lead + 2 * dy);
        }
        if enters_row {
            next.y = cell.y.wrapping_add_signed(up);
            (along, lead) = (along + 1, lead - 2 * dx);
        }
        if !visit(cell, until - share) {
            return false;
        }
        if is_corner && !(visit(Cell::new(next.x, cell.y), 0.0) && visit(Cell::new(cell.x, next.y), 0.0)) {
            return false;
        }
        (cell, share) = (next, until);
    }
    visit(cell, 1.0 - share)
}

/// Calls `visit` with the places in the data of a grid of the cells that [`walk`] visits, in any order. It takes a few
/// instructions for a cell: rays pass many.
#[inline]
pub(crate) fn walk_places(geometry: &Geometry, from: Cell, to: Cell, mut visit: impl FnMut(usize)) {
    let (dx, dy) = (i64::from(from.x.abs_diff(to.x)), i64::from(from.y.abs_diff(to.y)));
    let width = geometry.width() as isize;
    let column = if to.x >= from.x { 1 } else { -1 };
    let row = if to.y >= from.y { width } else { -width };
    // As in `walk`.
    let (mut place, mut lead, mut steps) = (geometry.index(from), dy - dx, dx + dy);
    visit(place);
    while steps > 0 {
        if lead == 0 {
            visit(place.wrapping_add_signed(column));
            visit(place.wrapping_add_signed(row));
            place = place.wrapping_add_signed(column + row);
            (lead, steps) = (2 * (dy - dx), steps - 2);
        } else {
            let (by, change) = if lead < 0 {
                (column, 2 * dy)
            } else {
                (row, -2 * dx)
            };
            place = place.wrapping_add_signed(by);
            (lead, steps) = (lead + change, steps - 1);
        }
        visit(place);
    }
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
            let geometry = Geometry::new(60, 60, 1.0, (0.0, 0.0, 0.0)).expect("valid");
            let mut places = Vec::new();
            walk_places(&geometry, from, to, |place| places.push(geometry.cell(place)));
            let mut places: Vec<_> = places.iter().map(|cell| (cell.x, cell.y)).collect();
            let mut forth = cells(a, b);
            let mut back = cells(b, a);
            forth.sort_unstable();
            back.sort_unstable();
            places.sort_unstable();
            prop_assert_eq!(&forth, &places);
            prop_assert_eq!(forth, back, "the same cells from either end");
        }
    }
}
