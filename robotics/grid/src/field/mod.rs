//! The price to the goal from every cell, kept as the map changes: the navigation function of Konolige ("A
//! gradient method for realtime robot control", 2000), as a wave that propagates at any angle and whose
//! changes are repaired in place (Philippsen and Siegwart, "An interpolated dynamic navigation function",
//! 2005; the repair is that of Ramalingam and Reps, "An incremental algorithm for a generalization of the
//! shortest-path problem", 1996).
//!
//! A repaired field equals a new one to the last bit.

mod descent;
mod queue;
mod wave;

use crate::costmap::{Costmap, LETHAL};
use crate::geometry::{Cell, Geometry};
use crate::price::{Prices, UNIT};
use crate::route::{PlanError, Route, check_ends};
use queue::{Queue, bucket};
use wave::{UNREACHED, arrival};

/// How much farther than the start a field is settled before a descent, in cells of the lowest price: the
/// slope at the start is measured with the cells around it.
const BEYOND_START: u32 = 4 * UNIT;

/// The field of prices to one goal.
#[derive(Clone, Debug)]
pub struct Field {
    geometry: Geometry,
    goal: Cell,
    /// The place of the goal.
    origin: usize,
    prices: Prices,
    /// The costs of the cells row by row, with a border of closed ones, so that every cell has four neighbours.
    costs: Vec<u8>,
    /// Both prices of the places, each as its complement: a place that no wave has reached is zero, and its
    /// memory is not touched.
    complements: Vec<[u32; 2]>,
    /// Places of a row, those of the border included.
    stride: usize,
    /// Where to propagate, by the lower of both prices. Entries in an older bucket are passed over.
    open: Queue,
    /// Cells propagated so far.
    propagated: u64,
}

/// The prices of a cell.
#[derive(Clone, Copy, Debug)]
struct FieldCell {
    /// The price to the goal, as it was last propagated.
    known: u32,
    /// The price to the goal by the neighbours' known prices. Where both differ, the cell is in `open`.
    due: u32,
}

impl FieldCell {
    /// The bucket of a place that is open.
    const fn bucket(&self) -> u32 {
        bucket(if self.known < self.due {
            self.known
        } else {
            self.due
        })
    }
}

impl Field {
    /// Returns the field of a goal, not yet propagated: [`Field::route`] does so as far as necessary, and
    /// [`Field::settle`] everywhere.
    ///
    /// Takes 9 bytes of memory for each cell.
    ///
    /// # Errors
    /// If the goal is outside the map or closed.
    pub fn new(costs: &Costmap, prices: &Prices, goal: Cell) -> Result<Self, PlanError> {
        check_ends(costs, prices, goal, goal)?;
        let geometry = *costs.geometry();
        let width = geometry.width() as usize;
        let stride = width + 2;
        let count = stride * (geometry.height() as usize + 2);
        let mut padded = Vec::with_capacity(count);
        padded.resize(stride, LETHAL);
        for row in costs.costs().chunks_exact(width) {
            padded.push(LETHAL);
            padded.extend_from_slice(row);
            padded.push(LETHAL);
        }
        padded.resize(count, LETHAL);
        let mut field = Self {
            geometry,
            goal,
            origin: 0,
            prices: prices.clone(),
            costs: padded,
            complements: vec![[0; 2]; count],
            stride,
            open: Queue::default(),
            propagated: 0,
        };
        field.origin = field.place(goal);
        field.review(field.origin);
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
            let index = self.place(cell);
            let cost = costs.get(cell);
            let before = core::mem::replace(&mut self.costs[index], cost);
            if self.prices.of(before) != self.prices.of(cost) {
                self.review(index);
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
        self.settle_to(bucket(UNREACHED), u64::MAX);
    }

    /// Propagates at most so many cells of the changes. Returns whether none is left.
    pub fn settle_some(&mut self, most: u64) -> bool {
        self.settle_to(bucket(UNREACHED), self.propagated.saturating_add(most));
        self.open.first().is_none()
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
        let index = self.place(start);
        if self.crossing(index) == 0 {
            return Err(PlanError::StartClosed);
        }
        // The price of the start may rise while the field settles up to it.
        while let Some(first) = self.open.first() {
            let FieldCell { known, due } = self.read(index);
            let reach = bucket(known.max(due).saturating_add(BEYOND_START));
            if first > reach {
                break;
            }
            self.settle_to(reach.min(first + bucket(BEYOND_START)), u64::MAX);
        }
        if self.read(index).known == UNREACHED {
            return Err(PlanError::Unreachable);
        }
        Ok(self.descend(start))
    }

    /// Propagates until no open cell is in a bucket up to this one, or so many cells have been propagated.
    fn settle_to(&mut self, last: u32, most: u64) {
        while self.propagated < most
            && let Some(first) = self.open.first().filter(|&first| first <= last)
            && let Some(index) = self.open.take()
        {
            let index = index as usize;
            let place = self.read(index);
            let FieldCell { known, due } = place;
            if known == due || place.bucket() != first {
                continue;
            }
            self.propagated += 1;
            // A price that rises is withdrawn first, so that no neighbour keeps it alive.
            let known_now = if known > due { due } else { UNREACHED };
            self.write(
                index,
                FieldCell {
                    known: known_now,
                    due,
                },
            );
            if known < due && due != UNREACHED {
                self.open.push(bucket(due), index as u32);
            }
            for next in [index + 1, index + self.stride, index - 1, index - self.stride] {
                // A price follows from lower ones only, before the change and after it.
                if known.min(due) < self.read(next).due {
                    self.review(next);
                }
            }
        }
    }

    /// Computes the price that is due in a place within the border.
    #[inline]
    fn review(&mut self, index: usize) {
        let known = |index: usize| self.read(index).known;
        let place = self.read(index);
        let due = match self.crossing(index) {
            0 => UNREACHED,
            _ if index == self.origin => 0,
            crossing => arrival(
                known(index - 1).min(known(index + 1)),
                known(index - self.stride).min(known(index + self.stride)),
                crossing,
            ),
        };
        if due != place.due {
            let reviewed = FieldCell { due, ..place };
            self.write(index, reviewed);
            let was_open = place.due != place.known && place.bucket() == reviewed.bucket();
            if due != place.known && !was_open {
                self.open.push(reviewed.bucket(), index as u32);
            }
        }
    }

    /// The index of a cell of the grid.
    const fn place(&self, cell: Cell) -> usize {
        (cell.y as usize + 1) * self.stride + cell.x as usize + 1
    }

    #[inline]
    fn read(&self, index: usize) -> FieldCell {
        let [known, due] = self.complements[index].map(|complement| !complement);
        FieldCell { known, due }
    }

    #[inline]
    fn write(&mut self, index: usize, FieldCell { known, due }: FieldCell) {
        self.complements[index] = [!known, !due];
    }

    /// The price of the crossing of a place; 0 if it is closed.
    #[inline]
    fn crossing(&self, index: usize) -> u16 {
        self.prices.of(self.costs[index])
    }

    fn known_at(&self, cell: Cell) -> u32 {
        if self.geometry.contains(cell) {
            self.read(self.place(cell)).known
        } else {
            UNREACHED
        }
    }

    fn crossing_at(&self, cell: Cell) -> u16 {
        if self.geometry.contains(cell) {
            self.crossing(self.place(cell))
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests;
