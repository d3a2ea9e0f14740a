//! Points, poses and velocities, and the plane geometry that mobile robots need.
//!
//! Metres, radians, seconds; axes by REP-103. Functions return angles in (−π, π].

use core::f64::consts::{PI, TAU};

use crate::{Header, Value};

/// A point in space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Point")]
pub struct Point {
    /// Ahead.
    #[value(unit = "m")]
    pub x: f64,
    /// To the left.
    #[value(unit = "m")]
    pub y: f64,
    /// Up.
    #[value(unit = "m")]
    pub z: f64,
}

/// A vector in space; its unit is that of the field that contains it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Vector3")]
pub struct Vector3 {
    /// Component ahead, or about the axis ahead.
    pub x: f64,
    /// Component to the left, or about the axis to the left.
    pub y: f64,
    /// Component up, or about the axis up.
    pub z: f64,
}

/// An orientation in space, as a quaternion. Only its direction counts: [`Quaternion::normalized`] has length 1, and one
/// of zeros is no orientation.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Quaternion")]
#[allow(missing_docs, reason = "the four parts of a quaternion")]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// A position and an orientation in space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Pose")]
pub struct Pose {
    /// Position.
    pub position: Point,
    /// Orientation.
    pub orientation: Quaternion,
}

/// A pose with its time and frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/PoseStamped")]
pub struct PoseStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// A pose with its covariance.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/PoseWithCovariance")]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// 6 × 6, row by row, for x, y, z and the rotations about them.
    pub covariance: [f64; 36],
}

/// A position in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Point2D")]
pub struct Point2D {
    /// Ahead of the frame's origin.
    #[value(unit = "m")]
    pub x: f64,
    /// Left of the frame's origin.
    #[value(unit = "m")]
    pub y: f64,
}

/// A position and a heading in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Pose2D")]
pub struct Pose2D {
    /// Ahead of the frame's origin.
    #[value(unit = "m")]
    pub x: f64,
    /// Left of the frame's origin.
    #[value(unit = "m")]
    pub y: f64,
    /// Heading, counter-clockwise from the x axis.
    #[value(unit = "rad")]
    pub theta: f64,
}

/// A velocity in space, commanded or measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Twist")]
pub struct Twist {
    /// Linear velocity, m/s.
    #[value(unit = "m/s")]
    pub linear: Vector3,
    /// Angular velocity, rad/s.
    #[value(unit = "rad/s")]
    pub angular: Vector3,
}

/// A velocity with its covariance.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/TwistWithCovariance")]
pub struct TwistWithCovariance {
    /// The velocity.
    pub twist: Twist,
    /// 6 × 6, row by row, for x, y, z and the rotations about them.
    pub covariance: [f64; 36],
}

/// Returns `angle` in (−π, π], rad.
#[must_use]
pub fn normalize_angle(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// How much the square of a length of 1 is off by rounding at most: that of single precision is not.
const ROUNDED: f64 = 1e-12;

impl Quaternion {
    /// No rotation.
    pub const IDENTITY: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    };

    /// Returns a rotation by `yaw` rad about the axis up.
    #[must_use]
    pub fn from_yaw(yaw: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw / 2.0);
        Self {
            z: sin,
            w: cos,
            ..Self::IDENTITY
        }
    }

    /// Returns the rotation of a frame with these axes, three unit vectors at right angles (Shepperd, "Quaternion from
    /// rotation matrix", 1978).
    #[must_use]
    pub fn from_axes([x, y, z]: [[f64; 3]; 3]) -> Self {
        // Four times the square of each part; the greatest is safe to divide by.
        let squares = [
            1.0 + x[0] - y[1] - z[2],
            1.0 - x[0] + y[1] - z[2],
            1.0 - x[0] - y[1] + z[2],
            1.0 + x[0] + y[1] + z[2],
        ];
        let greatest = (0..4).fold(
            0,
            |best, part| if squares[part] > squares[best] { part } else { best },
        );
        let parts = match greatest {
            0 => [squares[0], x[1] + y[0], x[2] + z[0], y[2] - z[1]],
            1 => [x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]],
            2 => [x[2] + z[0], y[2] + z[1], squares[2], x[1] - y[0]],
            _ => [y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]],
        };
        let scale = 2.0 * squares[greatest].sqrt();
        let [x, y, z, w] = parts.map(|part| part / scale);
        Self { x, y, z, w }
    }

    /// Returns the same orientation as a quaternion of length 1; `None` if it has no length or is not finite.
    #[must_use]
    pub fn normalized(&self) -> Option<Self> {
        let Self { x, y, z, w } = *self;
        // One that has that length but for rounding keeps its bits.
        if ((x * x + y * y + z * z + w * w) - 1.0).abs() < ROUNDED {
            return Some(*self);
        }
        let length = libm::hypot(libm::hypot(x, y), libm::hypot(z, w));
        (length.is_finite() && length > 0.0).then(|| Self {
            x: x / length,
            y: y / length,
            z: z / length,
            w: w / length,
        })
    }

    /// The same for the calculations here; NaN if it is no orientation, so that nobody takes the result for one.
    fn unit(&self) -> Self {
        self.normalized().unwrap_or(Self {
            x: f64::NAN,
            y: f64::NAN,
            z: f64::NAN,
            w: f64::NAN,
        })
    }

    /// Returns a vector rotated: what it is in the frame in which the rotation is stated. NaN if this is no orientation.
    #[must_use]
    pub fn rotate(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let Self { x, y, z, w } = self.unit();
        // Twice the cross product with the vector part.
        let [u, v, t] = [
            2.0 * (y * c - z * b),
            2.0 * (z * a - x * c),
            2.0 * (x * b - y * a),
        ];
        [
            a + w * u + y * t - z * v,
            b + w * v + z * u - x * t,
            c + w * t + x * v - y * u,
        ]
    }

    /// Returns the rotation of a frame that is rotated by `inner` in this one.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        let ([a, b, c], w) = ([inner.x, inner.y, inner.z], inner.w);
        Self {
            x: self.w * a + self.x * w + self.y * c - self.z * b,
            y: self.w * b + self.y * w + self.z * a - self.x * c,
            z: self.w * c + self.z * w + self.x * b - self.y * a,
            w: self.w * w - self.x * a - self.y * b - self.z * c,
        }
    }

    /// Returns the rotation back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let Self { x, y, z, w } = *self;
        Self {
            x: -x,
            y: -y,
            z: -z,
            w,
        }
    }

    /// Returns the rotation about the axis up, rad, without the rotations about the other axes; NaN if this is no
    /// orientation.
    #[must_use]
    pub fn yaw(&self) -> f64 {
        let Self { x, y, z, w } = self.unit();
        libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    }
}

