//! What an application wants of a robot before and while it is connected.

use crate::Model;

/// What a session is told at its beginning.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Of which model the robot is; `None` for the one it says it is.
    pub model: Option<Model>,
    /// The laser in the stream of packets, which simulators have.
    pub laser: Laser,
    /// The pan-tilt head at the first auxiliary port.
    pub head: Head,
    /// Where the robot stands in the frame of the odometry.
    pub start: crate::Pose,
}

/// Whether to ask for a laser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Laser {
    /// No.
    #[default]
    Off,
    /// If the robot says that it is a simulator.
    Auto(Beams),
    /// Whatever it says.
    On(Beams),
}

/// The beams of a laser, in the units of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beams {
    /// Angle of the first, degrees counter-clockwise from ahead.
    pub start_deg: i16,
    /// Angle of the last, degrees.
    pub end_deg: i16,
    /// From one to the next, 0.01 degrees.
    pub increment_centideg: u16,
}

/// Which pan-tilt head there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Head {
    /// None.
    #[default]
    None,
    /// A Canon VC-C4 that answers; if it does not, it is spoken to as one that cannot.
    VcC4,
    /// A Canon VC-C4 whose answers have no wire to come back by.
    VcC4OneWay,
}

/// What the application wants now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// Speed ahead, m/s.
    pub linear: f64,
    /// Speed of turning, rad/s counter-clockwise.
    pub angular: f64,
    /// Where the head shall look.
    pub head: HeadWish,
}

/// Where a head shall look, and how fast it may turn there; an axis without speed stays where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadWish {
    /// To the left, rad.
    pub pan: f64,
    /// Down, rad.
    pub tilt: f64,
    /// Greatest speed of panning, rad/s.
    pub pan_speed: f64,
    /// Greatest speed of tilting, rad/s.
    pub tilt_speed: f64,
}

impl Beams {
    /// As many beams, the first at `-view / 2`, each `view / beams` rad from the one before, as near as the
    /// protocol's whole degrees allow.
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
