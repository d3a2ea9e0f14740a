//! The way down the field: along the slope, interpolated between the centres of four cells.
//!
//! Where the slope leads into a closed cell or no further down, the way goes to the centre of the lowest
//! neighbour, whose price is always lower; so it ends at the goal.

use super::Field;
use super::wave::UNREACHED;
use crate::geometry::Cell;
use crate::line::walk;
use crate::price::UNIT;
use crate::route::{Point, Route, center};
use crate::search::STEPS;

/// The length of a step, in cells: several in each cell, and few enough points.
const STEP: f64 = 0.5;

/// Steps along the slope without a lower cell, before the way goes to the lowest neighbour: a cell's diagonal
/// takes three.
const PATIENCE: u32 = 4;

impl Field {
    /// The way from a cell that a price is known of, in a field that is settled up to it.
    pub(super) fn descend(&self, start: Cell) -> Route {
        let mut points = vec![center(start)];
        let (mut point, mut lowest, mut patience) = (center(start), start, PATIENCE);
        while lowest != self.goal {
            let along = (patience > 0).then(|| self.along_slope(point, lowest)).flatten();
            let next = along.unwrap_or_else(|| center(self.lower_neighbour(lowest)));
            patience = if along.is_some() {
                patience.saturating_sub(1)
            } else {
                PATIENCE
            };
            let cell = Cell::new(next.0 as u32, next.1 as u32);
            if self.known_at(cell) < self.known_at(lowest) {
                patience = PATIENCE;
            }
            // One along the slope may be as low. A neighbour of another cell may lie behind a corner.
            (lowest, point) = (cell, next);
            points.push(point);
        }
        // The last step ends within the goal's cell.
        points.push(center(self.goal));
        let start = self.known_at(start);
        Route {
            points,
            price: f64::from(start) / f64::from(UNIT),
        }
    }

    /// The point a step farther down the slope; `None` if it is closed or higher, or there is no slope.
    fn along_slope(&self, (x, y): Point, lowest: Cell) -> Option<Point> {
        let (dx, dy) = self.slope((x, y))?;
        let next = (x - STEP * dx, y - STEP * dy);
        if next.0 < 0.0 || next.1 < 0.0 {
            return None;
        }
        let (from, to) = (
            Cell::new(x as u32, y as u32),
            Cell::new(next.0 as u32, next.1 as u32),
        );
        let open = walk(from, to, |cell, _| self.crossing_at(cell) > 0);
        (open && self.known_at(to) <= self.known_at(lowest)).then_some(next)
    }

    /// The direction in which the price grows fastest, of length 1, interpolated between the four nearest
    /// centres; `None` where no neighbour has a price, or they balance.
    fn slope(&self, (x, y): Point) -> Option<(f64, f64)> {
        let (left, below) = (libm::floor(x - 0.5), libm::floor(y - 0.5));
        let (across, along) = (x - 0.5 - left, y - 0.5 - below);
        let (mut dx, mut dy) = (0.0, 0.0);
        for (column, share_x) in [(left, 1.0 - across), (left + 1.0, across)] {
            for (row, share_y) in [(below, 1.0 - along), (below + 1.0, along)] {
                if column >= 0.0 && row >= 0.0 {
                    let (gx, gy) = self.slope_of(Cell::new(column as u32, row as u32));
                    dx += share_x * share_y * gx;
                    dy += share_x * share_y * gy;
                }
            }
        }
        let length = libm::hypot(dx, dy);
        (length > 1e-6).then(|| (dx / length, dy / length))
    }

    /// The slope of one cell, of length 1, toward whichever neighbour in its row and in its column is lower;
    /// zero without a price and at the goal.
    fn slope_of(&self, cell: Cell) -> (f64, f64) {
        let price = self.known_at(cell);
        if price == UNREACHED {
            return (0.0, 0.0);
        }
        let at = |dx, dy| cell.offset(dx, dy).map_or(UNREACHED, |next| self.known_at(next));
        let rise = |before: u32, after: u32| {
            let (low, sign) = if before <= after {
                (before, 1.0)
            } else {
                (after, -1.0)
            };
            sign * f64::from(price.saturating_sub(low))
        };
        let (dx, dy) = (rise(at(-1, 0), at(1, 0)), rise(at(0, -1), at(0, 1)));
        let length = libm::hypot(dx, dy);
        if length > 0.0 {
            (dx / length, dy / length)
        } else {
            (0.0, 0.0)
        }
    }

    /// The lowest of the neighbours that a step may lead to. A neighbour in the row or the column of a cell
    /// with a price is lower than it, since the price came from there.
    fn lower_neighbour(&self, cell: Cell) -> Cell {
        let open = |dx, dy| cell.offset(dx, dy).filter(|&next| self.crossing_at(next) > 0);
        let passable =
            |&(dx, dy): &(i32, i32)| dx == 0 || dy == 0 || (open(dx, 0).is_some() && open(0, dy).is_some());
        let steps = STEPS.into_iter().filter(passable);
        steps
            .filter_map(|(dx, dy)| open(dx, dy))
            .min_by_key(|&next| self.known_at(next))
            .unwrap_or(cell)
    }
}
