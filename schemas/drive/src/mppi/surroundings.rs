//! What is around the robot: what the laser sees, and for a time what it saw before. Its frame is that of the
//! odometry, moved to a corner near the robot, so that numbers of 32 bits suffice.

use jde_grid::{Distances, GeometryError, Ray, RollingGrid};
use jde_motion::Sweep;
use jde_mppi::Clearance;
use jde_schema::prelude::*;
use jde_schema::types::Point2D;

/// Side of a cell, m: about the error of a scanner.
const RESOLUTION: f64 = 0.05;

/// What is around the robot.
pub(super) struct Surroundings {
    grid: RollingGrid,
    /// How far it reaches, m and cells.
    reach: f64,
    cells: u32,
    /// The first column and row of the window around the robot.
    corner: (f64, f64),
    occupied: Vec<bool>,
    distances: Distances,
    clearance: Clearance,
    points: Vec<Point2D>,
    /// The number of the last scan.
    last: Option<u64>,
    /// The jumps of the odometry until now. What was seen before one is elsewhere.
    jumps: u64,
}

impl Surroundings {
    /// Nothing is known; `reach` is how far obstacles count, m.
    pub(super) fn new(reach: f64) -> Result<Self, GeometryError> {
        let cells = (reach / RESOLUTION).ceil() as u32;
        let width = 2 * cells as usize + 1;
        Ok(Self {
            // The grid moves when the robot is a quarter of its side from the middle.
            grid: RollingGrid::new(4 * cells + 4, RESOLUTION)?,
            reach,
            cells,
            corner: (0.0, 0.0),
            occupied: vec![false; width * width],
            distances: Distances::default(),
            clearance: Clearance::new(width, RESOLUTION as f32),
            points: Vec::new(),
            last: None,
            jumps: 0,
        })
    }

    /// Adds a scan once, from a sensor at `mount` on the base, after so many jumps of the odometry.
    pub(super) fn observe(
        &mut self,
        robot: &Pose2D,
        jumps: u64,
        scan: &Sample<'_, LaserScan>,
        sweep: &Sweep,
        mount: &Pose2D,
    ) -> Result<(), GeometryError> {
        if self.jumps != jumps {
            *self = Self::new(self.reach)?;
            self.jumps = jumps;
        }
        self.grid.follow((robot.x, robot.y))?;
        if self.last.replace(scan.sequence()) == Some(scan.sequence()) {
            return Ok(());
        }
        let sensor = sweep.middle().transform(mount);
        let rays = sweep.rays(scan, mount).map(|(end, hit)| Ray {
            end: (end.x, end.y),
            hit,
        });
        self.grid.observe((sensor.x, sensor.y), rays, scan.time());
        Ok(())
    }

    /// Puts the window around the robot: the points `seen` in the frame of the base, and what was seen within
    /// `age`.
    pub(super) fn look(&mut self, robot: &Pose2D, seen: &[Point2D], now: Duration, age: Duration) {
        let (column, row) = self.grid.geometry().to_grid((robot.x, robot.y));
        let reach = f64::from(self.cells);
        self.corner = (column.floor() - reach, row.floor() - reach);
        self.points.clear();
        self.points.extend_from_slice(seen);
        let remembered = self.grid.remembered((robot.x, robot.y), self.reach, now, age);
        let (sin, cos) = libm::sincos(robot.theta);
        self.points.extend(remembered.map(|(x, y)| {
            let (dx, dy) = (x - robot.x, y - robot.y);
            Point2D {
                x: cos * dx + sin * dy,
                y: cos * dy - sin * dx,
            }
        }));
        self.occupied.fill(false);
        let width = 2 * self.cells as usize + 1;
        for point in &self.points {
            let place = (
                robot.x + cos * point.x - sin * point.y,
                robot.y + sin * point.x + cos * point.y,
            );
            let (column, row) = self.grid.geometry().to_grid(place);
            let (column, row) = (column - self.corner.0, row - self.corner.1);
            let is_inside = |at: f64| (0.0..width as f64).contains(&at);
            if is_inside(column) && is_inside(row) {
                self.occupied[row as usize * width + column as usize] = true;
            }
        }
        self.clearance
            .set_squares(self.distances.squared(width, &self.occupied));
    }

    /// The distances in the window.
    pub(super) fn clearance(&self) -> &Clearance {
        &self.clearance
    }

    /// What must not be touched, in the frame of the base at the last look.
    pub(super) fn points(&self) -> &[Point2D] {
        &self.points
    }

    /// A pose in the frame of the window.
    pub(super) fn to_window(&self, pose: &Pose2D) -> [f32; 3] {
        let (column, row) = self.grid.geometry().to_grid((pose.x, pose.y));
        let along = |at: f64, corner: f64| ((at - corner) * RESOLUTION) as f32;
        [
            along(column, self.corner.0),
            along(row, self.corner.1),
            pose.theta as f32,
        ]
    }

    /// A place of the window in the frame of the odometry.
    pub(super) fn to_odometry(&self, (x, y): (f32, f32)) -> Pose2D {
        let along = |at: f32, corner: f64| f64::from(at) / RESOLUTION + corner;
        let at = (along(x, self.corner.0), along(y, self.corner.1));
        let (x, y) = self.grid.geometry().to_world(at);
        Pose2D::new(x, y, 0.0)
    }
}
