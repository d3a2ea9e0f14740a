//! A map that is continued: what its cells show from many places becomes keyframes.

use core::f64::consts::TAU;

use jde_grid::{Cell, Occupancy, OccupancyGrid, walk};
use jde_types::Pose2D;

use crate::graph::{Edge, Relation};
use crate::matrix::diagonal;
use crate::scan::{End, Scan};
use crate::slam::{Anchor, Slam};

/// The side of the squares in each of which one free cell becomes a keyframe, m.
const APART: f64 = 0.7;
/// The rays from a keyframe, and how far they go, m.
const RAYS: usize = 360;
const REACH: f64 = 10.0;
/// How far the start may be from a keyframe, m.
const MAX_START_DISTANCE: f64 = 1.5;
/// How certain the places of keyframes are, 1/m².
const CERTAIN: f64 = 1e6;

/// A map that goes on from another one, and is read in parts.
#[derive(Clone, Debug)]
pub struct Continuation {
    map: OccupancyGrid,
    /// Squares in a row.
    columns: u32,
    /// For each square the number of its keyframe.
    numbers: Vec<Option<usize>>,
    /// For each keyframe its square and its cell.
    views: Vec<(u32, Cell)>,
    start: Anchor,
    slam: Slam,
}

impl Continuation {
    /// Begins to read a map on which the robot is at `start`, to 0.3 m and 0.2 rad. `None` if no free cell near there is
    /// visible.
    ///
    /// Takes time by the number of cells.
    #[must_use]
    pub fn new(map: OccupancyGrid, start: &Pose2D) -> Option<Self> {
        let geometry = *map.geometry();
        let side = (libm::round(APART / geometry.resolution()) as u32).max(1);
        let columns = geometry.width().div_ceil(side);
        let squares = columns * geometry.height().div_ceil(side);
        let mut views = Vec::new();
        let numbers = (0..squares)
            .map(|square| {
                let corner = Cell::new(square % columns * side, square / columns * side);
                let cell = middle(&map, corner, side)?;
                views.push((square, cell));
                Some(views.len() - 1)
            })
            .collect();
        let place = geometry.cell_at((start.x, start.y))?;
        let distance = |&(_, cell): &(u32, Cell)| {
            let (x, y) = geometry.center(cell);
            libm::hypot(x - start.x, y - start.y)
        };
        let (keyframe, &(_, cell)) = (views.iter().enumerate())
            .filter(|(_, view)| distance(view) < MAX_START_DISTANCE && is_visible(&map, view.1, place))
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))?;
        let (x, y) = geometry.center(cell);
        let pose = Pose2D::new(x, y, 0.0).localize(start);
        Some(Self {
            map,
            columns,
            numbers,
            views,
            start: Anchor { keyframe, pose },
            slam: Slam::new(*start),
        })
    }

    /// Returns how many keyframes it will have.
    #[must_use]
    pub const fn keyframes(&self) -> usize {
        self.views.len()
    }

    /// Returns how many keyframes are read.
    #[must_use]
    pub const fn read(&self) -> usize {
        self.slam.scans.len()
    }

    /// Reads so many keyframes. Returns the map once all are read; its next scan is matched with them.
    ///
    /// Takes time by the cells that 360 rays of 10 m meet from each.
    pub fn advance(&mut self, most: usize) -> Option<Slam> {
        for _ in 0..most.min(self.views.len() - self.read()) {
            self.read_next();
        }
        if self.read() < self.views.len() {
            return None;
        }
        let mut slam = core::mem::take(&mut self.slam);
        slam.given = slam.scans.len();
        slam.set_anchor(self.start);
        Some(slam)
    }

    fn read_next(&mut self) {
        let (square, cell) = self.views[self.read()];
        let (x, y) = self.map.geometry().center(cell);
        let to = (self.slam).add_keyframe(Pose2D::new(x, y, 0.0), &view(&self.map, cell));
        let beside = [(-1, 0), (-1, -1), (0, -1), (1, -1)];
        let beside =
            beside.map(|(dx, dy)| Cell::new(square % self.columns, square / self.columns).offset(dx, dy));
        for other in (beside.into_iter().flatten()).filter(|other| other.x < self.columns) {
            let Some(from) = self.numbers[(other.y * self.columns + other.x) as usize] else {
                continue;
            };
            if is_visible(&self.map, self.views[from].1, cell) {
                let poses = self.slam.graph.poses();
                let pose = poses[from].localize(&poses[to]);
                self.slam.add_edge(Edge {
                    from,
                    to,
                    pose,
                    information: diagonal([CERTAIN; 3]),
                    relation: Relation::Successive,
                });
            }
        }
    }
}

