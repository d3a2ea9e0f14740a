//! Coverage of a floor by a round tool: tracks side by side with the contours of what is free, each driven where it is still needed,
//! nearest first (tracks and backtracking after Gonzalez et al., "BSA: a complete coverage algorithm", 2005, and Viet et al., "BA*: an
//! online complete coverage algorithm for cleaning robots", 2013). It knows no robot, and commands nothing.

use crate::costmap::{Costmap, LETHAL};
use crate::distance::squared_distances;
use crate::field::Field;
use crate::geometry::{Cell, Geometry};
use crate::price::Prices;
use crate::route::{PlanError, Point, away};

/// The steps to the eight neighbours of a cell, straight ones first.
const NEIGHBOURS: [(i32, i32); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

/// What distances may lose by rounding, in cells: a cell at the very edge of the tool belongs to it.
const ROUNDING: f64 = 1e-9;

/// A set of cells of a map: what has been covered, or driven along.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSet {
    geometry: Geometry,
    cells: Vec<bool>,
}

impl CellSet {
    /// Returns the empty set.
    #[must_use]
    pub fn none(geometry: Geometry) -> Self {
        Self {
            geometry,
            cells: vec![false; geometry.cells()],
        }
    }

    /// Returns the set of which [`Self::to_bits`] returned these; `None` if they are of a map of another size.
    #[must_use]
    pub fn from_bits(geometry: Geometry, bits: &[u8]) -> Option<Self> {
        let is_in = |index: usize| (bits[index / 8] >> (index % 8)) & 1 == 1;
        (bits.len() == geometry.cells().div_ceil(8)).then(|| Self {
            geometry,
            cells: (0..geometry.cells()).map(is_in).collect(),
        })
    }

    /// Returns a bit for each cell, row by row from the origin, the lowest of a byte first.
    #[must_use]
    pub fn to_bits(&self) -> Vec<u8> {
        let byte = |cells: &[bool]| {
            cells
                .iter()
                .rev()
                .fold(0, |byte, &is_in| (byte << 1) | u8::from(is_in))
        };
        self.cells.chunks(8).map(byte).collect()
    }

    /// Returns size, resolution and origin of its map.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Takes over the size and the origin of a map that has moved or grown. What leaves it is forgotten.
    pub fn follow(&mut self, geometry: Geometry) {
        if self.geometry == geometry {
            return;
        }
        let before = core::mem::replace(self, Self::none(geometry));
        for (index, _) in before.cells.iter().enumerate().filter(|(_, covered)| **covered) {
            let center = before.geometry.center(before.geometry.cell(index));
            if let Some(cell) = geometry.cell_at(center) {
                self.cells[geometry.index(cell)] = true;
            }
        }
    }

    /// Adds the cells whose centre is within `radius` of the line between two places, all in metres.
    pub fn sweep(&mut self, from: (f64, f64), to: (f64, f64), radius: f64) {
        let geometry = self.geometry;
        let (a, b) = (geometry.to_grid(from), geometry.to_grid(to));
        let radius = radius / geometry.resolution() + ROUNDING;
        let side = |low: f64, high: f64, size: u32| {
            let clamp = |at: f64| at.clamp(0.0, f64::from(size)) as u32;
            clamp(low - radius)..clamp(high + radius + 1.0)
        };
        for y in side(a.1.min(b.1), a.1.max(b.1), geometry.height()) {
            for x in side(a.0.min(b.0), a.0.max(b.0), geometry.width()) {
                if away((f64::from(x) + 0.5, f64::from(y) + 0.5), a, b) <= radius {
                    self.cells[geometry.index(Cell::new(x, y))] = true;
                }
            }
        }
    }

    /// Removes all cells.
    pub fn clear(&mut self) {
        self.cells.fill(false);
    }

    /// Returns the centres of its cells in metres; of more than `most`, an even selection.
    pub fn places(&self, most: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let cells = self.cells.iter().enumerate().filter(|(_, covered)| **covered);
        let step = cells.clone().count().div_ceil(most.max(1)).max(1);
        cells
            .step_by(step)
            .map(|(index, _)| self.geometry.center(self.geometry.cell(index)))
    }

    fn at(&self, cell: Cell) -> bool {
        self.cells[self.geometry.index(cell)]
    }
}

/// The floor that a robot can cover from where it is.
pub struct Floor {
    geometry: Geometry,
    field: Field,
    /// The cells that the tool reaches.
    cells: Vec<bool>,
    /// The cells of the tracks, and those of the contours.
    lines: Vec<CoverageLine>,
    /// The radius of the tool, in cells.
    radius: f64,
}

/// What a cell is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CoverageLine {
    /// Nothing that is driven along.
    None,
    /// A track.
    Track,
    /// A contour: beside it the robot cannot be.
    Contour,
}

/// The next part of a floor to drive along.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The way to its first cell, in columns and rows.
    pub way: Vec<Point>,
    /// Its cells, one beside the other.
    pub cells: Vec<Cell>,
}

