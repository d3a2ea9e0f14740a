//! Robots that a file describes: body, motors and sensors.
//!
//! `file/robot.rs` reads them. A model has no pose and no driver.

use std::path::Path;
use std::time::Duration;

use crate::config::RobotConfig;
use crate::error::WorldError;
use crate::file;
use crate::sensor::{Delivery, ImuConfig, LaserConfig, LineSensorConfig, PositionConfig, SonarConfig};
use crate::shipped::SHIPPED_ROBOTS;

/// A robot as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// The name in the file, or the stem of the file's name.
    pub name: String,
    /// One sentence about it; may be empty.
    pub doc: String,
    /// Body, motors, wheels and head. Without a head, the head is that of the default.
    pub config: RobotConfig,
    /// How the measurements of its wheels arrive.
    pub odometry: Delivery,
    /// Its lasers, in the order of the file. Each has its own noise.
    pub lasers: Vec<LaserModel>,
    /// Its ring of sonars, if it has one.
    pub sonars: Option<SampledSensor<SonarConfig>>,
    /// Its line sensor, if it has one.
    pub line_sensor: Option<SampledSensor<LineSensorConfig>>,
    /// Its inertial measurement unit, if it has one.
    pub imu: Option<SampledSensor<ImuConfig>>,
    /// Its position sensor, if it has one.
    pub position: Option<SampledSensor<PositionConfig>>,
    /// Whether it has bumpers, those of a [`crate::Bumpers`].
    pub bumpers: bool,
    /// Whether it has a pan-tilt head.
    pub head: bool,
    /// Whether it has a battery, that of a [`crate::Battery`].
    pub battery: bool,
    /// Its masses and wheels, if the file states them.
    pub physics: Option<Physics>,
}

/// What a simulator of bodies and forces needs to know of a robot. A [`crate::World`] needs none of it.
///
/// Metres in the robot's frame, z from the floor; kilograms; newtons.
#[derive(Clone, Debug, PartialEq)]
pub struct Physics {
    /// Of the whole robot.
    pub mass: f64,
    /// The top of its body.
    pub height: f64,
    /// Its centre of mass.
    pub center: [f64; 3],
    /// Radius of the driven wheels.
    pub wheel_radius: f64,
    /// Width of their tyres.
    pub wheel_width: f64,
    /// Their places: those with a y above 0 are the left ones.
    pub wheels: Vec<[f64; 2]>,
    /// Places where it rests on a caster or a skid.
    pub casters: Vec<[f64; 2]>,
    /// Greatest torque of a wheel in N m.
    pub torque: f64,
    /// Coefficient of friction of the tyres on the floor.
    pub friction: f64,
    /// The factor by which the controller drives its wheels faster in turns than their distance says, because they
    /// skid: `wheel_separation_multiplier` of `diff_drive_controller`.
    pub track_multiplier: f64,
}

/// A laser on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserModel {
    /// Its name, unique on the robot.
    pub name: String,
    /// Place, beams, range and noise.
    pub config: LaserConfig,
    /// The time between two scans; `None` for that of whoever reads it.
    pub period: Option<Duration>,
    /// How its scans arrive.
    pub delivery: Delivery,
}

/// A sensor on a robot that is read at times.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledSensor<C> {
    /// Places, limits and noise.
    pub config: C,
    /// The time between two measurements; `None` for that of whoever reads it.
    pub period: Option<Duration>,
    /// How its measurements arrive.
    pub delivery: Delivery,
}

impl RobotModel {
    /// Returns the robot of a file, if the text ends with `.toml`, or else the shipped one of that name.
    ///
    /// # Errors
    /// All faults of the file, each with its line; a name of no shipped robot.
    pub fn find(model: &str) -> Result<Self, WorldError> {
        if model.ends_with(".toml") {
            return Self::load(model);
        }
        match SHIPPED_ROBOTS.iter().find(|(known, _)| model == *known) {
            Some((name, text)) => Self::parse(text, name),
            None => Err(WorldError::UnknownModel {
                name: model.to_owned(),
            }),
        }
    }

    /// Reads a robot's file.
    ///
    /// # Errors
    /// All faults of the file, each with its line.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, WorldError> {
        let path = path.as_ref();
        Self::parse(&file::load(path, "robot")?, path)
    }

    /// Creates a robot from the text of its file. `path` names it in errors.
    ///
    /// # Errors
    /// All faults of the text, each with its line.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, WorldError> {
        Ok(file::read_robot(text, path.as_ref())?)
    }
}
