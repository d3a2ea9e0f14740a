//! What a session looks for, and the motion that its owner requests.

use crate::Device;

/// Which devices a session uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Index of the base, a `position2d`.
    pub base: u16,
    /// The laser: a `ranger` of one element, or a `laser`.
    pub laser: Choice,
    /// The sonars: a `ranger` of several elements, or a `sonar`.
    pub sonars: Choice,
    /// The bumpers, a `bumper`.
    pub bumpers: Choice,
    /// The battery, a `power`.
    pub battery: Choice,
    /// The pan-tilt unit, a `ptz`.
    pub head: Choice,
}

/// How to choose a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The first suitable one, if there is one.
    #[default]
    Auto,
    /// None.
    None,
    /// This one, which the server must have.
    Device(Device),
}

/// The motion that the application requests at present. A number that is not finite counts as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Speeds ahead and to the left, m/s, and turn rate, rad/s counter-clockwise.
    pub velocity: [f64; 3],
    /// The head.
    pub head: HeadSetpoint,
}

/// The position of the head that the application requests, and the speeds to get there. An axis with speed 0
/// stays where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadSetpoint {
    /// To the left and upwards, rad.
    pub angles: [f32; 2],
    /// Speeds, rad/s; their signs are ignored.
    pub speeds: [f32; 2],
}