impl Floor {
    /// Returns the floor around a robot whose tool has this radius, with tracks at this distance; both in cells. The robot is at
    /// `start`, and can be where the costs have a price.
    ///
    /// Takes a field of the whole map.
    ///
    /// # Errors
    /// If the start is outside or closed.
    pub fn new(
        costs: &Costmap,
        prices: &Prices,
        start: Cell,
        radius: f64,
        distance: u32,
    ) -> Result<Self, PlanError> {
        let mut field = Field::new(costs, prices, start)?;
        field.settle();
        let geometry = *costs.geometry();
        let is_open: Vec<bool> = (0..geometry.cells())
            .map(|index| field.price(geometry.cell(index)).is_some())
            .collect();
        let squares = squared_distances(geometry.width() as usize, &is_open);
        let reach = radius * radius;
        let cells = squares
            .iter()
            .enumerate()
            .map(|(index, &square)| f64::from(square) <= reach && costs.get(geometry.cell(index)) != LETHAL);
        let open = |cell: Option<Cell>| {
            cell.is_some_and(|cell| geometry.contains(cell) && is_open[geometry.index(cell)])
        };
        // The fewer tracks there are, the fewer turns: they lead along the longer runs.
        let begins = |dx: i32, dy: i32| {
            let begins = |index: &usize| is_open[*index] && !open(geometry.cell(*index).offset(dx, dy));
            (0..geometry.cells()).filter(begins).count()
        };
        let is_along_rows = begins(-1, 0) <= begins(0, -1);
        let line = |index: usize| {
            let cell = geometry.cell(index);
            let across = if is_along_rows { cell.y } else { cell.x };
            if !is_open[index] {
                CoverageLine::None
            } else if NEIGHBOURS.iter().any(|&(x, y)| !open(cell.offset(x, y))) {
                CoverageLine::Contour
            } else if across % distance.max(1) == 0 {
                CoverageLine::Track
            } else {
                CoverageLine::None
            }
        };
        Ok(Self {
            geometry,
            cells: cells.collect(),
            lines: (0..geometry.cells()).map(line).collect(),
            field,
            radius,
        })
    }

    /// Returns size, resolution and origin of its map.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns how many cells of the floor are covered, and how many there are; `None` if the map of `covered` is another one.
    #[must_use]
    pub fn share(&self, covered: &CellSet) -> Option<(usize, usize)> {
        let floor = self.cells.iter().zip(&covered.cells).filter(|(floor, _)| **floor);
        let done = floor.clone().filter(|(_, covered)| **covered).count();
        (covered.geometry == self.geometry).then(|| (done, floor.count()))
    }

    /// Returns the next stroke: along the nearest line by way from which the tool covers at least `least` cells more, without the
    /// cells that are `done`. `None` when there is none.
    ///
    /// # Panics
    /// If `covered` or `done` has another geometry.
    #[must_use]
    pub fn next(&mut self, covered: &CellSet, done: &CellSet, least: usize) -> Option<Stroke> {
        for cells in [covered, done] {
            assert_eq!(cells.geometry, self.geometry, "the map of the floor");
        }
        let is_needed: Vec<bool> = (0..self.lines.len())
            .map(|index| {
                let is_open = self.lines[index] != CoverageLine::None && !done.cells[index];
                is_open && self.gain(covered, self.geometry.cell(index), least) >= least
            })
            .collect();
        let price = |index: usize| self.field.price(self.geometry.cell(index));
        let first = (0..is_needed.len())
            .filter(|&index| is_needed[index])
            .filter_map(|index| Some((price(index)?, index)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, index)| self.geometry.cell(index))?;
        let cells = self.stroke(first, &is_needed);
        let mut way = self.field.route(*cells.first()?).ok()?.points;
        way.reverse();
        Some(Stroke { way, cells })
    }

    /// The line through a cell, as far as it is needed, from the end of it that is nearer by way.
    fn stroke(&self, first: Cell, is_needed: &[bool]) -> Vec<Cell> {
        let mut taken = vec![false; is_needed.len()];
        taken[self.geometry.index(first)] = true;
        let line = self.lines[self.geometry.index(first)];
        let mut extend = |from: Cell| {
            let mut cells = Vec::new();
            let mut at = from;
            loop {
                let next = NEIGHBOURS
                    .iter()
                    .filter_map(|&(x, y)| at.offset(x, y))
                    .find(|&next| {
                        let is_inside = self.geometry.contains(next);
                        let index = if is_inside {
                            self.geometry.index(next)
                        } else {
                            return false;
                        };
                        self.lines[index] == line && is_needed[index] && !taken[index]
                    });
                let Some(next) = next else { return cells };
                taken[self.geometry.index(next)] = true;
                cells.push(next);
                at = next;
            }
        };
        let (ahead, back) = (extend(first), extend(first));
        let mut cells: Vec<Cell> = back.into_iter().rev().chain([first]).chain(ahead).collect();
        let price = |cell: Option<&Cell>| {
            cell.and_then(|&cell| self.field.price(cell))
                .unwrap_or(f64::INFINITY)
        };
        if price(cells.last()) < price(cells.first()) {
            cells.reverse();
        }
        cells
    }

    /// How many cells of the floor the tool would cover at a cell, up to `most`.
    fn gain(&self, covered: &CellSet, cell: Cell, most: usize) -> usize {
        let reach = self.radius as i32;
        let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
        square
            .filter(|&(x, y)| f64::from(x * x + y * y) <= self.radius * self.radius)
            .filter_map(|(x, y)| cell.offset(x, y))
            .filter(|&at| self.geometry.contains(at))
            .filter(|&at| self.cells[self.geometry.index(at)] && !covered.at(at))
            .take(most)
            .count()
    }
}

#[cfg(test)]
mod tests;
