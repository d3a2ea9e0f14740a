//! The schema of the map around the robot. Each scan is added once, from where the robot was when it was taken.

use jde_grid::{MAX_CELLS, Ray, RollingGrid};
use jde_motion::OdometryHistory;
use jde_schema::prelude::*;
use jde_schema::types::Point2D;

/// Exports a square map around the robot, from the scans of its laser.
///
/// Rays make cells free and their ends make cells occupied; a cell that no ray touches becomes unknown again. The
/// axes are those of the pose's frame. The map moves with the robot in steps of a quarter of its side.
#[derive(Describe)]
#[schema(perceptive, period = "200ms", budget = "50ms")]
pub struct Local {
    /// The scan of the laser.
    #[import]
    laser: Import<LaserScan>,
    /// The estimated pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// A place around which occupied cells become unknown, in the frame of the pose; once for each value.
    #[import(optional)]
    clear: Import<Point2D>,
    /// How far around that place.
    #[modulation(default = 1.0, unit = "m", min = 0.0, max = 100.0)]
    clear_radius: Modulation<f64>,
    /// The pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    mount: Modulation<Pose2D>,
    /// Side of the map.
    #[modulation(default = 12.0, unit = "m", min = 1.0, max = 500.0, fixed)]
    side: Modulation<f64>,
    /// Side of a cell. The map has at most 4096 × 4096 of them.
    #[modulation(default = 0.05, unit = "m", min = 0.01, max = 1.0, fixed)]
    resolution: Modulation<f64>,
    /// Time for which a cell is known after the last ray through it.
    #[modulation(default = 30.0, unit = "s", min = 0.0, max = 86400.0)]
    age: Modulation<f64>,
    /// The map.
    #[export]
    map: Export<OccupancyGrid>,
    grid: Option<RollingGrid>,
    history: OdometryHistory,
    /// The jumps of the pose until now. What was seen before one is elsewhere.
    jumps: u64,
    /// Whether the times of scans say nothing, which the log says once.
    is_untimely: bool,
    /// The number of the last scan that was added.
    scan: Option<u64>,
    /// The number of the last value of `clear`.
    cleared: u64,
}

impl Schema for Local {
    fn awake(&mut self, cx: &Context) -> Result {
        let side = self.side.get(cx) / self.resolution.get(cx);
        let capacity = MAX_CELLS.isqrt() as f64;
        if side > capacity {
            return Err(format!(
                "a map of {} m has {side:.0} cells of {} m a side: expected at most {capacity}",
                self.side.get(cx),
                self.resolution.get(cx)
            )
            .into());
        }
        self.grid = Some(RollingGrid::new(side.ceil() as u32, self.resolution.get(cx))?);
        self.scan = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let (Some(laser), Some(pose), Some(grid)) = (self.laser.get(cx), self.pose.get(cx), &mut self.grid)
        else {
            self.map.retract(cx);
            return Ok(());
        };
        let robot = pose.pose2d();
        self.history.add(pose.time(), &pose);
        if core::mem::replace(&mut self.jumps, self.history.jumps()) != self.history.jumps() {
            *grid = RollingGrid::new(grid.geometry().width(), grid.geometry().resolution())?;
            self.scan = None;
        }
        if let Err(error) = grid.follow((robot.x, robot.y)) {
            warn!(cx, "the pose is not a place on a map: {error}");
            self.map.retract(cx);
            return Ok(());
        }
        if let Some(place) = self.clear.get(cx)
            && core::mem::replace(&mut self.cleared, place.sequence()) != place.sequence()
        {
            grid.clear((place.x, place.y), self.clear_radius.get(cx));
        }
        let sweep = match self.history.sweep(&laser, laser.time(), cx.now()) {
            Ok(sweep) => sweep,
            Err(words) => {
                if !core::mem::replace(&mut self.is_untimely, true) {
                    warn!(cx, "no map: {words}");
                }
                self.map.retract(cx);
                return Ok(());
            }
        };
        self.is_untimely = false;
        if self.scan.replace(laser.sequence()) != Some(laser.sequence()) {
            let mount = self.mount.get(cx);
            let sensor = sweep.middle().transform(&mount);
            let rays = sweep.rays(&laser, &mount).map(|(end, hit)| Ray {
                end: (end.x, end.y),
                hit,
            });
            grid.observe((sensor.x, sensor.y), rays, laser.time());
        }
        let mut map = self.map.loan(cx);
        map.header = Header {
            stamp: cx.now().into(),
            frame_id: pose.header.frame_id,
        };
        map.info = info(grid);
        let age = Duration::from_secs_f64(self.age.get(cx));
        grid.write_ros(cx.now(), age, map.data.resize(grid.geometry().cells()));
        map.publish();
        Ok(())
    }
}

fn info(grid: &RollingGrid) -> MapMetaData {
    let geometry = grid.geometry();
    let (x, y, yaw) = geometry.origin();
    MapMetaData {
        resolution: geometry.resolution() as f32,
        width: geometry.width(),
        height: geometry.height(),
        origin: Pose2D::new(x, y, yaw).into(),
        ..MapMetaData::default()
    }
}
