//! The settings of a session, and the setpoints of an application.

use crate::Model;

/// The settings of a session.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The robot's model; `None` for the one that the robot reports.
    pub model: Option<Model>,
    /// The laser in the stream of packets, as simulators send it.
    pub laser: LaserMode,
    /// The pan-tilt head at the first auxiliary port.
    pub head: HeadKind,
    /// The pose of the robot at the start, in the frame of the odometry.
    pub start: crate::Pose,
}

/// Whether to request a laser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LaserMode {
    /// Never.
    #[default]
    Off,
    /// If the robot reports that it is a simulator.
    Auto(Beams),
    /// Always.
    On(Beams),
}

/// The beams of a laser, in the units of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beams {
    /// Angle of the first beam, degrees counter-clockwise from ahead.
    pub start_deg: i16,
    /// Angle of the last beam, degrees.
    pub end_deg: i16,
    /// Angle between beams, 0.01 degrees.
    pub increment_centideg: u16,
}

/// The kind of pan-tilt head.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeadKind {
    /// None.
    #[default]
    None,
    /// A Canon VC-C4 that replies. If it does not reply, it is treated as one that cannot.
    VcC4,
    /// A Canon VC-C4 without a wire for its replies.
    VcC4OneWay,
}

/// The motion that the application requests at present.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Speed ahead, m/s.
    pub linear: f64,
    /// Turn rate, rad/s counter-clockwise.
    pub angular: f64,
    /// The setpoint of the head.
    pub head: HeadSetpoint,
}

/// The requested angles of a head, and the speeds to reach them. An axis without a speed stays at its angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadSetpoint {
    /// To the left, rad.
    pub pan: f64,
    /// Down, rad.
    pub tilt: f64,
    /// Pan speed, rad/s.
    pub pan_speed: f64,
    /// Tilt speed, rad/s.
    pub tilt_speed: f64,
}

impl Beams {
    /// Returns beams from `-view / 2`, each `view / beams` rad from the one before, as near as the protocol's
    /// whole degrees and hundredths allow.
    #[must_use]
    pub fn spread(beams: u32, view: f64) -> Self {
        let (view, beams) = (view.to_degrees(), f64::from(beams.max(1)));
        let step = view / beams;
        Self {
            start_deg: (-view / 2.0).round() as i16,
            end_deg: (step * (beams - 1.0) - view / 2.0).round() as i16,
            increment_centideg: (step * 100.0).round().max(1.0) as u16,
        }
    }
}
