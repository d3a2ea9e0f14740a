//! The standard interfaces of sensors and actuators, and what makes a structure a value that schemas can share.
//!
//! Units are SI and axes follow ROS REP-103 (x ahead, y left, z up, counter-clockwise positive). A standard type has the name
//! and the fields of its ROS 2 interface; ours are under `jde_msgs`. Nothing here computes behaviour.

extern crate self as jde_types;

mod geometry;
mod mission;
mod nav;
mod padding;
mod part;
mod range;
mod scalar;
mod sensor;
mod seq;
mod stamp;
mod text;
mod value;

pub use geometry::{
    Point, Pose, Pose2D, PoseStamped, PoseWithCovariance, Quaternion, Twist, TwistWithCovariance, Vector3,
    normalize_angle,
};
pub use jde_macros::Value;
pub use mission::{Mission, Truth};
pub use nav::{Odometry, Path, Route, Target};
pub use padding::{Flag, Padding};
pub use part::{Part, Shape};
pub use range::{LaserPoint, LaserScan, Range, RangeRing, SonarEcho};
pub use sensor::{BatteryState, Bumpers, Image, PanTilt};
pub use seq::Seq;
pub use stamp::{Frame, Header, Time};
pub use text::{Text, TooLong};
pub use value::Value;

/// What the derive macro writes in terms of; not for people.
#[doc(hidden)]
pub mod derived {
    pub use crate::part::{Part, Shape, field};
    pub use crate::value::{Value, structure};
    pub use jde_abi::raw;
}