/// The free cell nearest to the middle of a square.
fn middle(map: &OccupancyGrid, corner: Cell, side: u32) -> Option<Cell> {
    let middle = Cell::new(corner.x + side / 2, corner.y + side / 2);
    let cells = (0..side * side).map(|at| Cell::new(corner.x + at % side, corner.y + at / side));
    cells
        .filter(|&cell| map.get(cell) == Occupancy::Free)
        .min_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)))
}

fn is_visible(map: &OccupancyGrid, from: Cell, to: Cell) -> bool {
    walk(from, to, |cell, _| map.get(cell) == Occupancy::Free)
}

/// What the map shows from a cell all around, with the axes of the map's frame.
fn view(map: &OccupancyGrid, from: Cell) -> Scan {
    let geometry = map.geometry();
    let (x, y) = geometry.center(from);
    let (column, row) = geometry.to_grid((x, y));
    let mut ends: Vec<End> = Vec::new();
    let mut last = None;
    let mut number = 0;
    for ray in 0..RAYS {
        let (sin, cos) = libm::sincos(TAU * ray as f64 / RAYS as f64);
        let end = geometry.to_grid((x + REACH * cos, y + REACH * sin));
        let to = inside(map, (column, row), end);
        let (mut free, mut hit) = (from, None);
        walk(from, to, |cell, _| {
            match map.get(cell) {
                Occupancy::Free => free = cell,
                Occupancy::Occupied => hit = Some(cell),
                Occupancy::Unknown => {}
            }
            map.get(cell) == Occupancy::Free
        });
        // Rays that meet the same cell are one, and are next to those that meet the next.
        if hit.is_some() && hit == last {
            continue;
        }
        number += if hit.is_some() && last.is_some() { 1 } else { 3 };
        last = hit;
        let (at_x, at_y) = geometry.center(hit.unwrap_or(free));
        let at = ((at_x - x) as f32, (at_y - y) as f32);
        let range = if hit.is_some() {
            libm::hypotf(at.0, at.1)
        } else {
            f32::INFINITY
        };
        ends.push((number, range, at));
    }
    let increment = (TAU / RAYS as f64) as f32;
    Scan::of_ends(&ends, increment, (0.0, 0.0), RAYS).all_around()
}

/// The cell where the line from a place to another leaves the grid, or that of the other place.
fn inside(map: &OccupancyGrid, from: (f64, f64), to: (f64, f64)) -> Cell {
    let share = |from: f64, to: f64, size: u32| {
        let edge = if to > from { f64::from(size) - 0.5 } else { 0.5 };
        let is_outside = to < 0.5 || to > f64::from(size) - 0.5;
        if is_outside {
            (edge - from) / (to - from)
        } else {
            1.0
        }
    };
    let (width, height) = (map.geometry().width(), map.geometry().height());
    let share = share(from.0, to.0, width)
        .min(share(from.1, to.1, height))
        .clamp(0.0, 1.0);
    let at = |from: f64, to: f64, size: u32| ((from + share * (to - from)) as u32).min(size - 1);
    Cell::new(at(from.0, to.0, width), at(from.1, to.1, height))
}

#[cfg(test)]
mod tests {
    use jde_grid::Geometry;

    use super::*;
    use crate::MapDrawing;
    use crate::slam::{Settings, State};
    use crate::world::World;

    /// So many keyframes are read at once.
    const PART: usize = 7;

    /// A map of the keyframes of a robot that drives along one side of a ring.
    fn map(world: &World, margin: f64) -> OccupancyGrid {
        let mut random = fastrand::Rng::with_seed(1);
        let mut slam = Slam::new(Pose2D::new(-6.0, -5.0, 0.0));
        for step in 0..40 {
            let odometry = Pose2D::new(0.1 * f64::from(step), 0.0, 0.0);
            let pose = Pose2D::new(odometry.x - 6.0, -5.0, 0.0);
            slam.step(&Settings::default(), &odometry, &world.scan(&pose, &mut random));
        }
        cells(&slam, margin)
    }

    fn on_map(map: &OccupancyGrid, start: Pose2D) -> Option<Slam> {
        let mut continuation = Continuation::new(map.clone(), &start)?;
        let parts = continuation.keyframes().div_ceil(PART);
        assert!((1..parts).all(|_| continuation.advance(PART).is_none()));
        assert_eq!(continuation.read(), PART * (parts - 1));
        let slam = continuation.advance(PART).expect("all are read");
        assert_eq!(slam.scans().len(), continuation.keyframes());
        Some(slam)
    }

