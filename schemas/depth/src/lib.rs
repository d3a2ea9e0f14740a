//! Pictures of depths as scans. It reads no odometry: who reads the scan puts it where the camera was.

mod picture;
mod rays;

use jde_depth::{FloorPorts, Lacks};
use jde_schema::prelude::*;
use jde_vision::{CameraGeometry, CameraPorts};
use picture::Depths;
use rays::Rays;

/// Exports a scan of what a depth camera sees of the floor and above it: obstacles, and edges where the floor ends.
///
/// The scan is level, and begins below the camera in its direction. A direction is free only where the floor is seen all
/// the way from `range_min` on; a pixel without a depth says nothing (REP-118). Of what is nearer than `range_min` the scan
/// says nothing: a thing there may be below the picture. The scan has the time of its picture.
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
    lacks: Lacks,
    /// What of the floor is below the picture and should not be.
    blind: Option<String>,
}

impl Schema for Scan {
    fn awake(&mut self, cx: &Context) -> Result {
        self.geometry = self.camera.geometry(cx)?;
        self.floor.scan(cx)?;
        (self.rays, self.picture) = (None, 0);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let number = self.depth.get(cx).map(|depth| depth.sequence());
        let is_known = !self.camera.is_unknown(cx);
        if is_known && number.is_some_and(|number| core::mem::replace(&mut self.picture, number) == number) {
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
    /// Exports the scan of a picture.
    ///
    /// # Errors
    /// Why there is none.
    fn see(&mut self, cx: &Context) -> Result<(), String> {
        let depth = self.depth.get(cx).ok_or("there is no picture of depths")?;
        if self.camera.is_unknown(cx) {
            return Err("the camera states no calibration".to_owned());
        }
        let depths = Depths::of(&depth)?;
        let camera = self.camera.model(cx, &self.geometry, depths.size())?;
        let level = self.floor.level(cx);
        let (rays, are_new) = Rays::kept(&mut self.rays, camera, level, depths.size());
        if are_new {
            self.blind = self.floor.blind(cx, rays.directions().flatten());
            if let Some(words) = &self.blind {
                warn!(cx, "{words}");
            }
        }
        let mut seen = self.floor.scan(cx).map_err(|error| error.to_string())?;
        for (depth, ray) in depths.iter().zip(rays.directions()) {
            if let (Some(depth), Some(ray)) = (depth, ray) {
                let [x, y, z] = ray.map(|axis| axis * depth);
                seen.add([x, y, z + level.height]);
            }
        }
        let mut scan = self.scan.loan(cx);
        scan.header = self.floor.header(cx, &depth.header);
        if !seen.write(&mut scan) {
            return Err("the camera sees neither the floor nor anything on it".to_owned());
        }
        scan.publish_at(depth.time());
        Ok(())
    }
}

impl Panel for Scan {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        self.lacks.draw(pen);
        if let Some(words) = &self.blind {
            pen.text(words);
        }
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
