//! Where the sensors are on the robot.

use crate::data::reader;
use crate::wire::FixedValue;
use crate::{Error, Message};

/// A place on the robot, in the frame of its base; height, roll and pitch are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mount {
    /// Ahead, m.
    pub x: f64,
    /// To the left, m.
    pub y: f64,
    /// Direction counter-clockwise from ahead, rad.
    pub yaw: f64,
}

/// The place of a bumper.
struct Bumper(Mount);

/// The places of a ranger: its own, and those of its elements on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RangerGeometry {
    pub(crate) mount: Mount,
    pub(crate) elements: Vec<Mount>,
}

/// Six numbers: x, y, z, roll, pitch, yaw.
impl FixedValue for Mount {
    const SIZE: usize = 48;

    fn read(bytes: &[u8]) -> Self {
        let number = |index: usize| f64::read(&bytes[8 * index..8 * index + 8]);
        Self {
            x: number(0),
            y: number(1),
            yaw: number(5),
        }
    }
}

/// A pose, then length and radius.
impl FixedValue for Bumper {
    const SIZE: usize = Mount::SIZE + 8;

    fn read(bytes: &[u8]) -> Self {
        Self(Mount::read(&bytes[..Mount::SIZE]))
    }
}

impl Mount {
    /// Returns a place on the device at this mount as a place on the robot.
    #[must_use]
    pub(crate) fn transform(&self, local: &Self) -> Self {
        let (sin, cos) = libm::sincos(self.yaw);
        Self {
            x: self.x + cos * local.x - sin * local.y,
            y: self.y + sin * local.x + cos * local.y,
            yaw: self.yaw + local.yaw,
        }
    }
}

pub(crate) fn ranger(message: &Message) -> Result<RangerGeometry, Error> {
    let mut reader = reader(message);
    let mount = reader.get("pose")?;
    for _ in 0..3 {
        reader.get::<f64>("size")?;
    }
    let elements = reader.array("elements")?;
    Ok(RangerGeometry { mount, elements })
}

pub(crate) fn laser(message: &Message) -> Result<Mount, Error> {
    reader(message).get("pose")
}

pub(crate) fn sonar(message: &Message) -> Result<Vec<Mount>, Error> {
    reader(message).array("poses")
}

pub(crate) fn bumpers(message: &Message) -> Result<Vec<Mount>, Error> {
    let bumpers: Vec<Bumper> = reader(message).array("bumpers")?;
    Ok(bumpers.into_iter().map(|bumper| bumper.0).collect())
}
