//! The map that the keyframes show, drawn so many at a time.

use core::time::Duration;

use jde_grid::{Geometry, GeometryError, Ray, RollingGrid};
use jde_types::Pose2D;

use crate::slam::{Slam, placed, turn_between};

/// Moves of a keyframe after which the map is drawn again, m and rad.
const MOVED: (f64, f64) = (0.05, 0.01);

/// A map of the keyframes where they are.
#[derive(Clone, Debug)]
pub struct MapDrawing {
    grid: RollingGrid,
    /// Where the keyframes were when they were drawn.
    drawn: Vec<Pose2D>,
    /// Whether they showed something outside the grid.
    is_cut: bool,
    /// What the keyframes had lost when the drawing began, and how often some had left.
    revision: u64,
    renumbered: u64,
}

impl MapDrawing {
    /// Returns an empty map with room for what the keyframes show, and `margin` m around that.
    ///
    /// # Errors
    /// If the resolution in metres is out of range, or there would be too many cells.
    pub fn new(slam: &Slam, resolution: f64, margin: f64) -> Result<Self, GeometryError> {
        let mut low = (f64::INFINITY, f64::INFINITY);
        let mut high = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let poses = slam.graph().poses().iter().map(|pose| (pose.x, pose.y));
        for (x, y) in poses.chain((0..slam.scans().len()).flat_map(|at| slam.hits(at))) {
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
        let middle = (f64::midpoint(low.0, high.0), f64::midpoint(low.1, high.1));
        let side = (high.0 - low.0).max(high.1 - low.1) + 2.0 * margin;
        // What is on the edge has a cell, wherever the cells begin.
        let cells = ((side / resolution).ceil() as u32).saturating_add(2);
        Ok(Self {
            grid: RollingGrid::around(middle, cells, resolution)?,
            drawn: Vec::new(),
            is_cut: false,
            revision: slam.revision(),
            renumbered: slam.renumbered(),
        })
    }

    /// Returns whether the keyframes have the numbers that they had when it began; else it must begin anew.
    #[must_use]
    pub fn is_numbered(&self, slam: &Slam) -> bool {
        self.renumbered == slam.renumbered()
    }

    /// Draws at most so many keyframes. Returns whether there are no others.
    pub fn advance(&mut self, slam: &Slam, most: usize) -> bool {
        let poses = slam.graph().poses();
        for (at, pose) in poses.iter().enumerate().skip(self.drawn.len()).take(most) {
            let scan = &slam.scans()[at];
            let is_outside = |point| self.grid.geometry().cell_at(point).is_none();
            self.is_cut |= slam.hits(at).any(is_outside);
            let free = scan.free().iter().map(|&end| (placed(pose, end), false));
            let rays = slam.hits(at).map(|end| (end, true)).chain(free);
            let rays = rays.map(|(end, hit)| Ray { end, hit });
            self.grid
                .observe(placed(pose, scan.mount()), rays, Duration::ZERO);
            self.drawn.push(*pose);
        }
        self.drawn.len() >= poses.len()
    }

    /// Returns whether the keyframes are still where they were drawn and show the same, and all of that is on the map.
    #[must_use]
    pub fn is_right(&self, slam: &Slam) -> bool {
        let is_there = |(drawn, pose): (&Pose2D, &Pose2D)| {
            drawn.distance_to(pose) < MOVED.0 && turn_between(drawn, pose) < MOVED.1
        };
        let is_kept = self.is_numbered(slam) && self.revision == slam.revision();
        is_kept && !self.is_cut && self.drawn.iter().zip(slam.graph().poses()).all(is_there)
    }

    /// Returns how many keyframes are drawn.
    #[must_use]
    pub const fn drawn(&self) -> usize {
        self.drawn.len()
    }

    /// Returns size, resolution and origin.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        self.grid.geometry()
    }