    fn cells(slam: &Slam, margin: f64) -> OccupancyGrid {
        let mut drawing = MapDrawing::new(slam, 0.05, margin).expect("a small building");
        while !drawing.advance(slam, 100) {}
        let mut cells = vec![0; drawing.geometry().cells()];
        drawing.write_ros(&mut cells);
        OccupancyGrid::from_ros(*drawing.geometry(), &cells).expect("as many numbers as cells")
    }

    #[test]
    fn a_robot_goes_on_where_its_map_ends() {
        let world = World::ring(4);
        // The margin decides which cells become keyframes.
        for margin in [0.5, 0.8, 1.0, 1.2, 1.35, 2.0] {
            goes_on(&world, &map(&world, margin));
        }
    }

    fn goes_on(world: &World, map: &OccupancyGrid) {
        let mut random = fastrand::Rng::with_seed(2);
        // It stands where the map is known, 0.2 m from where it is said to be, and drives on into what is not.
        let mut truth = Pose2D::new(-3.2, -4.9, 0.05);
        let mut slam = on_map(map, Pose2D::new(-3.0, -5.0, 0.0)).expect("it is free there");
        let given = slam.scans().len();
        let mut odometry = Pose2D::new(7.0, 3.0, 1.0);
        // Along the corridor, around its corner, and on.
        for step in 0..140 {
            let motion = match step {
                0..91 => Pose2D::new(0.1, 0.0, -0.0005),
                91..101 => Pose2D::new(0.0, 0.0, 0.157),
                _ => Pose2D::new(0.1, 0.0, 0.0),
            };
            (truth, odometry) = (truth.transform(&motion), odometry.transform(&motion));
            let state = slam.step(&Settings::default(), &odometry, &world.scan(&truth, &mut random));
            slam.advance(&Settings::default());
            assert!(matches!(state, State::Fits(_)), "{state} at {truth:?}");
        }
        let anchor = slam.anchor(&odometry).expect("it fits");
        let away = slam.place(&anchor).distance_to(&truth);
        assert!(away < 0.1, "{away} m at {truth:?}");
        assert!(slam.scans().len() > given, "it has seen more");
    }

    #[test]
    fn a_robot_that_stands_where_it_is_not_said_to_be_adds_nothing() {
        let world = World::ring(4);
        let map = map(&world, 1.0);
        let mut random = fastrand::Rng::with_seed(3);
        for x in [-4.0, -3.5, -2.5, -2.0] {
            let mut slam = on_map(&map, Pose2D::new(x, -5.0, 0.0)).expect("it is free there");
            let truth = Pose2D::new(-3.0, -5.0, 0.0);
            for _ in 0..10 {
                let scan = world.scan(&truth, &mut random);
                slam.step(&Settings::default(), &Pose2D::ORIGIN, &scan);
            }
            assert_eq!(slam.scans().len(), slam.given(), "{x}: {}", slam.state());
        }
    }

    #[test]
    fn nothing_changes_where_nothing_is_new() {
        let map = map(&World::ring(4), 1.0);
        let slam = on_map(&map, Pose2D::new(-3.0, -5.0, 0.0)).expect("it is free there");
        let again = cells(&slam, 1.0);
        let mut counts = [[0; 3]; 3];
        for (index, &state) in map.cells().iter().enumerate() {
            let place = map.geometry().center(map.geometry().cell(index));
            // Around where the robot drove. What it saw from afar has gaps.
            if place.0 > 0.0 || place.1 > -3.8 {
                continue;
            }
            let found = again.geometry().cell_at(place).map(|cell| again.get(cell));
            counts[state as usize][found.unwrap_or(Occupancy::Unknown) as usize] += 1;
        }
        let [known, walls, unknown] = counts;
        assert!(
            known[0] > 100 * known[2] && known[0] > 100 * unknown[0],
            "{counts:?}"
        );
        // Of walls that are two cells thick, the side that is seen.
        assert!(walls[1] > 2 * walls[2], "{counts:?}");
        assert_eq!((known[1], walls[0], unknown[1]), (0, 0, 0));
    }

    #[test]
    fn a_start_that_is_not_free_is_refused() {
        let map = map(&World::ring(4), 1.0);
        for (x, y) in [(0.0, 0.0), (-7.5, -5.0), (1e3, 0.0), (f64::NAN, 0.0)] {
            assert!(on_map(&map, Pose2D::new(x, y, 0.0)).is_none(), "{x}, {y}");
        }
        let geometry = Geometry::new(1, 1, 0.05, (0.0, 0.0, 0.0)).expect("valid");
        let unknown = OccupancyGrid::filled(geometry, Occupancy::Unknown);
        assert!(on_map(&unknown, Pose2D::ORIGIN).is_none());
    }
}