/// No rotation, as in ROS 2.
impl Default for Quaternion {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl PoseWithCovariance {
    /// Returns a pose of the plane with the covariance of x, y and the heading: m², m rad and rad².
    #[must_use]
    pub fn planar(pose: Pose2D, covariance: &[[f64; 3]; 3]) -> Self {
        Self {
            pose: pose.into(),
            covariance: in_space(covariance),
        }
    }
}

/// Returns the covariance of x, y, z and the rotations about them; the plane has the first two and the last.
fn in_space(covariance: &[[f64; 3]; 3]) -> [f64; 36] {
    let mut space = [0.0; 36];
    for (row, values) in [0, 1, 5].into_iter().zip(covariance) {
        for (column, value) in [0, 1, 5].into_iter().zip(values) {
            space[6 * row + column] = *value;
        }
    }
    space
}

impl TwistWithCovariance {
    /// Returns a velocity with the covariance of the speeds ahead, to the left and of the turn: m²/s², m rad/s² and
    /// rad²/s².
    #[must_use]
    pub fn planar(twist: Twist, covariance: &[[f64; 3]; 3]) -> Self {
        Self {
            twist,
            covariance: in_space(covariance),
        }
    }
}

impl Default for PoseWithCovariance {
    fn default() -> Self {
        Self {
            pose: Pose::default(),
            covariance: [0.0; 36],
        }
    }
}

impl Default for TwistWithCovariance {
    fn default() -> Self {
        Self {
            twist: Twist::ZERO,
            covariance: [0.0; 36],
        }
    }
}

impl Twist {
    /// No motion.
    pub const ZERO: Self = Self::planar(0.0, 0.0);

    /// Returns a velocity of `linear` m/s ahead with a left turn of `angular` rad/s.
    #[must_use]
    pub const fn planar(linear: f64, angular: f64) -> Self {
        Self {
            linear: Vector3 {
                x: linear,
                y: 0.0,
                z: 0.0,
            },
            angular: Vector3 {
                x: 0.0,
                y: 0.0,
                z: angular,
            },
        }
    }
}

impl Pose2D {
    /// The frame's own origin.
    pub const ORIGIN: Self = Self::new(0.0, 0.0, 0.0);

    /// Returns a pose at `x`, `y` m with a heading of `theta` rad.
    #[must_use]
    pub const fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { x, y, theta }
    }

    /// Returns whether all three numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.theta.is_finite()
    }

    /// Returns the distance to `other`, m.
    #[must_use]
    pub fn distance_to(&self, other: &Self) -> f64 {
        libm::hypot(other.x - self.x, other.y - self.y)
    }

    /// Returns the left turn that faces `other`, rad.
    #[must_use]
    pub fn bearing_to(&self, other: &Self) -> f64 {
        normalize_angle(libm::atan2(other.y - self.y, other.x - self.x) - self.theta)
    }

    /// Transforms `local`, a pose in the frame of `self`, to the frame that `self` is in.
    #[must_use]
    pub fn transform(&self, local: &Self) -> Self {
        let (sin, cos) = libm::sincos(self.theta);
        Self::new(
            self.x + cos * local.x - sin * local.y,
            self.y + sin * local.x + cos * local.y,
            normalize_angle(self.theta + local.theta),
        )
    }

    /// Transforms `other`, a pose in the frame that `self` is in, to the frame of `self`. Inverts
    /// [`Self::transform`].
    #[must_use]
    pub fn localize(&self, other: &Self) -> Self {
        let (sin, cos) = libm::sincos(self.theta);
        let (x, y) = (other.x - self.x, other.y - self.y);
        Self::new(
            cos * x + sin * y,
            cos * y - sin * x,
            normalize_angle(other.theta - self.theta),
        )
    }
}

/// Drops height, roll and pitch.
impl From<Pose> for Pose2D {
    fn from(pose: Pose) -> Self {
        Self::new(pose.position.x, pose.position.y, pose.orientation.yaw())
    }
}

impl From<Pose2D> for Pose {
    fn from(pose: Pose2D) -> Self {
        Self {
            position: Point {
                x: pose.x,
                y: pose.y,
                z: 0.0,
            },
            orientation: Quaternion::from_yaw(pose.theta),
        }
    }
}
