//! What an operator draws on a map, as costs over those of the obstacles: keep-out zones and preferred lanes. It
//! changes no obstacle, and costs decay around obstacles alone.

mod lanes;

use crate::costmap::{Costmap, INSCRIBED, LETHAL, MAX_PASSABLE, UNKNOWN};
use crate::geometry::{Cell, Geometry};
use crate::route::Point;
use crate::span::{inside, near_segment};
pub use lanes::Lanes;
use lanes::Table;

/// What is drawn on a map, in metres in its frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The corners of keep-out zones. A zone is all that its outline goes around.
    pub zones: Vec<Vec<(f64, f64)>>,
    /// How far the centre of the robot must stay away from a zone. No way passes through a zone that is
    /// thinner than a cell, whatever the margin.
    pub margin: f64,
    /// Preferred lanes. With them, the prices of a way are [`Lanes::prices`].
    pub lanes: Option<Lanes>,
}

/// What the drawing makes of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mark {
    /// The cell is in a zone.
    Closed,
    /// There are lanes, but not here.
    Aside,
    /// The cell is on a lane.
    Lane,
    /// Nothing is drawn here.
    Plain,
}

/// The costs of a map with a drawing on it.
///
/// A cell in a zone costs as one that is too close to an obstacle: it is closed, and [`nearest_open`] leads out
/// of it.
///
/// [`nearest_open`]: crate::nearest_open
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    costs: Costmap,
    drawing: Drawing,
    /// Empty if nothing is drawn.
    marks: Vec<Mark>,
    /// The costs on the lanes and off them, if there are lanes.
    tables: Option<Box<[Table; 2]>>,
}

impl Layers {
    /// Returns the costs of a map, `base`, with this drawing.
    #[must_use]
    pub fn new(base: &Costmap, drawing: Drawing) -> Self {
        let mut layers = Self {
            costs: base.clone(),
            drawing: Drawing::default(),
            marks: Vec::new(),
            tables: None,
        };
        layers.draw(base, drawing);
        layers
    }

    /// Follows the changed cells of the map, and returns the cells whose costs have changed. Equals new layers.
    ///
    /// # Panics
    /// If the map has another geometry.
    pub fn update(&mut self, base: &Costmap, changed: &[Cell]) -> Vec<Cell> {
        let geometry = *self.costs.geometry();
        assert_eq!(base.geometry(), &geometry, "the map that they were made from");
        let mut cells = changed.to_vec();
        cells.retain(|&cell| {
            geometry.contains(cell) && {
                let cost = self.over(base.get(cell), geometry.index(cell));
                self.costs.set(cell, cost)
            }
        });
        cells
    }

    /// Replaces the drawing, and returns the cells whose costs have changed. Equals new layers.
    ///
    /// # Panics
    /// If the map has another geometry.
    pub fn draw(&mut self, base: &Costmap, drawing: Drawing) -> Vec<Cell> {
        if self.drawing == drawing {
            return Vec::new();
        }
        let geometry = *self.costs.geometry();
        let marks = core::mem::replace(&mut self.marks, marks(&geometry, &drawing));
        let both = |lanes: &Lanes| Box::new([lanes.table(0.0), lanes.table(lanes.aside)]);
        let tables = core::mem::replace(&mut self.tables, drawing.lanes.as_ref().map(both));
        self.drawing = drawing;
        let at = |marks: &[Mark], index: usize| marks.get(index).copied().unwrap_or(Mark::Plain);
        let differs = |&index: &usize| tables != self.tables || at(&marks, index) != at(&self.marks, index);
        let changed: Vec<Cell> = (0..geometry.cells())
            .filter(differs)
            .map(|index| geometry.cell(index))
            .collect();
        self.update(base, &changed)
    }

    /// Returns the costs.
    #[must_use]
    pub const fn costs(&self) -> &Costmap {
        &self.costs
    }

    /// Returns the drawing.
    #[must_use]
    pub const fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// Returns whether the centre of the robot is too close to a zone in this cell.
    #[must_use]
    pub fn is_in_zone(&self, cell: Cell) -> bool {
        let geometry = self.costs.geometry();
        geometry.contains(cell) && self.marks.get(geometry.index(cell)) == Some(&Mark::Closed)
    }

    /// The cost over that of the map.
    fn over(&self, base: u8, index: usize) -> u8 {
        let table = |off: usize| {
            self.tables
                .as_ref()
                .map_or(base, |tables| tables[off][usize::from(base)])
        };
        match self.marks.get(index).copied().unwrap_or(Mark::Plain) {
            Mark::Plain => base,
            Mark::Lane => table(0),
            Mark::Aside => table(1),
            Mark::Closed => match base {
                0..=MAX_PASSABLE | UNKNOWN => INSCRIBED,
                INSCRIBED | LETHAL => base,
            },
        }
    }
}

/// What the drawing makes of each cell; empty if nothing is drawn.
fn marks(geometry: &Geometry, drawing: &Drawing) -> Vec<Mark> {
    let lanes = drawing.lanes.as_ref().map_or(&[][..], |lanes| &lanes.lines);
    if drawing.zones.is_empty() && drawing.lanes.is_none() {
        return Vec::new();
    }
    let elsewhere = if drawing.lanes.is_some() {
        Mark::Aside
    } else {
        Mark::Plain
    };
    let mut marks = vec![elsewhere; geometry.cells()];
    let grid =
        |points: &[Point]| -> Vec<Point> { points.iter().map(|&point| geometry.to_grid(point)).collect() };
    // Within half a diagonal of a cell, a line passes no two cells without marking one of them.
    let radius = |metres: f64| (metres / geometry.resolution()).max(core::f64::consts::FRAC_1_SQRT_2);
    for (points, width) in lanes {
        let points = grid(points);
        let legs = || points.windows(2).map(|leg| (leg[0], leg[1]));
        let near = |y| legs().filter_map(move |leg| near_segment(leg, radius(width / 2.0), y));
        fill(geometry, &mut marks, Mark::Lane, |y| near(y).collect());
    }
    for zone in &drawing.zones {
        let corners = grid(zone);
        let edges = || {
            corners
                .iter()
                .copied()
                .zip(corners.iter().copied().cycle().skip(1))
        };
        let near = |y| edges().filter_map(move |edge| near_segment(edge, radius(drawing.margin), y));
        fill(geometry, &mut marks, Mark::Closed, |y| {
            inside(&corners, y).into_iter().chain(near(y)).collect()
        });
    }
    marks
}

/// Marks the cells whose centres are in these parts of their rows.
fn fill(geometry: &Geometry, marks: &mut [Mark], mark: Mark, parts: impl Fn(f64) -> Vec<(f64, f64)>) {
    for (row, cells) in marks.chunks_exact_mut(geometry.width() as usize).enumerate() {
        for part in parts(row as f64 + 0.5) {
            centres(cells, part).fill(mark);
        }
    }
}

/// The cells of a row whose centres are in a part of it.
fn centres<T>(row: &mut [T], (from, to): (f64, f64)) -> &mut [T] {
    let limit = row.len() as f64;
    let first = libm::ceil(from - 0.5).clamp(0.0, limit) as usize;
    let end = libm::floor(to + 0.5).clamp(0.0, limit) as usize;
    &mut row[first..end.max(first)]
}

#[cfg(test)]
mod tests;
