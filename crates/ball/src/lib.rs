//! Where a ball is: a value that several plugins share. It is defined here once; plugins in Rust depend on this crate, and those in C
//! include its twin, `c/ball.h`. `schemas/ball` publishes it, `c/near.c` is a plugin in C that reads it, and
//! `crates/host/tests/shared_value.rs` holds the two definitions together. It needs no schema, so it needs no SDK.

use jde_types::{Flag, Header, Padding, Pose2D, Value};

/// For how long a ball that is out of sight is taken to be where it was, s: a leg that passes in front of it, or a few pictures
/// in which it is no ball, change nothing.
const MEMORY: f64 = 0.3;

/// Where a ball is, as the robot sees it.
///
/// Angles are in the frame of the base, or of the camera if the finder knows no pan-tilt head. While the ball is not seen, all
/// but `seen`, `count` and `unseen` is as when it was seen last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Ball")]
pub struct Ball {
    /// When the picture was taken, and the frame of the angles.
    pub header: Header,
    /// Whether it is in the picture.
    pub seen: Flag,
    /// Nothing.
    pub padding: Padding<3>,
    /// Pixels it has in the picture.
    pub count: u32,
    /// For how long it has not been seen; since the first picture if it never was.
    #[value(unit = "s")]
    pub unseen: f64,
    /// To the left.
    #[value(unit = "rad")]
    pub bearing: f64,
    /// Up, from the horizon.
    #[value(unit = "rad")]
    pub elevation: f64,
    /// From the camera to the middle of the ball; 0 until it has been seen.
    #[value(unit = "m")]
    pub distance: f64,
    /// Column of its middle in the picture, from the left edge.
    #[value(unit = "px")]
    pub column: f64,
    /// Row of its middle in the picture, from the upper edge.
    #[value(unit = "px")]
    pub row: f64,
}

impl Ball {
    /// Whether it is known where it is: it is seen, or was a moment ago. If not, it is lost.
    #[must_use]
    pub fn is_here(&self) -> bool {
        self.distance > 0.0 && self.unseen <= MEMORY
    }

    /// How far it is along the floor, m.
    #[must_use]
    pub fn ahead(&self) -> f64 {
        self.distance * self.elevation.cos()
    }

    /// Where it is on the floor, from the camera.
    #[must_use]
    pub fn place(&self) -> Pose2D {
        let (sin, cos) = self.bearing.sin_cos();
        Pose2D::new(self.ahead() * cos, self.ahead() * sin, 0.0)
    }
}
