//! Where a camera is on a robot: from directions of the camera to directions of the robot, to points on the
//! floor, and back.
//!
//! The frame of the robot is "base_link" of REP-105: x ahead, y to the left, z up, with the floor at z = 0.
//! The frame of the camera is that of REP-103 for pictures: x to the right, y down, z into the picture.

use jde_types::{Pose, Pose2D};

/// The place and direction of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraMount {
    /// Its place in the frame of the robot, m.
    pub position: [f64; 3],
    /// The angle to the left, rad.
    pub pan: f64,
    /// The angle downwards, rad.
    pub tilt: f64,
}

impl CameraMount {
    /// Returns a direction of the camera in the frame of the robot, of the same length.
    #[must_use]
    pub fn to_base(&self, [right, down, into]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.tilt);
        let (ahead, up) = (cos * into - sin * down, -sin * into - cos * down);
        let (sin, cos) = libm::sincos(self.pan);
        [cos * ahead + sin * right, sin * ahead - cos * right, up]
    }

    /// Returns a direction of the robot in the frame of the camera, of the same length.
    #[must_use]
    pub fn to_camera(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.pan);
        let (ahead, right) = (cos * x + sin * y, sin * x - cos * y);
        let (sin, cos) = libm::sincos(self.tilt);
        [right, -sin * ahead - cos * z, cos * ahead - sin * z]
    }

    /// Returns the point of the floor in a direction of the camera, x and y in m; `None` at the horizon, above
    /// it, and for a camera that is not above the floor.
    #[must_use]
    pub fn floor(&self, direction: [f64; 3]) -> Option<[f64; 2]> {
        let [x, y, z] = self.to_base(direction);
        let distance = -self.position[2] / z;
        let point = [self.position[0] + distance * x, self.position[1] + distance * y];
        (distance > 0.0 && point.iter().all(|axis| axis.is_finite())).then_some(point)
    }

    /// Returns the place on the floor, in the frame of the robot, below something whose z axis points into it, as that
    /// of a tag does, and the direction in which it faces. `pose` is in the frame of the camera.
    #[must_use]
    pub fn facing(&self, pose: &Pose) -> Pose2D {
        let [x, y, _] = self.to_base([pose.position.x, pose.position.y, pose.position.z]);
        let [ahead, left, _] = self.to_base(pose.orientation.rotate([0.0, 0.0, -1.0]));
        Pose2D::new(
            self.position[0] + x,
            self.position[1] + y,
            libm::atan2(left, ahead),
        )
    }

    /// Returns the direction of a point in the frame of the robot, in that of the camera.
    #[must_use]
    pub fn direction_of(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.position;
        self.to_camera([point[0] - x, point[1] - y, point[2] - z])
    }
}
