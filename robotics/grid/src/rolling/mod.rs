//! A grid that moves with the robot and remembers what its laser saw: rays make cells free, and their ends
//! make cells occupied (Moravec and Elfes, "High resolution maps from wide angle sonar", 1985; the numbers are
//! those of Hornung et al., "OctoMap", 2013).
//!
//! It corrects no pose: where the odometry drifts, old cells drift with it, and so they must age.

use core::ops::Range;
use core::time::Duration;

use crate::geometry::{Cell, Geometry, GeometryError};
use crate::line::walk_places;
use crate::occupancy::Occupancy;

/// What the end of a ray adds to the logarithm of the odds: a probability of 0.7.
const HIT: f32 = 0.85;
/// What a ray adds that passes through: a probability of 0.4.
const PASS: f32 = -0.4;
/// The limits of the sum, so that a cell that changes is believed after a few scans.
const LIMITS: (f32, f32) = (-2.0, 3.5);

/// Cells of which a map is written at once.
const CHUNK: usize = 32;

/// A ray from the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it ends, in metres in the frame of the robot's pose.
    pub end: (f64, f64),
    /// Whether it ends at an obstacle; otherwise it was free as far as that.
    pub hit: bool,
}

/// What the rays have shown, cell by cell. Where no ray was, its memory is zero and not touched.
#[derive(Clone, Debug)]
struct Evidence {
    /// Logarithm of the odds of an obstacle; 0 if nothing was seen.
    odds: Vec<f32>,
    /// The last scan that a ray of touched it.
    scan: Vec<u32>,
    /// When that was, ns.
    seen: Vec<u64>,
}

impl Evidence {
    fn none(cells: usize) -> Self {
        Self {
            odds: vec![0.0; cells],
            scan: vec![0; cells],
            seen: vec![0; cells],
        }
    }

    /// Adds to a cell, once in a scan.
    #[inline]
    fn add(&mut self, place: usize, odds: f32, scan: u32, now: u64) {
        if self.scan[place] != scan {
            self.odds[place] = (self.odds[place] + odds).clamp(LIMITS.0, LIMITS.1);
            (self.scan[place], self.seen[place]) = (scan, now);
        }
    }
}

/// A square grid around the robot.
#[derive(Clone, Debug)]
pub struct RollingGrid {
    geometry: Geometry,
    /// The column and row of the first cell, counted from the zero of the frame. So a cell keeps its place in
    /// the world when the grid moves.
    corner: (i64, i64),
    evidence: Evidence,
    scans: u32,
    /// Memory for the ends of the rays of one scan.
    ends: Vec<(Cell, bool)>,
}

impl RollingGrid {
    /// Returns an unknown grid of `side` × `side` cells around the zero of the frame.
    ///
    /// # Errors
    /// If there are no or too many cells, or the resolution in metres is out of range.
    pub fn new(side: u32, resolution: f64) -> Result<Self, GeometryError> {
        Self::around((0.0, 0.0), side, resolution)
    }

    /// Returns an unknown grid of `side` × `side` cells around a place.
    ///
    /// # Errors
    /// As [`RollingGrid::new`], or if the place is not finite or too far from zero.
    pub fn around(middle: (f64, f64), side: u32, resolution: f64) -> Result<Self, GeometryError> {
        let (geometry, corner) = placed(middle, side, resolution)?;
        Ok(Self {
            geometry,
            corner,
            evidence: Evidence::none(side as usize * side as usize),
            scans: 0,
            ends: Vec::new(),
        })
    }

    /// Returns size, resolution and present origin; the axes are those of the frame.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Moves the grid so that the robot is in its middle, if it is more than a quarter of a side away from
    /// there. What leaves the grid is forgotten.
    ///
    /// # Errors
    /// If the place is not finite or too far from zero; the grid stays.
    pub fn follow(&mut self, robot: (f64, f64)) -> Result<(), GeometryError> {
        let (side, resolution) = (self.geometry.width(), self.geometry.resolution());
        let (column, row) = self.geometry.to_grid(robot);
        let is_near = |at: f64| (at - f64::from(side) / 2.0).abs() <= f64::from(side) / 4.0;
        if is_near(column) && is_near(row) {
            return Ok(());
        }
        let (geometry, moved_to) = placed(robot, side, resolution)?;
        self.geometry = geometry;
        let shift = (moved_to.0 - self.corner.0, moved_to.1 - self.corner.1);
        let before = core::mem::replace(&mut self.evidence, Evidence::none(self.geometry.cells()));
        for (index, &odds) in before.odds.iter().enumerate().filter(|(_, odds)| **odds != 0.0) {
            let cell = self.geometry.cell(index);
            let at = |from: u32, by: i64| u32::try_from(i64::from(from) - by).unwrap_or(u32::MAX);
            let moved = Cell::new(at(cell.x, shift.0), at(cell.y, shift.1));
            if self.geometry.contains(moved) {
                let moved = self.geometry.index(moved);
                self.evidence.odds[moved] = odds;
                self.evidence.scan[moved] = before.scan[index];
                self.evidence.seen[moved] = before.seen[index];
            }
        }
        self.corner = moved_to;
        Ok(())
    }

