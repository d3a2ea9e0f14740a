//! Poses and twists of the plane, in the axes of ROS REP-103: x ahead, y left, counter-clockwise positive.
//!
//! Plain numbers only. Shapes and rays live in `solid`.

use std::f64::consts::{PI, TAU};

/// A place in metres and a heading in radians, in a frame that the context names.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// Metres along x.
    pub x: f64,
    /// Metres along y.
    pub y: f64,
    /// Radians from the x axis, counter-clockwise, in (-π, π].
    pub heading: f64,
}

/// The motion of a robot, or a command for it: ahead, to the left, and about its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist2 {
    /// Metres a second ahead; negative is backwards.
    pub linear: f64,
    /// Metres a second to the left. Only omnidirectional robots move so; others ignore it in a command.
    pub lateral: f64,
    /// Radians a second, counter-clockwise.
    pub angular: f64,
}

/// An axis-aligned rectangle in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner of least x and y.
    pub min: [f64; 2],
    /// The corner of greatest x and y.
    pub max: [f64; 2],
}

impl Pose2 {
    /// Creates a pose, with the heading normalized to (-π, π].
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self {
            x,
            y,
            heading: wrap_angle(heading),
        }
    }

    pub(crate) fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.heading.is_finite()
    }

    /// Returns in the outer frame the pose that is `local` in the frame of this one.
    pub fn compose(self, local: Self) -> Self {
        let (sin, cos) = libm::sincos(self.heading);
        Self::new(
            self.x + cos * local.x - sin * local.y,
            self.y + sin * local.x + cos * local.y,
            self.heading + local.heading,
        )
    }

    /// Returns the pose at the end of a circular arc of `distance` metres that turns by `turn` radians. Exact
    /// for any turn.
    pub fn along_arc(self, distance: f64, turn: f64) -> Self {
        let half = turn / 2.0;
        // The chord of the arc: distance · sin(h)/h. The series is exact to the last bit where the quotient
        // is not.
        let ratio = if half.abs() < 1e-4 {
            1.0 - half * half / 6.0
        } else {
            libm::sin(half) / half
        };
        let (sin, cos) = libm::sincos(self.heading + half);
        let chord = distance * ratio;
        Self::new(self.x + chord * cos, self.y + chord * sin, self.heading + turn)
    }

    /// Returns the pose at the end of a motion at a constant twist: metres ahead and to the left in its own
    /// frame, while it turns by `turn` radians. Exact for any turn.
    pub fn along(self, [ahead, left]: [f64; 2], turn: f64) -> Self {
        if left == 0.0 {
            return self.along_arc(ahead, turn);
        }
        // The arc of a robot that faces its direction of motion.
        let facing = Self {
            heading: self.heading + libm::atan2(left, ahead),
            ..self
        };
        let end = facing.along_arc(libm::hypot(ahead, left), turn);
        Self::new(end.x, end.y, self.heading + turn)
    }

    /// Returns the distance in metres between two places, whatever their headings.
    pub fn distance(self, other: Self) -> f64 {
        libm::hypot(self.x - other.x, self.y - other.y)
    }
}

impl Twist2 {
    /// Creates a twist ahead and about the centre, from metres and radians a second.
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self {
            linear,
            lateral: 0.0,
            angular,
        }
    }

    pub(crate) fn is_finite(self) -> bool {
        self.linear.is_finite() && self.lateral.is_finite() && self.angular.is_finite()
    }
}

impl Bounds {
    /// Returns whether a point is inside or on the edge.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|axis| (self.min[axis]..=self.max[axis]).contains(&point[axis]))
    }

    pub(crate) fn around(points: impl IntoIterator<Item = [f64; 2]>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, point| {
            let bounds = bounds.unwrap_or(Self {
                min: point,
                max: point,
            });
            Some(Self {
                min: [bounds.min[0].min(point[0]), bounds.min[1].min(point[1])],
                max: [bounds.max[0].max(point[0]), bounds.max[1].max(point[1])],
            })
        })
    }
}

/// Normalizes an angle in radians to (-π, π].
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let turned = libm::fmod(angle, TAU);
    if turned > PI {
        turned - TAU
    } else if turned <= -PI {
        turned + TAU
    } else {
        turned
    }
}
