//! The price to the goal from every cell, kept as the map changes: the navigation function of Konolige ("A
//! gradient method for realtime robot control", 2000), as a wave that propagates at any angle and whose
//! changes are repaired in place (Philippsen and Siegwart, "An interpolated dynamic navigation function",
//! 2005; the repair is that of Ramalingam and Reps, "An incremental algorithm for a generalization of the
//! shortest-path problem", 1996).
//!
//! A repaired field equals a new one to the last bit.

mod descent;
mod wave;

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::costmap::Costmap;
use crate::geometry::{Cell, Geometry};
use crate::price::{Prices, UNIT};
use crate::route::{PlanError, Route, check_ends};
use wave::{UNREACHED, arrival};

/// How much farther than the start a field is settled before a descent, in cells of the lowest price: the
/// slope at the start is measured with the cells around it.
const BEYOND_START: u32 = 4 * UNIT;

/// The field of prices to one goal.
#[derive(Clone, Debug)]
pub struct Field {
    geometry: Geometry,
    goal: Cell,
    prices: Prices,
    /// The price of each cell's own crossing; 0 if it is closed.
    crossing: Vec<u16>,
    /// The price to the goal, as it was last propagated.
    known: Vec<u32>,
    /// The price to the goal by the neighbours' known prices. Where both differ, the cell is in `open`.
    due: Vec<u32>,
    /// Cells to propagate, by the lower of both prices. Entries with an older price are passed over.
    open: BinaryHeap<Reverse<(u32, u32)>>,
    /// Cells propagated so far.
    propagated: u64,
}

impl Field {
    /// Returns the field of a goal, not yet propagated: [`Field::route`] does so as far as necessary, and
    /// [`Field::settle`] everywhere.
    ///
    /// Takes 10 bytes of memory for each cell.
    ///
    /// # Errors
    /// If the goal is outside the map or closed.
    pub fn new(costs: &Costmap, prices: &Prices, goal: Cell) -> Result<Self, PlanError> {
        check_ends(costs, prices, goal, goal)?;
        let geometry = *costs.geometry();
        let mut field = Self {
            geometry,
            goal,
            prices: prices.clone(),
            crossing: costs.costs().iter().map(|&cost| prices.of(cost)).collect(),
            known: vec![UNREACHED; geometry.cells()],
            due: vec![UNREACHED; geometry.cells()],
            open: BinaryHeap::new(),
            propagated: 0,
        };
        field.review(field.goal);
        Ok(field)
    }

    /// Follows the costs of these cells, in any order and with repetitions. The field is repaired by the next
    /// [`Field::route`] or [`Field::settle`].
    ///
    /// # Panics
    /// If the costmap has another geometry.
    pub fn update(&mut self, costs: &Costmap, changed: &[Cell]) {
        assert_eq!(
            costs.geometry(),
            &self.geometry,
            "the costmap that it was made from"
        );
        let geometry = self.geometry;
        for &cell in changed.iter().filter(|&&cell| geometry.contains(cell)) {
            let index = geometry.index(cell);
            let crossing = self.prices.at(costs, cell);
            if core::mem::replace(&mut self.crossing[index], crossing) != crossing {
                self.review(cell);
            }
        }
    }

    /// Returns the cell that the field leads to.
    #[must_use]
    pub const fn goal(&self) -> Cell {
        self.goal
    }

    /// Returns the price from a cell to the goal, in cells; `None` if no way leads there, it is outside, or
    /// the field is not settled as far.
    #[must_use]
    pub fn price(&self, cell: Cell) -> Option<f64> {
        let known = self.known_at(cell);
        (known != UNREACHED).then(|| f64::from(known) / f64::from(UNIT))
    }

    /// Returns how many cells have been propagated since the field was made, each time that it was: the work
    /// so far.
    #[must_use]
    pub const fn propagated(&self) -> u64 {
        self.propagated
    }

    /// Propagates all changes everywhere.
    pub fn settle(&mut self) {
        self.settle_to(UNREACHED);
    }

    /// Returns the way down from a cell, smooth between the centres of cells. Propagates changes as far as
    /// the way requires.
    ///
    /// # Errors
    /// If the start is outside or closed, the goal is closed, or no way leads to it.
    pub fn route(&mut self, start: Cell) -> Result<Route, PlanError> {
        if !self.geometry.contains(start) {
            return Err(PlanError::StartOutside);
        }
        if self.crossing_at(self.goal) == 0 {
            return Err(PlanError::GoalClosed);
        }
        let index = self.geometry.index(start);
        if self.crossing[index] == 0 {
            return Err(PlanError::StartClosed);
        }
        // The price of the start may rise while the field settles up to it.
        while let Some(&Reverse((least, _))) = self.open.peek() {
            let reach = self.known[index]
                .max(self.due[index])
                .saturating_add(BEYOND_START);
            if least > reach {
                break;
            }
            self.settle_to(reach.min(least.saturating_add(BEYOND_START)));
        }
        if self.known[index] == UNREACHED {
            return Err(PlanError::Unreachable);
        }
        Ok(self.descend(start))
    }

    /// Propagates until no open cell has a price up to this one.
    fn settle_to(&mut self, price: u32) {
        while let Some(&Reverse((least, index))) = self.open.peek() {
            if least > price {
                break;
            }
            self.open.pop();
            let place = index as usize;
            let (known, due) = (self.known[place], self.due[place]);
            if known == due || least != known.min(due) {
                continue;
            }
            self.propagated += 1;
            // A price that rises is withdrawn first, so that no neighbour keeps it alive.
            self.known[place] = if known > due { due } else { UNREACHED };
            if known < due && due != UNREACHED {
                self.open.push(Reverse((due, index)));
            }
            let cell = self.geometry.cell(place);
            for next in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                if let Some(next) = cell.offset(next.0, next.1)
                    && self.geometry.contains(next)
                {
                    self.review(next);
                }
            }
        }
    }

    /// Computes the price that is due in a cell.
    fn review(&mut self, cell: Cell) {
        let index = self.geometry.index(cell);
        let due = match self.crossing[index] {
            0 => UNREACHED,
            _ if cell == self.goal => 0,
            crossing => {
                let at = |dx, dy| cell.offset(dx, dy).map_or(UNREACHED, |next| self.known_at(next));
                arrival(at(-1, 0).min(at(1, 0)), at(0, -1).min(at(0, 1)), crossing)
            }
        };
        if due != self.due[index] {
            self.due[index] = due;
            let known = self.known[index];
            if due != known {
                self.open.push(Reverse((due.min(known), index as u32)));
            }
        }
    }

    fn known_at(&self, cell: Cell) -> u32 {
        if self.geometry.contains(cell) {
            self.known[self.geometry.index(cell)]
        } else {
            UNREACHED
        }
    }

    fn crossing_at(&self, cell: Cell) -> u16 {
        if self.geometry.contains(cell) {
            self.crossing[self.geometry.index(cell)]
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests;