    /// Adds the rays of one scan from this place. A cell counts once in a scan, and as occupied if any ray
    /// ends in it. Rays are cut at the edge of the grid; rays with an end that is not finite are left out, and
    /// all are if the sensor is outside the grid.
    pub fn observe(&mut self, sensor: (f64, f64), rays: impl IntoIterator<Item = Ray>, now: Duration) {
        let Some(from) = self.geometry.cell_at(sensor) else {
            return;
        };
        let mut ends = core::mem::take(&mut self.ends);
        ends.clear();
        let end = |ray: Ray| self.end(sensor, &ray).map(|(cell, hit)| (cell, hit && ray.hit));
        ends.extend(rays.into_iter().filter_map(end));
        self.ends = ends;
        self.trace(from, nanoseconds(now));
    }

    /// Adds the rays from a cell to the ends that are kept.
    fn trace(&mut self, from: Cell, now: u64) {
        self.scans += 1;
        for &(end, _) in self.ends.iter().filter(|(_, hit)| *hit) {
            self.evidence.add(self.geometry.index(end), HIT, self.scans, now);
        }
        // Beside each other, many rays end in one cell. The second passes the cells of the first, which count once.
        for same in self.ends.chunk_by(|(a, _), (b, _)| a == b) {
            walk_places(&self.geometry, from, same[0].0, |place| {
                self.evidence.add(place, PASS, self.scans, now);
            });
        }
    }

    /// Makes the unknown cells free whose center is in a place, within `radius` of `middle`.
    pub fn assume_free(&mut self, middle: (f64, f64), radius: f64, is_in_place: impl Fn((f64, f64)) -> bool) {
        for cell in self.cells_within(middle, radius) {
            let odds = &mut self.evidence.odds[self.geometry.index(cell)];
            if *odds == 0.0 && is_in_place(self.geometry.center(cell)) {
                *odds = PASS;
            }
        }
    }

    /// Makes the occupied cells unknown whose center is within `radius` of `middle`.
    pub fn clear(&mut self, middle: (f64, f64), radius: f64) {
        for cell in self.cells_within(middle, radius) {
            let (at_x, at_y) = self.geometry.center(cell);
            let odds = &mut self.evidence.odds[self.geometry.index(cell)];
            if *odds > 0.0 && libm::hypot(at_x - middle.0, at_y - middle.1) <= radius {
                *odds = 0.0;
            }
        }
    }

    /// Returns the centers of the cells around the free ones in a square of half the side `radius`: those that are
    /// occupied or unknown and have a free neighbour. Those in which a ray of the newest scan ended are left
    /// out: the scan is more exact.
    #[must_use]
    pub fn boundary(&self, middle: (f64, f64), radius: f64) -> Vec<(f64, f64)> {
        let side = self.geometry.width();
        let inner = |range: Range<u32>| range.start.max(1)..range.end.min(side.saturating_sub(1));
        let (columns, rows) = self.window(middle, radius);
        let (columns, rows) = (inner(columns), inner(rows));
        let mut is_boundary = vec![false; columns.len()];
        let mut found = Vec::new();
        for y in rows {
            let first = self.geometry.index(Cell::new(columns.start, y));
            mark_boundary(&self.evidence.odds, first, side as usize, &mut is_boundary);
            // Most eights have none.
            for (eight, start) in is_boundary.chunks(8).zip((0..).step_by(8)) {
                if !eight.iter().fold(false, |any, is_boundary| any | is_boundary) {
                    continue;
                }
                for (column, _) in (start..).zip(eight).filter(|(_, is_boundary)| **is_boundary) {
                    let index = first + column as usize;
                    let is_newest =
                        self.evidence.odds[index] > 0.0 && self.evidence.scan[index] == self.scans;
                    if !is_newest {
                        found.push(self.geometry.center(Cell::new(columns.start + column, y)));
                    }
                }
            }
        }
        found
    }

