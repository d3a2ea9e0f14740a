//! The wish of a person, and how long it counts. "No wish" differs from "stand still".

use jde_schema::prelude::*;

/// The wish of a person for a base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/DriveWish")]
pub struct Drive {
    /// The wished motion, in the frame of the base.
    pub twist: Twist,
    /// Whether there is a wish. False means that no person drives, which differs from standing still.
    pub wanted: Flag,
    /// Unused.
    pub padding: Padding<7>,
}

/// The wish of a person for a pan-tilt head.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/LookWish")]
pub struct Look {
    /// Wished turn rate, positive to the left.
    #[value(unit = "rad/s")]
    pub pan: f64,
    /// Wished turn rate, positive downward.
    #[value(unit = "rad/s")]
    pub tilt: f64,
    /// Whether there is a wish.
    pub wanted: Flag,
    /// Unused.
    pub padding: Padding<7>,
}

impl Drive {
    /// No wish.
    pub const NONE: Self = Self {
        twist: Twist::ZERO,
        wanted: Flag::FALSE,
        padding: Padding::ZERO,
    };

    /// A wish to move with this twist.
    #[must_use]
    pub const fn at(twist: Twist) -> Self {
        Self {
            twist,
            wanted: Flag::TRUE,
            padding: Padding::ZERO,
        }
    }
}

impl Look {
    /// No wish.
    pub const NONE: Self = Self {
        pan: 0.0,
        tilt: 0.0,
        wanted: Flag::FALSE,
        padding: Padding::ZERO,
    };

    /// A wish to turn at these rates, rad/s to the left and down.
    #[must_use]
    pub const fn at(pan: f64, tilt: f64) -> Self {
        Self {
            pan,
            tilt,
            wanted: Flag::TRUE,
            padding: Padding::ZERO,
        }
    }
}

/// Whether a wish that was written at `time` counts, which it does for `patience` s. An operator renews it
/// before then.
pub(crate) fn is_in_force(cx: &Context, wanted: Flag, time: Duration, patience: f64) -> bool {
    wanted.get() && cx.now().saturating_sub(time).as_secs_f64() <= patience
}