    /// Writes the numbers of `nav_msgs/OccupancyGrid`, row by row from the origin.
    ///
    /// # Panics
    /// If `data` has not as many numbers as the map cells.
    pub fn write_ros(&self, data: &mut [i8]) {
        self.grid.write_ros(Duration::ZERO, Duration::MAX, data);
    }
}

#[cfg(test)]
mod tests {
    use jde_grid::{Occupancy, OccupancyGrid};

    use super::*;
    use crate::scan::Scan;
    use crate::slam::Settings;
    use crate::world::World;

    /// What a robot shows that drives through a world for so many steps, by beams of 3 m.
    fn driven(world: &World, steps: u32) -> Slam {
        let mut random = fastrand::Rng::with_seed(3);
        let mut slam = Slam::new(Pose2D::new(-6.0, -5.0, 0.0));
        for step in 0..steps {
            let odometry = Pose2D::new(0.1 * f64::from(step), 0.0, 0.0);
            let laser = world.laser(&Pose2D::new(odometry.x - 6.0, -5.0, 0.0), &mut random);
            let scan = Scan::new(&laser, |_| Pose2D::ORIGIN, 360, 3.0);
            slam.step(&Settings::default(), &odometry, &scan);
        }
        slam
    }

    #[test]
    fn it_shows_the_walls_in_parts() {
        let world = World::ring(4);
        let slam = driven(&world, 30);
        assert!(slam.scans().len() > 4);
        let mut drawing = MapDrawing::new(&slam, 0.05, 2.0).expect("a small building");
        assert!(!drawing.advance(&slam, 2) && drawing.advance(&slam, 99) && drawing.is_right(&slam));
        let mut cells = vec![0; drawing.geometry().cells()];
        drawing.write_ros(&mut cells);
        let map = OccupancyGrid::from_ros(*drawing.geometry(), &cells).expect("as many numbers as cells");
        let at = |x, y| map.get(map.geometry().cell_at((x, y)).expect("on the map"));
        assert_eq!(at(-5.0, -5.0), Occupancy::Free);
        assert_eq!(at(-5.0, -7.0), Occupancy::Unknown);
        let walls = (0..60).filter(|&step| {
            let x = 0.05 * f64::from(step) - 5.0;
            [-4.02, -3.97].iter().any(|&y| at(x, y) == Occupancy::Occupied)
        });
        assert!(walls.count() > 50);
    }

    #[test]
    fn it_has_room_for_all_without_a_margin_and_anywhere() {
        let world = World::ring(4);
        let slam = driven(&world, 30);
        let mut drawing = MapDrawing::new(&slam, 0.05, 0.0).expect("a small building");
        assert!(drawing.advance(&slam, 99) && drawing.is_right(&slam));
        let (mut far, mut random) = (
            Slam::new(Pose2D::new(300.0, 1.6, 1.5)),
            fastrand::Rng::with_seed(3),
        );
        let scan = world.scan(&Pose2D::new(-6.0, -5.0, 0.0), &mut random);
        far.step(&Settings::default(), &Pose2D::ORIGIN, &scan);
        let mut drawing = MapDrawing::new(&far, 0.05, 5.0).expect("a small building");
        assert!(drawing.advance(&far, 99) && drawing.is_right(&far));
    }

    #[test]
    fn what_has_moved_or_is_outside_makes_it_wrong() {
        let world = World::ring(4);
        let mut drawing = MapDrawing::new(&driven(&world, 30), 0.05, 0.5).expect("a small building");
        let slam = driven(&world, 30);
        assert!(drawing.advance(&slam, 99) && drawing.is_right(&slam));
        let mut moved = drawing.clone();
        moved.drawn[1].x += 0.1;
        assert!(!moved.is_right(&slam));
        let slam = driven(&world, 50);
        assert!(drawing.advance(&slam, 99) && !drawing.is_right(&slam));
        assert!(MapDrawing::new(&slam, 0.0, 1.0).is_err() && MapDrawing::new(&slam, 0.001, 1.0).is_err());
    }
}
