//! Pictures of depths as scans. It reads no odometry: who reads the scan puts it where the camera was.

mod picture;
mod rays;

use jde_depth::{FloorPorts, FloorScan};
use jde_schema::prelude::*;
use jde_vision::{CameraGeometry, CameraPorts};
use picture::Depths;
use rays::Rays;

/// Exports a scan of what a depth camera sees of the floor and above it: obstacles, and edges where the floor ends.
///
/// The scan is level, and begins below the camera in its direction. A direction is free only where the floor is seen all
/// the way; a pixel without a depth says nothing (REP-118). The scan has the time of its picture.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "30ms")]
pub struct Scan {
    /// The depths: "32FC1" in metres or "16UC1" in millimetres.
    #[import(trigger)]
    depth: Import<Image>,
    #[ports]
    camera: CameraPorts,
    #[ports]
    floor: FloorPorts,
    /// The scan.
    #[export(validity = "1s")]
    scan: Export<LaserScan>,
    geometry: CameraGeometry,
    rays: Option<Rays>,
    /// The number of the last picture.
    picture: u64,
    /// Why there is no scan.
    lacks: Option<String>,
}

impl Schema for Scan {
    fn awake(&mut self, cx: &Context) -> Result {
        self.geometry = self.camera.geometry(cx)?;
        self.floor.scan(cx)?;
        (self.rays, self.picture) = (None, 0);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let before = self.lacks.take();
        if let Err(words) = self.see(cx) {
            if before.is_none() {
                warn!(cx, "no scan: {words}");
            }
            self.lacks = Some(words);
            self.scan.retract(cx);
        }
        Ok(())
    }
}

impl Scan {
    /// Exports the scan of a picture that is new.
    ///
    /// # Errors
    /// Why there is none.
    fn see(&mut self, cx: &Context) -> Result<(), String> {
        let depth = self.depth.get(cx).ok_or("there is no picture of depths")?;
        if self.camera.is_unknown(cx) {
            return Err("the camera states no calibration".to_owned());
        }
        if core::mem::replace(&mut self.picture, depth.sequence()) == depth.sequence() {
            return Ok(());
        }
        let depths = Depths::of(&depth)?;
        let camera = self.camera.model(cx, &self.geometry, depths.size())?;
        let level = self.floor.level(cx);
        let rays = Rays::kept(&mut self.rays, camera, level, depths.size());
        let mut seen: FloorScan = self.floor.scan(cx).map_err(|error| error.to_string())?;
        for (depth, ray) in depths.iter().zip(rays) {
            if let (Some(depth), Some(ray)) = (depth, ray) {
                let [x, y, z] = ray.map(|axis| axis * depth);
                seen.add(level.height, [x, y, z + level.height]);
            }
        }
        let mut scan = self.scan.loan(cx);
        scan.header = depth.header;
        if !seen.write(&mut scan) {
            return Err("the camera sees neither the floor nor anything on it".to_owned());
        }
        scan.publish_at(depth.time());
        Ok(())
    }

    /// Why there is no scan; `None` if there is one.
    pub fn lacks(&self) -> Option<&str> {
        self.lacks.as_deref()
    }
}

impl Inspect for Scan {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.camera.inspect(cx, problems);
        self.floor.inspect(cx, problems);
    }
}

jde_schema::export!("depth", "Pictures of depths as scans.", [Scan]);

#[cfg(test)]
mod tests;
