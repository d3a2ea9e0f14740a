//! The output of a session for its owner: its state, the robot that was found, and the robot's data.

use core::fmt;

use crate::{Base, Device, Head, Mount, Power, Scan};

/// The state of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// It asks the server for its devices and subscribes to them.
    Opening,
    /// The robot can be driven.
    Connected,
    /// The connection is useless, for this reason. Start again with a new connection.
    Lost(String),
}

/// The devices that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// The server's version.
    pub version: String,
    /// The base.
    pub base: Device,
    /// Name of the driver of the base in the server.
    pub driver: String,
    /// The laser.
    pub laser: Option<Laser>,
    /// The sonars.
    pub sonars: Option<Ring>,
    /// The bumpers, and their places; no places if the server does not report them.
    pub bumpers: Option<(Device, Vec<Mount>)>,
    /// The battery.
    pub battery: Option<Device>,
    /// The pan-tilt unit.
    pub head: Option<Device>,
}

/// A laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laser {
    /// The device.
    pub device: Device,
    /// Its place.
    pub mount: Mount,
    /// Angles of the first and the last beam, rad, and least and greatest range, m, if they are not part of
    /// its data.
    pub(crate) limits: Option<[f64; 4]>,
}

/// An array of sonars.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The device.
    pub device: Device,
    /// The place of each sonar.
    pub mounts: Vec<Mount>,
    /// The angle that a sonar covers, rad; 0 if the server does not report it.
    pub view: f64,
    /// Least range, m; 0 if the server does not report it.
    pub range_min: f64,
    /// Greatest range, m; 0 if the server does not report it.
    pub range_max: f64,
}

/// Data from a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The robot can be driven.
    Ready(Box<Robot>),
    /// State of the base.
    Base(Base),
    /// A scan of the laser.
    Laser(Scan),
    /// Ranges of the sonars, m, in the order of their places.
    Sonars(Vec<f64>),
    /// Which bumpers are pressed, in the order of their places.
    Bumpers(Vec<bool>),
    /// State of the battery.
    Battery(Power),
    /// State of the pan-tilt unit.
    Head(Head),
    /// The description of a problem that does not end the session.
    Warning(String),
}

/// The server, and the devices that are used.
impl fmt::Display for Robot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Player {}, {} ({})", self.version, self.base, self.driver)?;
        if let Some(laser) = &self.laser {
            let Mount { x, y, yaw } = laser.mount;
            let degrees = yaw.to_degrees();
            write!(f, ", laser {} at {x:.2}, {y:.2} m, {degrees:.0}°", laser.device)?;
        }
        if let Some(sonars) = &self.sonars {
            write!(f, ", {} sonars {}", sonars.mounts.len(), sonars.device)?;
        }
        let bumpers = self.bumpers.as_ref().map(|(device, _)| *device);
        for device in [bumpers, self.battery, self.head].into_iter().flatten() {
            write!(f, ", {device}")?;
        }
        Ok(())
    }
}
