//! What the laser has seen around the robot, as the points that it must not touch. It corrects no pose.

use core::time::Duration;

use jde_grid::{GeometryError, Ray, RollingGrid};
use jde_motion::Outline;
use jde_schema::types::{Point2D, Pose2D};

/// Side of a cell, m: about the error of a scanner and of the odometry over a few seconds.
const RESOLUTION: f64 = 0.05;

/// What is known around the robot, in the frame of the pose.
pub(crate) struct Memory {
    grid: RollingGrid,
    reach: f64,
    /// The number of the last scan.
    last: Option<u64>,
    /// The jumps of the pose until now: nothing is known around it after one.
    jumps: u64,
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
            jumps: 0,
        })
    }

    /// Adds the scan with this number and time, once, after so many jumps of the pose: where the sensor was, and its rays. What the robot stands on is free.
    /// When it is new here, a circle around it is free too, in which it can turn with `margin` to spare.
    pub(crate) fn observe<R: Iterator<Item = (Point2D, bool)>>(
        &mut self,
        robot: &Pose2D,
        (outline, margin): (&Outline, f64),
        (number, time): (u64, Duration),
        jumps: u64,
        seen: impl FnOnce() -> (Pose2D, R),
    ) -> Result<(), GeometryError> {
        let at = (robot.x, robot.y);
        if self.jumps != jumps {
            *self = Self::new(self.reach)?;
            self.jumps = jumps;
        }
        self.grid.follow(at)?;
        let last = self.last.replace(number);
        if last != Some(number) {
            let (sensor, rays) = seen();
            let rays = rays.map(|(end, hit)| Ray {
                end: (end.x, end.y),
                hit,
            });
            self.grid.observe((sensor.x, sensor.y), rays, time);
        }
        if last.is_none() {
            // Cells whose edge is nearer than their center count as occupied by their center.
            let radius = outline.reach() + margin + 2.0 * RESOLUTION;
            self.grid
                .assume_free(at, radius, |(x, y)| libm::hypot(x - at.0, y - at.1) <= radius);
        } else {
            self.grid.assume_free(at, outline.reach(), |(x, y)| {
                outline.clearance(robot, &[Point2D { x, y }]) <= 0.0
            });
        }
        Ok(())
    }

    /// Returns what counts as an obstacle beside the newest scan, in the frame of the base, as far as it is in reach: the
    /// boundary of what is known to be free, or only what was seen occupied if the unknown is allowed.
    pub(crate) fn obstacles(&self, robot: &Pose2D, allow_unknown: bool, now: Duration) -> Vec<Point2D> {
        let (at, reach) = ((robot.x, robot.y), self.reach);
        let (sin, cos) = libm::sincos(robot.theta);
        let local = move |(x, y)| {
            let (dx, dy) = (x - at.0, y - at.1);
            Point2D {
                x: cos * dx + sin * dy,
                y: cos * dy - sin * dx,
            }
        };
        let places: Vec<(f64, f64)> = if allow_unknown {
            self.grid.remembered(at, reach, now, now).collect()
        } else {
            self.grid.boundary(at, reach)
        };
        let points = places.into_iter().map(local);
        points
            .filter(|point| libm::hypot(point.x, point.y) <= reach)
            .collect()
    }
}
