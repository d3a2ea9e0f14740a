//! What the finder says of the ball, and how long the others believe it. It sees nothing itself.

use jde_schema::prelude::*;

/// For how long a ball that is out of sight is taken to be where it was, s: a leg that passes in front of it, or a few pictures
/// in which it is no ball, change nothing.
const MEMORY: f64 = 0.3;

/// The oldest picture that anybody steers by.
const STALE: Duration = Duration::from_secs(1);

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
    pub(crate) fn is_here(&self) -> bool {
        self.distance > 0.0 && self.unseen <= MEMORY
    }

    /// How far it is along the floor, m.
    pub(crate) fn ahead(&self) -> f64 {
        self.distance * self.elevation.cos()
    }

    /// Where it is on the floor, from the camera.
    pub(crate) fn place(&self) -> Pose2D {
        let (sin, cos) = self.bearing.sin_cos();
        Pose2D::new(self.ahead() * cos, self.ahead() * sin, 0.0)
    }

    /// What the finder says; nothing if it sees nothing any more, or its picture is too old to steer by.
    pub(crate) fn read(port: &Import<Self>, cx: &Context) -> Option<Self> {
        let ball = port.get(cx)?;
        (ball.age(cx) <= STALE).then_some(*ball)
    }
}
