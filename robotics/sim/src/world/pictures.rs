//! Camera pictures of a world, and their depths.
//!
//! A picture shows the present time and changes nothing.

use super::{RobotId, World};
use crate::camera::{CameraConfig, Renderer, add_noise};
use crate::error::WorldError;
use crate::loose::LooseShape;
use crate::random::Purpose;
use crate::sensor::DepthConfig;
use crate::solid::Surface;

/// The thickness of the top of a table, in metres.
const TABLETOP: f64 = 0.03;

impl World {
    /// Fills `picture` with the view of a camera on a robot: RGB, three bytes a pixel, rows from the top.
    ///
    /// The picture never shows the robot itself. The same world gives the same bytes.
    ///
    /// # Errors
    /// A buffer whose length is not [`CameraConfig::bytes`], an invalid number in the configuration.
    pub fn picture(
        &self,
        robot: RobotId,
        camera: &CameraConfig,
        picture: &mut [u8],
    ) -> Result<(), WorldError> {
        self.draw(robot, camera, picture).map(|_| ())
    }

    /// Fills `picture` as [`World::picture`] does, and `depths` with metres along the optical axis, one value a
    /// pixel, rows from the top; +∞ is nothing in the range, -∞ is too near (REP-118, REP-117).
    ///
    /// A pixel's depth is that of the point whose colour it has.
    ///
    /// # Errors
    /// A buffer whose length is not [`CameraConfig::bytes`] or [`CameraConfig::pixels`], an invalid number in a
    /// configuration.
    pub fn picture_with_depths(
        &self,
        robot: RobotId,
        (camera, depth): (&CameraConfig, &DepthConfig),
        picture: &mut [u8],
        depths: &mut [f32],
    ) -> Result<(), WorldError> {
        camera.check()?;
        depth.check()?;
        super::readings::check_buffer("depths", depths.len(), camera.pixels())?;
        let near = self.draw(robot, camera, picture)?;
        let noise = self.noise(robot, Purpose::Depth, depth.stream);
        depth.measure(&near, &noise, depths);
        Ok(())
    }

    /// Fills `picture`, and returns the inverse of each pixel's depth.
    fn draw(
        &self,
        robot: RobotId,
        camera: &CameraConfig,
        picture: &mut [u8],
    ) -> Result<Vec<f32>, WorldError> {
        camera.check()?;
        super::readings::check_buffer("picture", picture.len(), camera.bytes())?;
        let head = (self.head(robot), &self.config(robot).head);
        let view = camera.view(self.truth(robot).pose, head);
        let mut renderer = Renderer::new(view, (&self.floor, &self.light), &self.tags);
        for thing in self.scene.fixtures() {
            let bottom = match thing.surface {
                Surface::Glass => continue,
                Surface::Opaque | Surface::Black => 0.0,
                Surface::Tabletop => (thing.height - TABLETOP).max(0.0),
            };
            renderer.add_outline(thing.outline, [bottom, thing.height], thing.color);
        }
        for mover in &self.movers {
            match mover.person() {
                Some(person) => renderer.add_person(&person),
                None => {
                    let shape = mover.shape();
                    renderer.add_outline(shape.outline, [0.0, shape.height], shape.color);
                }
            }
        }
        for body in self.loose.bodies() {
            let shape = body.shape();
            match body.form {
                LooseShape::Ball { radius } => {
                    let [x, y] = body.center();
                    renderer.add_ball([x, y, radius], radius, shape.color);
                }
                LooseShape::Box { .. } => {
                    renderer.add_outline(shape.outline, [0.0, shape.height], shape.color)
                }
            }
        }
        for (other, _) in self.robots().filter(|(other, _)| *other != robot) {
            renderer.add_robot(self.truth(other).pose, self.config(other));
        }
        let near = match camera.warp() {
            None => renderer.draw(picture),
            Some(warp) => {
                let mut pinhole = vec![0; warp.bytes()];
                let near = renderer.draw(&mut pinhole);
                warp.apply(&pinhole, &near, picture)
            }
        };
        if camera.noise > 0.0 {
            let noise = self.noise(robot, Purpose::Picture, camera.stream);
            add_noise(picture, camera.noise, &noise);
        }
        Ok(near)
    }
}
