//! Transforms between the frames of a robot, in space.

use crate::{Frame, Header, Point, Pose, Quaternion, Value, Vector3};

/// Translation and rotation of a frame in another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Transform")]
pub struct Transform {
    /// Position of the frame's origin.
    #[value(unit = "m")]
    pub translation: Vector3,
    /// Orientation of the frame.
    pub rotation: Quaternion,
}

/// Where a frame is in another one at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/TransformStamped")]
pub struct TransformStamped {
    /// Time, and the frame in which the transform is stated.
    pub header: Header,
    /// The frame that is there.
    pub child_frame_id: Frame,
    /// Where it is.
    pub transform: Transform,
}

impl Transform {
    /// Both frames are the same.
    pub const IDENTITY: Self = Self {
        translation: Vector3 {
            x: 0.0,
            y: 0.0,
            z: 0.0,
        },
        rotation: Quaternion::IDENTITY,
    };

    /// Returns a point of the frame as it is in the other one.
    #[must_use]
    pub fn apply(&self, point: Point) -> Point {
        let [x, y, z] = self.rotation.rotate([point.x, point.y, point.z]);
        Point {
            x: self.translation.x + x,
            y: self.translation.y + y,
            z: self.translation.z + z,
        }
    }

    /// Returns the transform of a frame that is at `inner` in this one.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        let Vector3 { x, y, z } = inner.translation;
        let Point { x, y, z } = self.apply(Point { x, y, z });
        Self {
            translation: Vector3 { x, y, z },
            rotation: self.rotation.compose(&inner.rotation),
        }
    }

    /// Returns the transform of the other frame in this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        let Vector3 { x, y, z } = self.translation;
        let [x, y, z] = rotation.rotate([-x, -y, -z]);
        Self {
            translation: Vector3 { x, y, z },
            rotation,
        }
    }
}

impl From<Pose> for Transform {
    fn from(
        Pose {
            position,
            orientation,
        }: Pose,
    ) -> Self {
        Self {
            translation: Vector3 {
                x: position.x,
                y: position.y,
                z: position.z,
            },
            rotation: orientation,
        }
    }
}

impl From<Transform> for Pose {
    fn from(
        Transform {
            translation,
            rotation,
        }: Transform,
    ) -> Self {
        Self {
            position: Point {
                x: translation.x,
                y: translation.y,
                z: translation.z,
            },
            orientation: rotation,
        }
    }
}
