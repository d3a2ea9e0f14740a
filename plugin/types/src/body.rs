//! The body of a robot: its outline on the floor, and the places of its lasers.

use crate::{Frame, Header, Point2D, Pose2D, Seq, Value};

/// The outline of a robot on the floor: in files `{ radius = 0.25 }`, or `{ points = [[0.3, 0.2], ...] }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Footprint")]
pub struct Footprint {
    /// Radius of the circle around the origin of the base; not used if there are points.
    #[value(unit = "m")]
    pub radius: f64,
    /// The corners of a convex polygon in the frame of the base, in order; none for a circle.
    pub points: Seq<Point2D, 32>,
}

impl Footprint {
    /// Returns a circle of `radius` m around the origin of the base.
    #[must_use]
    pub const fn circle(radius: f64) -> Self {
        Self {
            radius,
            points: Seq::new(),
        }
    }
}

/// The body of a robot, for windows and pictures. A driver publishes it once it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Body")]
pub struct Body {
    /// Time, and the frame of the base.
    pub header: Header,
    /// The outline; a circle of radius 0 if it is unknown.
    pub footprint: Footprint,
    /// Where its lasers are.
    pub lasers: Seq<Mount, 8>,
}

/// Where a sensor is on a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Mount")]
pub struct Mount {
    /// The frame of the sensor, as in the headers of its values.
    pub frame: Frame,
    /// Its pose in the frame of the base.
    pub pose: Pose2D,
}

impl Body {
    /// Returns where the laser of a frame is. One that the body does not name is at the origin of the base and
    /// faces ahead.
    #[must_use]
    pub fn laser(&self, frame: &str) -> Pose2D {
        let mount = self.lasers.iter().find(|mount| mount.frame.as_str() == frame);
        mount.map_or(Pose2D::ORIGIN, |mount| mount.pose)
    }
}
