//! The position of a ball: a value that several plugins share. Plugins in Rust depend on this crate. Plugins
//! in C include its twin, `c/ball.h`. `schemas/ball` publishes the value, and `c/near.c` is a plugin in C
//! that reads it. `runtime/host/tests/it/shared_value.rs` checks that the two definitions agree. The crate
//! defines no schema and does not depend on the SDK.

use jde_types::{Flag, Header, Padding, Pose2D, Value};

/// How long a ball that is out of sight keeps its last position, s. A leg that passes in front of it, or a
/// few pictures without a detection, change nothing.
const MEMORY: f64 = 0.3;

/// The position of a ball as the robot sees it.
///
/// Angles are in the frame of the base, or of the camera if the finder has no pan-tilt head. While the ball
/// is not seen, all fields but `header`, `seen`, `count` and `unseen` keep their last values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Ball")]
pub struct Ball {
    /// Time at which the picture was taken, and the frame of the angles.
    pub header: Header,
    /// Whether the ball is in the picture.
    pub seen: Flag,
    /// Unused.
    pub padding: Padding<3>,
    /// Pixels of the ball in the picture.
    pub count: u32,
    /// Time since the ball was last seen, or since the first picture if it never was.
    #[value(unit = "s")]
    pub unseen: f64,
    /// Angle to the ball, positive to the left.
    #[value(unit = "rad")]
    pub bearing: f64,
    /// Angle to the ball above the horizon.
    #[value(unit = "rad")]
    pub elevation: f64,
    /// Distance from the camera to the middle of the ball; 0 until the ball has been seen.
    #[value(unit = "m")]
    pub distance: f64,
    /// Column of the ball's middle in the picture, from the left edge.
    #[value(unit = "px")]
    pub column: f64,
    /// Row of the ball's middle in the picture, from the upper edge.
    #[value(unit = "px")]
    pub row: f64,
}

impl Ball {
    /// Whether the position is known: the ball is seen, or was seen within the last 0.3 s. Otherwise it is
    /// lost.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.distance > 0.0 && self.unseen <= MEMORY
    }

    /// Distance along the floor, m.
    #[must_use]
    pub fn ahead(&self) -> f64 {
        self.distance * libm::cos(self.elevation)
    }

    /// Position on the floor relative to the camera, m.
    #[must_use]
    pub fn place(&self) -> Pose2D {
        let (sin, cos) = libm::sincos(self.bearing);
        Pose2D::new(self.ahead() * cos, self.ahead() * sin, 0.0)
    }
}