    /// Returns the centers of the occupied cells in a square of half the side `radius`. Those in which a ray of
    /// the newest scan ended are left out, since the scan is more exact, and those that no ray has touched for
    /// longer than `age`.
    pub fn remembered(
        &self,
        middle: (f64, f64),
        radius: f64,
        now: Duration,
        age: Duration,
    ) -> impl Iterator<Item = (f64, f64)> + '_ {
        let oldest = nanoseconds(now.saturating_sub(age));
        self.cells_within(middle, radius).filter_map(move |cell| {
            let index = self.geometry.index(cell);
            let is_remembered = self.evidence.odds[index] > 0.0
                && self.evidence.scan[index] != self.scans
                && self.evidence.seen[index] >= oldest;
            is_remembered.then(|| self.geometry.center(cell))
        })
    }

    /// The cells in a square of half the side `radius`, row by row.
    fn cells_within(&self, middle: (f64, f64), radius: f64) -> impl Iterator<Item = Cell> + use<> {
        let (columns, rows) = self.window(middle, radius);
        rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)))
    }

    /// The columns and the rows of a square of half the side `radius`.
    fn window(&self, middle: (f64, f64), radius: f64) -> (Range<u32>, Range<u32>) {
        let cells = radius / self.geometry.resolution();
        let (column, row) = self.geometry.to_grid(middle);
        let side = f64::from(self.geometry.width());
        let range =
            |at: f64| (at - cells).clamp(0.0, side) as u32..(at + cells + 1.0).clamp(0.0, side) as u32;
        (range(column), range(row))
    }

    /// Writes the numbers of `nav_msgs/OccupancyGrid`, row by row from the origin. Cells that no ray has
    /// touched for longer than `age` are unknown.
    ///
    /// # Panics
    /// If `data` has not as many numbers as the grid cells.
    pub fn write_ros(&self, now: Duration, age: Duration, data: &mut [i8]) {
        let odds = &self.evidence.odds;
        assert_eq!(data.len(), odds.len(), "a number for each cell");
        let oldest = nanoseconds(now.saturating_sub(age));
        let chunks = data.chunks_mut(CHUNK).zip(odds.chunks(CHUNK));
        for ((numbers, odds), seen) in chunks.zip(self.evidence.seen.chunks(CHUNK)) {
            // Most of a large grid is unknown.
            if odds.iter().fold(0, |any, odds| any | odds.to_bits()) == 0 {
                numbers.fill(Occupancy::Unknown.to_ros());
                continue;
            }
            for ((number, &odds), &seen) in numbers.iter_mut().zip(odds).zip(seen) {
                let state = if odds == 0.0 || seen < oldest {
                    Occupancy::Unknown
                } else if odds > 0.0 {
                    Occupancy::Occupied
                } else {
                    Occupancy::Free
                };
                *number = state.to_ros();
            }
        }
    }

    /// The cell where a ray ends, and whether that is the end of the whole ray.
    fn end(&self, sensor: (f64, f64), ray: &Ray) -> Option<(Cell, bool)> {
        if !(ray.end.0.is_finite() && ray.end.1.is_finite()) {
            return None;
        }
        if let Some(cell) = self.geometry.cell_at(ray.end) {
            return Some((cell, true));
        }
        let ((x, y), (to_x, to_y)) = (self.geometry.to_grid(sensor), self.geometry.to_grid(ray.end));
        let last = f64::from(self.geometry.width()) - 0.5;
        // The share of the ray up to the middle of the outermost cells.
        let share = |at: f64, to: f64| {
            let edge = if to > last { last } else { 0.5 };
            let leaves = to > last || to < 0.5;
            if leaves {
                ((edge - at) / (to - at)).clamp(0.0, 1.0)
            } else {
                1.0
            }
        };
        let cut = share(x, to_x).min(share(y, to_y));
        let edge = |at: f64, to: f64| (at + cut * (to - at)).clamp(0.5, last) as u32;
        Some((Cell::new(edge(x, to_x), edge(y, to_y)), false))
    }
}

/// Marks the cells of a part of a row, from `first` on, that are not free and have a free neighbour. The part is within the
/// border of a grid of `side` columns.
fn mark_boundary(odds: &[f32], first: usize, side: usize, is_boundary: &mut [bool]) {
    let part = |first: usize| &odds[first..][..is_boundary.len()];
    let (here, left, right) = (part(first), part(first - 1), part(first + 1));
    let (below, above) = (part(first - side), part(first + side));
    // Without a branch, so that the compiler uses the vector unit.
    for (column, is_boundary) in is_boundary.iter_mut().enumerate() {
        let has_free_neighbour =
            (left[column] < 0.0) | (right[column] < 0.0) | (below[column] < 0.0) | (above[column] < 0.0);
        *is_boundary = (here[column] >= 0.0) & has_free_neighbour;
    }
}

/// The time in ns; it has room for 584 years.
fn nanoseconds(time: Duration) -> u64 {
    time.as_nanos() as u64
}

/// The geometry, and the column and row of its first cell, counted from the zero of the frame.
fn placed((x, y): (f64, f64), side: u32, resolution: f64) -> Result<(Geometry, (i64, i64)), GeometryError> {
    // A place that is not finite, or too far, has no corner that a geometry accepts.
    let corner = |at: f64| libm::floor(at / resolution) - f64::from(side / 2);
    let (column, row) = (corner(x), corner(y));
    let geometry = Geometry::new(
        side,
        side,
        resolution,
        (column * resolution, row * resolution, 0.0),
    );
    geometry.map(|geometry| (geometry, (column as i64, row as i64)))
}

#[cfg(test)]
mod tests;
