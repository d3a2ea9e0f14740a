//! What an operator draws on a map, as costs over those of the obstacles: keep-out zones. It changes no
//! obstacle, and costs decay around obstacles alone.

use crate::costmap::{Costmap, INSCRIBED, LETHAL, MAX_PASSABLE, UNKNOWN};
use crate::geometry::{Cell, Geometry};
use crate::route::Point;
use crate::span::{inside, near_segment};

/// What is drawn on a map, in metres in its frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The corners of keep-out zones. A zone is all that its outline goes around.
    pub zones: Vec<Vec<(f64, f64)>>,
    /// How far the centre of the robot must stay away from a zone. No way passes through a zone that is
    /// thinner than a cell, whatever the margin.
    pub margin: f64,
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
    /// Whether a cell is in a zone; empty without zones.
    zones: Vec<bool>,
}

impl Layers {
    /// Returns the costs of a map, `base`, with this drawing.
    #[must_use]
    pub fn new(base: &Costmap, drawing: Drawing) -> Self {
        let mut layers = Self {
            costs: base.clone(),
            drawing: Drawing::default(),
            zones: Vec::new(),
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
        let zones = core::mem::replace(&mut self.zones, closed(&geometry, &drawing));
        self.drawing = drawing;
        let at = |zones: &[bool], index: usize| zones.get(index).copied().unwrap_or(false);
        let differs = |&index: &usize| at(&zones, index) != at(&self.zones, index);
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
        geometry.contains(cell) && self.zones.get(geometry.index(cell)) == Some(&true)
    }

    /// The cost over that of the map.
    fn over(&self, base: u8, index: usize) -> u8 {
        match (base, self.zones.get(index)) {
            (0..=MAX_PASSABLE | UNKNOWN, Some(true)) => INSCRIBED,
            (INSCRIBED | LETHAL, Some(true)) | (_, Some(false) | None) => base,
        }
    }
}

/// Which cells are in zones; empty without zones.
fn closed(geometry: &Geometry, drawing: &Drawing) -> Vec<bool> {
    if drawing.zones.is_empty() {
        return Vec::new();
    }
    // Within half a diagonal of a cell, an outline passes no two cells without closing one of them.
    let radius = (drawing.margin / geometry.resolution()).max(core::f64::consts::FRAC_1_SQRT_2);
    let mut cells = vec![false; geometry.cells()];
    for zone in &drawing.zones {
        let corners: Vec<Point> = zone.iter().map(|&corner| geometry.to_grid(corner)).collect();
        for (row, cells) in cells.chunks_exact_mut(geometry.width() as usize).enumerate() {
            let y = row as f64 + 0.5;
            let edges = corners.iter().zip(corners.iter().cycle().skip(1));
            let near = edges.filter_map(|(&a, &b)| near_segment((a, b), radius, y));
            for part in inside(&corners, y).into_iter().chain(near) {
                centres(cells, part).fill(true);
            }
        }
    }
    cells
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
