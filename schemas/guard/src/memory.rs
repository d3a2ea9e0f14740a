//! What the laser has seen around the robot, as the points that it must not touch. It corrects no pose.

use core::time::Duration;

use jde_grid::{GeometryError, Ray, RollingGrid};
use jde_motion::Outline;
use jde_schema::types::{LaserScan, Point2D, Pose2D};

/// Side of a cell, m: about the error of a scanner and of the odometry over a few seconds.
const RESOLUTION: f64 = 0.05;
/// How far the pose may move between two scans, m. No robot of this size moves so far; a pose that does was
/// set anew, and nothing is known around it.
const MAX_STEP: f64 = 1.0;

/// What is known around the robot, in the frame of the pose.
pub(crate) struct Memory {
    grid: RollingGrid,
    reach: f64,
    last: Option<Pose2D>,
}

impl Memory {
    /// Nothing is known; `reach` is how far points count, m.
    pub(crate) fn new(reach: f64) -> Result<Self, GeometryError> {
        // The grid moves when the robot is a quarter of its side from the middle.
        let side = (4.0 * reach / RESOLUTION).ceil() as u32;
        Ok(Self {
            grid: RollingGrid::new(side, RESOLUTION)?,
            reach,
            last: None,
        })
    }

    /// Adds a scan. What the robot stands on is free. When it is new here, a circle around it is free too, in
    /// which it can turn with `margin` to spare.
    pub(crate) fn observe(
        &mut self,
        robot: &Pose2D,
        sensor: &Pose2D,
        scan: &LaserScan,
        (outline, margin): (&Outline, f64),
        now: Duration,
    ) -> Result<(), GeometryError> {
        let at = (robot.x, robot.y);
        if self.last.is_some_and(|last| last.distance_to(robot) > MAX_STEP) {
            *self = Self::new(self.reach)?;
        }
        self.grid.follow(at)?;
        let rays = scan.rays(sensor).map(|(end, hit)| Ray {
            end: (end.x, end.y),
            hit,
        });
        self.grid.observe((sensor.x, sensor.y), rays, now);
        let is_new = self.last.replace(*robot).is_none();
        if is_new {
            // Cells whose edge is nearer than their center count as occupied by their center.
            let radius = outline.reach() + margin + 2.0 * RESOLUTION;
            self.grid
                .assume_free(at, radius, |(x, y)| (x - at.0).hypot(y - at.1) <= radius);
        } else {
            self.grid.assume_free(at, outline.reach(), |(x, y)| {
                outline.clearance(robot, &[Point2D { x, y }]) <= 0.0
            });
        }
        Ok(())
    }

    /// Returns the boundary of what is known to be free, in the frame of the base, as far as it is in reach.
    pub(crate) fn boundary(&self, robot: &Pose2D) -> impl Iterator<Item = Point2D> + '_ {
        let robot = *robot;
        let at = (robot.x, robot.y);
        self.grid.boundary(at, self.reach).filter_map(move |(x, y)| {
            let local = robot.localize(&Pose2D::new(x, y, 0.0));
            (local.x.hypot(local.y) <= self.reach).then_some(Point2D {
                x: local.x,
                y: local.y,
            })
        })
    }
}
