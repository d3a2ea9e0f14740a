//! Times and frames, with which every stamped interface begins.

use core::time::Duration;

use crate::{Text, Value};

/// The name of a frame of coordinates (REP-105: "map", "odom", "base_link").
pub type Frame = Text<52>;

/// A time, in seconds and nanoseconds since the application's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Value)]
#[repr(C)]
#[value(name = "builtin_interfaces/msg/Time")]
pub struct Time {
    /// Whole seconds.
    #[value(unit = "s")]
    pub sec: i32,
    /// Remaining nanoseconds, below 10^9.
    #[value(unit = "ns")]
    pub nanosec: u32,
}

/// Time and frame of a measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "std_msgs/msg/Header")]
pub struct Header {
    /// Time of the measurement.
    pub stamp: Time,
    /// Frame of the coordinates.
    pub frame_id: Frame,
}

impl Header {
    /// Returns a header with this time and frame. A name that does not fit is cut.
    #[must_use]
    pub fn new(stamp: impl Into<Time>, frame: &str) -> Self {
        Self {
            stamp: stamp.into(),
            frame_id: Frame::truncated(frame),
        }
    }
}

/// A duration beyond 68 years becomes the largest time.
impl From<Duration> for Time {
    fn from(time: Duration) -> Self {
        match i32::try_from(time.as_secs()) {
            Ok(sec) => Self {
                sec,
                nanosec: time.subsec_nanos(),
            },
            Err(_) => Self {
                sec: i32::MAX,
                nanosec: 999_999_999,
            },
        }
    }
}

/// A time before the start becomes zero.
impl From<Time> for Duration {
    fn from(time: Time) -> Self {
        match u64::try_from(time.sec) {
            Ok(sec) => Self::from_secs(sec) + Self::from_nanos(u64::from(time.nanosec)),
            Err(_) => Self::ZERO,
        }
    }
}
