//! What a person wants of a robot, and until when that counts. It tells "nothing" from "stand still".

use jde_schema::prelude::*;

/// What a person wants of a base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/DriveWish")]
pub struct Drive {
    /// How it shall move, in its own frame.
    pub twist: Twist,
    /// Whether anything is wanted of it: else nobody drives, which is not the same as standing still.
    pub wanted: Flag,
    /// Nothing.
    pub padding: Padding<7>,
}

/// What a person wants of a pan-tilt head.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/LookWish")]
pub struct Look {
    /// How fast it shall turn to the left.
    #[value(unit = "rad/s")]
    pub pan: f64,
    /// How fast it shall turn down.
    #[value(unit = "rad/s")]
    pub tilt: f64,
    /// Whether anything is wanted of it.
    pub wanted: Flag,
    /// Nothing.
    pub padding: Padding<7>,
}

impl Drive {
    /// Nothing is wanted.
    pub const NONE: Self = Self {
        twist: Twist::ZERO,
        wanted: Flag::FALSE,
        padding: Padding::ZERO,
    };

    /// To move like that.
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
    /// Nothing is wanted.
    pub const NONE: Self = Self {
        pan: 0.0,
        tilt: 0.0,
        wanted: Flag::FALSE,
        padding: Padding::ZERO,
    };

    /// To turn like that, rad/s to the left and down.
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

/// Whether a wish counts that was written at `time`: whoever still wants it writes it again before `patience` s are over.
pub(crate) fn counts(cx: &Context, wanted: Flag, time: Duration, patience: f64) -> bool {
    wanted.get() && cx.now().saturating_sub(time).as_secs_f64() <= patience
}
