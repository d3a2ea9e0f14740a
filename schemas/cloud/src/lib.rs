//! Clouds of points as scans, as ROS's `pointcloud_to_laserscan`. It reads no odometry: who reads the scan puts it where
//! the sensor was.

use jde_depth::{FloorPorts, Lacks};
use jde_schema::prelude::*;
use jde_schema::types::{Frame, PointCloud2};

/// Exports a scan of what a cloud of points has on the floor: obstacles, and edges where the floor ends.
///
/// The scan is level, and begins below the sensor in its direction. A direction is free only where the cloud has floor all
/// the way from `range_min` on. Of what is nearer the scan says nothing: a thing there may be below the view of the sensor.
/// The scan has the time of its cloud.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "30ms")]
pub struct Scan {
    /// The cloud, in the frame of its sensor.
    #[import(trigger)]
    cloud: Import<PointCloud2>,
    /// Whether the points are in an optical frame, z ahead, as those of a depth camera; otherwise x is ahead.
    #[modulation(default = Flag::FALSE, fixed)]
    optical: Modulation<Flag>,
    #[ports]
    floor: FloorPorts,
    /// The scan.
    #[export(validity = "1s")]
    scan: Export<LaserScan>,
    /// The number of the last cloud.
    number: u64,
    /// The frame of the first cloud.
    frame: Option<Frame>,
    lacks: Lacks,
}

impl Schema for Scan {
    fn awake(&mut self, cx: &Context) -> Result {
        self.floor.scan(cx)?;
        (self.number, self.frame) = (0, None);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let number = self.cloud.get(cx).map(|cloud| cloud.sequence());
        if number.is_some_and(|number| core::mem::replace(&mut self.number, number) == number) {
            return Ok(());
        }
        let seen = self.see(cx);
        if !self.lacks.keep(cx, seen) {
            self.scan.retract(cx);
        }
        Ok(())
    }
}

impl Scan {
    /// Exports the scan of a cloud.
    ///
    /// # Errors
    /// Why there is none.
    fn see(&mut self, cx: &Context) -> Result<(), String> {
        let cloud = self.cloud.get(cx).ok_or("there is no cloud")?;
        let (frame, first) = (
            cloud.header.frame_id,
            *self.frame.get_or_insert(cloud.header.frame_id),
        );
        if frame != first {
            return Err(format!(
                "the cloud is in `{frame}`, and the first one was in `{first}`"
            ));
        }
        let level = self.floor.level(cx);
        let is_optical = self.optical.get(cx).get();
        let mut seen = self.floor.scan(cx).map_err(|error| error.to_string())?;
        for point in cloud.points()? {
            let point = if is_optical {
                level.optical(point)
            } else {
                level.point(point)
            };
            seen.add(point);
        }
        let mut scan = self.scan.loan(cx);
        scan.header = self.floor.header(cx, &cloud.header);
        if !seen.write(&mut scan) {
            return Err("the cloud has neither floor nor anything on it".to_owned());
        }
        scan.publish_at(cloud.time());
        Ok(())
    }
}

impl Panel for Scan {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        self.lacks.draw(pen);
    }
}

impl Inspect for Scan {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.floor.inspect(cx, problems);
    }
}

jde_schema::export!("cloud", "Clouds of points as scans.", [Scan]);

#[cfg(test)]
mod tests;
