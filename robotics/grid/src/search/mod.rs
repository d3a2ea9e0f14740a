//! Plans from a start to a goal: A* on the grid, and Theta* at any angle.
//!
//! A step leads to one of eight neighbours. A diagonal step requires both cells beside it to be open, as in
//! the rules of MovingAI's benchmarks. A way costs its length times the price of the cells that it passes.

use core::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::costmap::Costmap;
use crate::geometry::{Cell, Geometry};
use crate::line::walk;
use crate::price::{Prices, UNIT};
use crate::route::{PlanError, Route, center, check_ends};

/// By how many cells a way must be shorter to replace another. Without it, the last bits of equal ways open
/// cells again and again.
const NEGLIGIBLE: f64 = 1e-6;

/// How ways may run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angles {
    /// Along the eight directions of the grid: A* (Hart, Nilsson and Raphael 1968), the cheapest of them.
    Eight,
    /// At any angle between centres of cells: Theta* (Daniel, Nash, Koenig and Felner, "Theta*: any-angle path
    /// planning on grids", 2010). A cell is opened again when a cheaper way to it appears, and a straight line
    /// is taken only if it costs no more than the step; so the way never costs more than that of A*, except for a millionth
    /// of a cell at each point.
    Any,
}

/// The steps to the eight neighbours.
pub(crate) const STEPS: [(i32, i32); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

/// Returns the way from `start` to `goal`: the cheapest one for [`Angles::Eight`].
///
/// Takes time by the number of cells, and 12 bytes of memory for each.
///
/// # Errors
/// If an end is outside or closed, or no way connects them.
pub fn plan(
    costs: &Costmap,
    prices: &Prices,
    angles: Angles,
    start: Cell,
    goal: Cell,
) -> Result<Route, PlanError> {
    check_ends(costs, prices, start, goal)?;
    let mut search = PathSearch::new(costs, prices, angles, goal);
    search.run(start).ok_or(PlanError::Unreachable)?;
    let cells = search.cells();
    // A cell of the way may have become cheaper to reach after the way continued from it.
    let price = cells.windows(2).filter_map(|pair| search.line(pair[0], pair[1]));
    Ok(Route {
        price: price.sum(),
        points: cells.into_iter().map(center).collect(),
    })
}

struct PathSearch<'a> {
    geometry: &'a Geometry,
    costs: &'a Costmap,
    prices: &'a Prices,
    angles: Angles,
    goal: Cell,
    /// The least known price from the start, in cells.
    known: Vec<f64>,
    /// Where that way comes from; the start comes from itself.
    parents: Vec<u32>,
    open: BinaryHeap<Open>,
}

/// A cell to continue from.
struct Open {
    /// A lower bound of the price from start to goal over this cell.
    total: f64,
    /// The price from the start when it was found.
    known: f64,
    cell: Cell,
}

impl<'a> PathSearch<'a> {
    fn new(costs: &'a Costmap, prices: &'a Prices, angles: Angles, goal: Cell) -> Self {
        let geometry = costs.geometry();
        Self {
            geometry,
            costs,
            prices,
            angles,
            goal,
            known: vec![f64::INFINITY; geometry.cells()],
            parents: vec![0; geometry.cells()],
            open: BinaryHeap::new(),
        }
    }

    /// Searches until the goal is reached; `None` if it cannot be.
    fn run(&mut self, start: Cell) -> Option<()> {
        self.improve(start, start, 0.0);
        while let Some(Open { known, cell, .. }) = self.open.pop() {
            if known > self.known[self.geometry.index(cell)] {
                continue;
            }
            if cell == self.goal {
                return Some(());
            }
            for step in STEPS {
                if let Some(next) = self.neighbour(cell, step) {
                    self.step(cell, next, known);
                }
            }
        }
        None
    }

    /// The cell that a step leads to, if it may be taken.
    fn neighbour(&self, cell: Cell, (dx, dy): (i32, i32)) -> Option<Cell> {
        let open = |dx, dy| {
            cell.offset(dx, dy)
                .filter(|&next| self.prices.at(self.costs, next) > 0)
        };
        let next = open(dx, dy)?;
        let passable = dx == 0 || dy == 0 || (open(dx, 0).is_some() && open(0, dy).is_some());
        passable.then_some(next)
    }

    fn step(&mut self, cell: Cell, next: Cell, known: f64) {
        let mean = f64::from(self.prices.at(self.costs, cell)) + f64::from(self.prices.at(self.costs, next));
        let through = known + cell.distance(next) * mean / f64::from(2 * UNIT);
        match self.angles {
            Angles::Eight => self.improve(cell, next, through),
            Angles::Any => {
                let parent = self
                    .geometry
                    .cell(self.parents[self.geometry.index(cell)] as usize);
                let before = self.known[self.geometry.index(parent)];
                // The straight line costs its length at least, and no way over `cell` is shorter.
                let least = before + parent.distance(next);
                if least >= self.known[self.geometry.index(next)] - NEGLIGIBLE {
                    return;
                }
                let straight = self.line(parent, next);
                match straight.map(|price| before + price) {
                    Some(direct) if direct <= through => self.improve(parent, next, direct),
                    Some(_) | None => self.improve(cell, next, through),
                }
            }
        }
    }

    /// The price of a straight line, if it is open.
    fn line(&self, from: Cell, to: Cell) -> Option<f64> {
        let mut sum = 0.0;
        let open = walk(from, to, |cell, share| {
            let price = self.prices.at(self.costs, cell);
            sum += share * f64::from(price);
            price > 0
        });
        open.then(|| sum / f64::from(UNIT) * from.distance(to))
    }

    fn improve(&mut self, parent: Cell, cell: Cell, known: f64) {
        let index = self.geometry.index(cell);
        if known < self.known[index] - NEGLIGIBLE {
            self.known[index] = known;
            self.parents[index] = self.geometry.index(parent) as u32;
            let total = known + self.angles.least(cell, self.goal);
            self.open.push(Open { total, known, cell });
        }
    }

    /// The corners of the way, from the start to the goal.
    fn cells(&self) -> Vec<Cell> {
        let mut cells = vec![self.goal];
        let mut at = self.geometry.index(self.goal);
        while self.parents[at] as usize != at {
            at = self.parents[at] as usize;
            cells.push(self.geometry.cell(at));
        }
        cells.reverse();
        cells
    }
}

impl Angles {
    /// The least price between two cells, if nothing stood between them.
    fn least(self, from: Cell, to: Cell) -> f64 {
        match self {
            Self::Eight => {
                let (dx, dy) = (from.x.abs_diff(to.x), from.y.abs_diff(to.y));
                f64::from(dx.max(dy)) + (core::f64::consts::SQRT_2 - 1.0) * f64::from(dx.min(dy))
            }
            Self::Any => from.distance(to),
        }
    }
}

/// The greatest is the one with the least total; of equal ones, the one farthest from the start.
impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_total = other.total.total_cmp(&self.total);
        by_total
            .then_with(|| self.known.total_cmp(&other.known))
            .then_with(|| other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

#[cfg(test)]
mod tests;
