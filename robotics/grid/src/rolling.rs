//! A grid that moves with the robot and remembers what its laser saw: rays make cells free, and their ends
//! make cells occupied (Moravec and Elfes, "High resolution maps from wide angle sonar", 1985; the numbers are
//! those of Hornung et al., "OctoMap", 2013).
//!
//! It corrects no pose: where the odometry drifts, old cells drift with it, and so they must age.

use core::time::Duration;

use crate::geometry::{Cell, Geometry, GeometryError};
use crate::line::walk;
use crate::occupancy::Occupancy;

/// What the end of a ray adds to the logarithm of the odds: a probability of 0.7.
const HIT: f32 = 0.85;
/// What a ray adds that passes through: a probability of 0.4.
const PASS: f32 = -0.4;
/// The limits of the sum, so that a cell that changes is believed after a few scans.
const LIMITS: (f32, f32) = (-2.0, 3.5);

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
        self.scans += 1;
        let mut ends = core::mem::take(&mut self.ends);
        ends.clear();
        let end = |ray: Ray| self.end(sensor, &ray).map(|(cell, hit)| (cell, hit && ray.hit));
        ends.extend(rays.into_iter().filter_map(end));
        for &(end, _) in ends.iter().filter(|(_, hit)| *hit) {
            self.add(end, HIT, now);
        }
        for &(end, _) in &ends {
            walk(from, end, |cell, _| {
                self.add(cell, PASS, now);
                true
            });
        }
        self.ends = ends;
    }

    /// Makes the unknown cells free whose center is in a place, within `radius` of `middle`.
    pub fn assume_free(&mut self, middle: (f64, f64), radius: f64, is_in_place: impl Fn((f64, f64)) -> bool) {
        for (x, y) in self.cells_within(middle, radius) {
            let cell = Cell::new(x, y);
            if is_in_place(self.geometry.center(cell)) {
                let odds = &mut self.evidence.odds[self.geometry.index(cell)];
                if *odds == 0.0 {
                    *odds = PASS;
                }
            }
        }
    }

    /// Makes the occupied cells unknown whose center is within `radius` of `middle`.
    pub fn clear(&mut self, middle: (f64, f64), radius: f64) {
        for (x, y) in self.cells_within(middle, radius) {
            let cell = Cell::new(x, y);
            let (at_x, at_y) = self.geometry.center(cell);
            let odds = &mut self.evidence.odds[self.geometry.index(cell)];
            if *odds > 0.0 && (at_x - middle.0).hypot(at_y - middle.1) <= radius {
                *odds = 0.0;
            }
        }
    }

    /// Returns the centers of the cells around the free ones in a square of half the side `radius`: those that are
    /// occupied or unknown and have a free neighbour. Those in which a ray of the newest scan ended are left
    /// out: the scan is more exact.
    pub fn boundary(&self, middle: (f64, f64), radius: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let side = self.geometry.width() as usize;
        self.cells_within(middle, radius).filter_map(move |(x, y)| {
            let cell = Cell::new(x, y);
            let index = self.geometry.index(cell);
            let odds = &self.evidence.odds;
            if odds[index] < 0.0 || (odds[index] > 0.0 && self.evidence.scan[index] == self.scans) {
                return None;
            }
            let is_inner = |at: u32| at > 0 && (at as usize) < side - 1;
            let neighbours = || [index - 1, index + 1, index - side, index + side];
            let has_free_neighbour = || neighbours().iter().any(|&neighbour| odds[neighbour] < 0.0);
            let is_boundary = is_inner(x) && is_inner(y) && has_free_neighbour();
            is_boundary.then(|| self.geometry.center(cell))
        })
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
        self.cells_within(middle, radius).filter_map(move |(x, y)| {
            let cell = Cell::new(x, y);
            let index = self.geometry.index(cell);
            let is_remembered = self.evidence.odds[index] > 0.0
                && self.evidence.scan[index] != self.scans
                && self.evidence.seen[index] >= oldest;
            is_remembered.then(|| self.geometry.center(cell))
        })
    }

    /// The columns and rows of the cells in a square of half the side `radius`.
    fn cells_within(&self, middle: (f64, f64), radius: f64) -> impl Iterator<Item = (u32, u32)> + use<> {
        let cells = radius / self.geometry.resolution();
        let (column, row) = self.geometry.to_grid(middle);
        let side = f64::from(self.geometry.width());
        let range =
            move |at: f64| (at - cells).clamp(0.0, side) as u32..(at + cells + 1.0).clamp(0.0, side) as u32;
        range(row).flat_map(move |y| range(column).map(move |x| (x, y)))
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
        for ((number, &odds), index) in data.iter_mut().zip(odds).zip(0..) {
            // Most cells of a large grid are unknown.
            let state = if odds == 0.0 || self.evidence.seen[index] < oldest {
                Occupancy::Unknown
            } else if odds > 0.0 {
                Occupancy::Occupied
            } else {
                Occupancy::Free
            };
            *number = state.to_ros();
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

    fn add(&mut self, cell: Cell, odds: f32, now: Duration) {
        let index = self.geometry.index(cell);
        let of = &mut self.evidence;
        if of.scan[index] != self.scans {
            of.odds[index] = (of.odds[index] + odds).clamp(LIMITS.0, LIMITS.1);
            (of.scan[index], of.seen[index]) = (self.scans, nanoseconds(now));
        }
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
mod tests {
    use proptest::prelude::*;

    use super::*;

    const AGE: Duration = Duration::from_secs(10);

    fn at(grid: &RollingGrid, point: (f64, f64), now: Duration) -> Occupancy {
        let mut data = vec![0; grid.geometry().cells()];
        grid.write_ros(now, AGE, &mut data);
        let cell = grid.geometry().cell_at(point);
        cell.map_or(Occupancy::Unknown, |cell| {
            Occupancy::from_ros(data[grid.geometry().index(cell)])
        })
    }

    fn grid() -> RollingGrid {
        RollingGrid::new(40, 0.1).expect("valid")
    }

    #[test]
    fn a_ray_makes_its_cells_free_and_its_end_occupied() {
        let mut grid = grid();
        let ray = Ray {
            end: (1.05, 0.05),
            hit: true,
        };
        grid.observe((0.05, 0.05), [ray], Duration::ZERO);
        for (point, state) in [
            ((0.05, 0.05), Occupancy::Free),
            ((0.95, 0.05), Occupancy::Free),
            ((1.05, 0.05), Occupancy::Occupied),
            ((1.15, 0.05), Occupancy::Unknown),
        ] {
            assert_eq!(at(&grid, point, Duration::ZERO), state, "{point:?}");
        }
    }

    #[test]
    fn an_obstacle_that_goes_is_cleared_and_what_is_not_seen_ages() {
        let mut grid = grid();
        let scan = |grid: &mut RollingGrid, hit, second| {
            let end = if hit { (1.05, 0.05) } else { (1.55, 0.05) };
            grid.observe((0.05, 0.05), [Ray { end, hit }], Duration::from_secs(second));
        };
        (0..5).for_each(|second| scan(&mut grid, true, second));
        (5..15).for_each(|second| scan(&mut grid, false, second));
        assert_eq!(at(&grid, (1.05, 0.05), Duration::from_secs(14)), Occupancy::Free);
        assert_eq!(at(&grid, (1.05, 0.05), Duration::from_secs(24)), Occupancy::Free);
        assert_eq!(
            at(&grid, (1.05, 0.05), Duration::from_secs(25)),
            Occupancy::Unknown
        );
    }

    #[test]
    fn a_wall_along_a_ray_stays() {
        let mut grid = grid();
        let rays = [
            Ray {
                end: (1.05, 0.05),
                hit: true,
            },
            Ray {
                end: (1.55, 0.08),
                hit: true,
            },
        ];
        grid.observe((0.05, 0.05), rays, Duration::ZERO);
        assert_eq!(at(&grid, (1.05, 0.05), Duration::ZERO), Occupancy::Occupied);
    }

    #[test]
    fn cells_keep_their_place_when_the_grid_moves_and_are_forgotten_outside() {
        let mut grid = grid();
        let now = Duration::ZERO;
        grid.observe(
            (0.05, 0.05),
            [Ray {
                end: (1.05, 0.05),
                hit: true,
            }],
            now,
        );
        grid.follow((1.53, 0.2)).expect("a place");
        assert_eq!(at(&grid, (1.05, 0.05), now), Occupancy::Occupied);
        assert_eq!(at(&grid, (0.55, 0.05), now), Occupancy::Free);
        grid.follow((100.0, -50.0)).expect("a place");
        grid.follow((0.0, 0.0)).expect("a place");
        assert_eq!(at(&grid, (1.05, 0.05), now), Occupancy::Unknown);
    }

    #[test]
    fn the_boundary_is_what_is_occupied_or_unknown_beside_free_cells() {
        let mut grid = grid();
        let ray = Ray {
            end: (1.05, 0.05),
            hit: true,
        };
        grid.observe((0.05, 0.05), [ray], Duration::ZERO);
        let has = |grid: &RollingGrid, (x, y): (f64, f64)| {
            grid.boundary((0.55, 0.05), 1.0)
                .any(|at| (at.0 - x).abs() < 1e-6 && (at.1 - y).abs() < 1e-6)
        };
        assert!(has(&grid, (0.55, 0.15)), "unknown beside the ray");
        assert!(!has(&grid, (1.05, 0.05)), "the newest scan knows better");
        grid.observe((0.05, 0.05), [], Duration::ZERO);
        assert!(has(&grid, (1.05, 0.05)), "seen earlier");
        grid.assume_free((0.55, 0.05), 0.15, |_| true);
        assert!(!has(&grid, (0.55, 0.15)));
        grid.assume_free((1.05, 0.05), 0.3, |_| true);
        assert!(has(&grid, (1.05, 0.05)), "what was seen is not assumed away");
        grid.assume_free((-1e9, f64::NAN), 1e9, |_| false);
    }

    #[test]
    fn what_went_out_of_sight_is_remembered_for_a_time() {
        let mut grid = grid();
        let ray = |end, hit| Ray { end, hit };
        let at = |grid: &RollingGrid, second| {
            let now = Duration::from_secs(second);
            grid.remembered((0.5, 0.0), 1.0, now, AGE).collect::<Vec<_>>()
        };
        grid.observe((0.05, 0.05), [ray((1.05, 0.05), true)], Duration::ZERO);
        assert_eq!(at(&grid, 0), [], "the newest scan knows better");
        grid.observe((0.05, 0.05), [ray((0.05, 1.05), false)], Duration::from_secs(1));
        let [(x, y)] = at(&grid, 10)[..] else {
            panic!("one cell")
        };
        assert!((x - 1.05).abs() < 1e-9 && (y - 0.05).abs() < 1e-9);
        assert_eq!(at(&grid, 11), []);
        (2..4).for_each(|second| {
            let through = [ray((1.55, 0.05), false)];
            grid.observe((0.05, 0.05), through, Duration::from_secs(second));
        });
        grid.observe((0.05, 0.05), [ray((1.55, 0.05), false)], Duration::from_secs(4));
        assert_eq!(at(&grid, 4), [], "rays pass through it");
    }

    #[test]
    fn what_is_cleared_is_unknown_until_it_is_seen_again() {
        let mut grid = grid();
        let (now, end) = (Duration::ZERO, (1.05, 0.05));
        grid.observe((0.05, 0.05), [Ray { end, hit: true }], now);
        for (place, state) in [
            ((0.05, 0.05), Occupancy::Occupied),
            ((f64::NAN, 0.0), Occupancy::Occupied),
            ((0.55, 0.05), Occupancy::Unknown),
        ] {
            grid.clear(place, 0.6);
            assert_eq!(at(&grid, end, now), state, "{place:?}");
        }
        assert_eq!(at(&grid, (0.55, 0.05), now), Occupancy::Free);
        grid.observe((0.05, 0.05), [Ray { end, hit: true }], now);
        assert_eq!(at(&grid, end, now), Occupancy::Occupied);
    }

    #[test]
    fn places_and_rays_that_are_not_finite_change_nothing() {
        let mut grid = grid();
        let before = *grid.geometry();
        for place in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (1e300, 0.0)] {
            assert!(grid.follow(place).is_err(), "{place:?}");
            grid.observe(
                place,
                [Ray {
                    end: (0.0, 0.0),
                    hit: true,
                }],
                Duration::ZERO,
            );
        }
        grid.observe(
            (0.0, 0.0),
            [Ray {
                end: (f64::NAN, 0.0),
                hit: true,
            }],
            Duration::ZERO,
        );
        assert_eq!(*grid.geometry(), before);
        assert_eq!(at(&grid, (0.0, 0.0), Duration::ZERO), Occupancy::Unknown);
        assert!(RollingGrid::new(0, 0.1).is_err());
    }

    proptest! {
        #[test]
        fn rays_that_leave_the_grid_are_cut_and_mark_nothing(angle in -3.2..3.2f64, length in 3.0..1e6f64) {
            let mut grid = grid();
            let end = (length * angle.cos(), length * angle.sin());
            grid.observe((0.05, 0.05), [Ray { end, hit: true }], Duration::ZERO);
            let mut data = vec![0; grid.geometry().cells()];
            grid.write_ros(Duration::ZERO, AGE, &mut data);
            prop_assert!(!data.contains(&Occupancy::Occupied.to_ros()));
            // From the middle to an edge.
            prop_assert!(data.iter().filter(|&&number| number == Occupancy::Free.to_ros()).count() >= 19);
        }
    }
}
