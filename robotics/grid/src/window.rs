//! Rectangles of cells. They know nothing of what is in the cells but whether it is known.

use core::ops::Range;

use crate::geometry::{Cell, Geometry};
use crate::occupancy::{Occupancy, OccupancyGrid};

/// A rectangle of cells, both corners included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    least: Cell,
    most: Cell,
}

impl Window {
    fn whole(geometry: &Geometry) -> Self {
        Self {
            least: Cell::new(0, 0),
            most: Cell::new(geometry.width() - 1, geometry.height() - 1),
        }
    }

    /// The smallest one around those cells that are in the grid.
    pub(crate) fn around(cells: &[Cell], geometry: &Geometry) -> Option<Self> {
        let inside = cells.iter().filter(|&&cell| geometry.contains(cell));
        inside
            .map(|&cell| Self {
                least: cell,
                most: cell,
            })
            .reduce(|a, b| Self {
                least: Cell::new(a.least.x.min(b.least.x), a.least.y.min(b.least.y)),
                most: Cell::new(a.most.x.max(b.most.x), a.most.y.max(b.most.y)),
            })
    }

    /// The smallest one around the cells that are known.
    pub(crate) fn known(grid: &OccupancyGrid) -> Option<Self> {
        let is_known = |state: &Occupancy| *state != Occupancy::Unknown;
        let mut window: Option<Self> = None;
        for (row, y) in grid
            .cells()
            .chunks_exact(grid.geometry().width() as usize)
            .zip(0..)
        {
            // Most rows of a large grid are unknown, and the compiler uses the vector unit for this.
            if !row.iter().fold(false, |any, state| any | is_known(state)) {
                continue;
            }
            let first = row.iter().position(is_known).unwrap_or_default() as u32;
            let last = row.iter().rposition(is_known).unwrap_or_default() as u32;
            let (least, most) = window.map_or((first, last), |window| (window.least.x, window.most.x));
            window = Some(Self {
                least: Cell::new(least.min(first), window.map_or(y, |window| window.least.y)),
                most: Cell::new(most.max(last), y),
            });
        }
        window
    }

    /// This one with `by` more cells on each side, as far as the grid reaches.
    pub(crate) fn grown(self, by: u32, geometry: &Geometry) -> Self {
        let edge = Self::whole(geometry).most;
        Self {
            least: Cell::new(self.least.x.saturating_sub(by), self.least.y.saturating_sub(by)),
            most: Cell::new((self.most.x + by).min(edge.x), (self.most.y + by).min(edge.y)),
        }
    }

    pub(crate) const fn width(&self) -> usize {
        (self.most.x - self.least.x) as usize + 1
    }

    pub(crate) const fn height(&self) -> usize {
        (self.most.y - self.least.y) as usize + 1
    }

    /// How many columns and rows a window within this one begins after it.
    pub(crate) const fn offset(&self, inner: &Self) -> (usize, usize) {
        (
            (inner.least.x - self.least.x) as usize,
            (inner.least.y - self.least.y) as usize,
        )
    }

    /// The places of its rows in the data of the grid, from the origin on.
    pub(crate) fn rows(self, geometry: &Geometry) -> impl Iterator<Item = Range<usize>> + use<> {
        let (geometry, width) = (*geometry, self.width());
        (self.least.y..=self.most.y).map(move |y| {
            let first = geometry.index(Cell::new(self.least.x, y));
            first..first + width
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_window_is_the_smallest_around_what_is_known() {
        let geometry = Geometry::new(6, 5, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let mut grid = OccupancyGrid::filled(geometry, Occupancy::Unknown);
        assert_eq!(Window::known(&grid), None);
        let mut known = Vec::new();
        for (x, y) in [(3, 1), (1, 3), (4, 3), (2, 2)] {
            let cell = Cell::new(x, y);
            known.push(cell);
            grid.set(cell, Occupancy::Free);
            assert_eq!(
                Window::known(&grid),
                Window::around(&known, &geometry),
                "{cell:?}"
            );
        }
    }

    #[test]
    fn the_rows_of_a_window_are_the_places_of_its_cells() {
        let geometry = Geometry::new(6, 5, 0.1, (0.0, 0.0, 0.0)).expect("valid");
        let corners = [Cell::new(1, 1), Cell::new(3, 2)];
        let window = Window::around(&corners, &geometry).expect("cells");
        assert_eq!(window.rows(&geometry).collect::<Vec<_>>(), [7..10, 13..16]);
        let grown = window.grown(2, &geometry);
        assert_eq!((grown.width(), grown.height()), (6, 5));
        assert_eq!(grown.offset(&window), (1, 1));
    }
}
