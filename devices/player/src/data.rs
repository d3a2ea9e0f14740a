//! The data of devices.

use crate::wire::Reader;
use crate::{Error, Message};

/// The state of a base, in the frame of its odometry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Base {
    /// Position, m, m, and heading, rad counter-clockwise.
    pub pose: [f64; 3],
    /// Speeds ahead and to the left, m/s, and turn rate, rad/s.
    pub velocity: [f64; 3],
    /// Whether the motors are blocked.
    pub stalled: bool,
}

/// The scan of a laser, from right to left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// Angle of the first beam, rad.
    pub angle_min: f64,
    /// Angle of the last beam, rad.
    pub angle_max: f64,
    /// Least range, m; 0 if the server does not report it.
    pub range_min: f64,
    /// Greatest range, m; 0 if the server does not report it.
    pub range_max: f64,
    /// Ranges, m.
    pub ranges: Vec<f64>,
}

/// The state of a battery; `None` for what it does not measure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power {
    /// Voltage, V.
    pub volts: Option<f32>,
    /// Charge, from 0 to 100.
    pub percent: Option<f32>,
    /// Stored energy, J.
    pub joules: Option<f32>,
    /// Power, W; negative while discharging.
    pub watts: Option<f32>,
    /// 1 while it is charged, -1 while it charges another device, 0 otherwise.
    pub charging: Option<i32>,
}

/// The state of a pan-tilt unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Head {
    /// Angle to the left, rad.
    pub pan: f32,
    /// Angle upwards, rad.
    pub tilt: f32,
    /// Field of view, rad.
    pub zoom: f32,
    /// Angular velocity to the left, rad/s.
    pub pan_speed: f32,
    /// Angular velocity upwards, rad/s.
    pub tilt_speed: f32,
}

/// The limits of a ranger, in the order of its reply: least and greatest angle, resolution, least and
/// greatest range.
pub(crate) type RangerConfig = [f64; 5];

fn fields<const N: usize>(reader: &mut Reader<'_>, what: &'static str) -> Result<[f64; N], Error> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = reader.get(what)?;
    }
    Ok(numbers)
}

pub(crate) fn base(message: &Message) -> Result<Base, Error> {
    let mut reader = reader(message);
    Ok(Base {
        pose: fields(&mut reader, "pose")?,
        velocity: fields(&mut reader, "velocity")?,
        stalled: reader.flag("stall")?,
    })
}

/// The scan of the interface `laser`.
pub(crate) fn laser(message: &Message) -> Result<Scan, Error> {
    let mut reader = reader(message);
    let mut number = || reader.get::<f32>("angles").map(f64::from);
    let (angle_min, angle_max, _resolution, range_max) = (number()?, number()?, number()?, number()?);
    let ranges = reader
        .array::<f32>("ranges")?
        .into_iter()
        .map(f64::from)
        .collect();
    Ok(Scan {
        angle_min,
        angle_max,
        range_min: 0.0,
        range_max,
        ranges,
    })
}

/// The ranges of the interface `ranger`.
pub(crate) fn ranger(message: &Message) -> Result<Vec<f64>, Error> {
    reader(message).array("ranges")
}

pub(crate) fn ranger_config(message: &Message) -> Result<RangerConfig, Error> {
    fields(&mut reader(message), "configuration")
}

/// The ranges of the interface `sonar`.
pub(crate) fn sonar(message: &Message) -> Result<Vec<f64>, Error> {
    let ranges = reader(message).array::<f32>("ranges")?;
    Ok(ranges.into_iter().map(f64::from).collect())
}

pub(crate) fn bumpers(message: &Message) -> Result<Vec<bool>, Error> {
    let states = reader(message).bytes("bumpers")?;
    Ok(states.iter().map(|state| *state != 0).collect())
}

pub(crate) fn head(message: &Message) -> Result<Head, Error> {
    let mut reader = reader(message);
    Ok(Head {
        pan: reader.get("pan")?,
        tilt: reader.get("tilt")?,
        zoom: reader.get("zoom")?,
        pan_speed: reader.get("speeds")?,
        tilt_speed: reader.get("speeds")?,
    })
}

pub(crate) fn power(message: &Message) -> Result<Power, Error> {
    let mut reader = reader(message);
    let valid: u32 = reader.get("mask")?;
    let is_valid = |bit: u32| valid & bit != 0;
    let mut number = |bit: u32| -> Result<Option<f32>, Error> {
        let number = reader.get("battery")?;
        Ok(is_valid(bit).then_some(number))
    };
    let (volts, percent, joules, watts) = (number(1)?, number(8)?, number(4)?, number(2)?);
    let charging = reader.get("charging")?;
    Ok(Power {
        volts,
        percent,
        joules,
        watts,
        charging: is_valid(16).then_some(charging),
    })
}

pub(crate) fn reader(message: &Message) -> Reader<'_> {
    Reader::new(message.device, &message.body)
}
