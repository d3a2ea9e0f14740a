//! The data of a model of robot: units, body, limits, sonars. They come from TOML files; none is computed
//! from the robot's replies.

use core::f64::consts::TAU;

use serde::Deserialize;

/// The models of the library: name, text of the file.
const KNOWN: [(&str, &str); 7] = [
    ("p3dx", include_str!("../models/p3dx.toml")),
    ("p3dx-sh", include_str!("../models/p3dx-sh.toml")),
    ("p3at", include_str!("../models/p3at.toml")),
    ("p3at-sh", include_str!("../models/p3at-sh.toml")),
    ("p2dx", include_str!("../models/p2dx.toml")),
    ("amigo", include_str!("../models/amigo.toml")),
    ("amigo-sh", include_str!("../models/amigo-sh.toml")),
];

/// A model of robot. A number is in the unit that its name ends with, in the frame of the base: x ahead, y
/// left.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Its name in this library.
    pub name: String,
    /// The class that such robots report.
    pub class: String,
    /// The subclasses that such robots report.
    pub subclasses: Vec<String>,
    /// The units of its numbers.
    pub units: Units,
    /// Its dimensions.
    pub body: Body,
    /// Its greatest speeds.
    pub limits: SpeedLimits,
    /// Its sonars.
    pub sonar: Sonars,
    /// Its numbers of bumpers.
    pub bumpers: Bumpers,
    /// Its encoders.
    pub encoders: Ticks,
    /// Its battery.
    pub battery: Battery,
    /// The usual place of its laser.
    pub laser: LaserMount,
}

/// The units of a robot's numbers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Units of angle in a whole turn.
    pub angle_per_turn: f64,
    /// One unit of position.
    pub distance_mm: f64,
    /// One unit of a wheel's speed.
    pub velocity_mm_s: f64,
    /// One unit of a sonar's range.
    pub range_mm: f64,
    /// Turn rate, rad/s, for a difference of 2 mm/s between the wheels.
    pub wheel_difference: f64,
    /// Bits after which positions wrap. A number below the robot's own also works, as long as the robot does
    /// not drive half of that range between two SIPs.
    pub position_bits: u32,
}

/// The dimensions of a robot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Front to rear.
    pub length_mm: f64,
    /// Side to side.
    pub width_mm: f64,
    /// Radius of the circle in which it turns.
    pub radius_mm: f64,
}

/// The greatest speeds of a robot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimits {
    /// Speed.
    pub velocity_mm_s: f64,
    /// Turn rate.
    pub rotation_deg_s: f64,
}

/// A robot's sonars.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sonars {
    /// Width of the cone.
    pub cone_deg: f64,
    /// Least range.
    pub min_mm: f64,
    /// Ranges from here on mean no echo.
    pub max_mm: f64,
    /// The mounts, in the order of the robot's numbers: mm ahead, mm to the left, and heading in degrees.
    pub mounts: Vec<[f64; 3]>,
}

/// The greatest numbers of bumpers of a robot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bumpers {
    /// Front, at most 7.
    pub front: usize,
    /// Rear, at most 7.
    pub rear: usize,
}

/// The resolution of a robot's encoders.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ticks {
    /// Ticks while a wheel rolls one millimetre; 0 if unknown; then the robot's own report is used.
    pub per_mm: f64,
}

/// A robot's battery.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Battery {
    /// Nominal voltage.
    pub nominal_v: f64,
    /// Voltage of an empty battery, to estimate the charge of a battery that does not report it.
    pub empty_v: f64,
    /// Voltage of a full battery.
    pub full_v: f64,
}

/// The usual place of a laser.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaserMount {
    /// Ahead.
    pub x_mm: f64,
    /// To the left.
    pub y_mm: f64,
}

/// Why a model could not be loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// No model has this name.
    #[error(
        "there is no model `{name}`; expected one of {}, or the path of a model file",
        names()
    )]
    Unknown {
        /// The name.
        name: String,
    },
    /// A file has an invalid form, or an invalid number.
    #[error("{file}:{line}: {message}")]
    File {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The key, what is wrong with it, and what was expected.
        message: String,
    },
}

impl Model {
    /// Returns a model of the library by its name, in any case.
    ///
    /// # Errors
    /// If there is none of this name. The message lists the known names.
    pub fn named(name: &str) -> Result<Self, ModelError> {
        let known = KNOWN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let (name, text) = known.ok_or_else(|| ModelError::Unknown {
            name: name.to_owned(),
        })?;
        Self::parse(text, name)
    }

    /// Returns the model of the robots that report this subclass, in any case.
    ///
    /// # Errors
    /// If no model has this subclass.
    pub fn of_subclass(subclass: &str) -> Result<Self, ModelError> {
        for (name, text) in KNOWN {
            let model = Self::parse(text, name)?;
            if model
                .subclasses
                .iter()
                .any(|known| known.eq_ignore_ascii_case(subclass))
            {
                return Ok(model);
            }
        }
        let name = subclass.to_owned();
        Err(ModelError::Unknown { name })
    }

    /// Parses the text of a model file; `file` is its name in errors.
    ///
    /// # Errors
    /// If its form or a number is invalid, with the line and the key.
    pub fn parse(text: &str, file: &str) -> Result<Self, ModelError> {
        let model: Self = toml::from_str(text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            let source = text.lines().nth(line - 1).unwrap_or_default().trim();
            let message = format!("`{source}`: {}", error.message());
            let file = file.to_owned();
            ModelError::File { file, line, message }
        })?;
        match model.fault() {
            None => Ok(model),
            Some((section, key, expected)) => Err(ModelError::File {
                file: file.to_owned(),
                line: line_of(text, section, key),
                message: format!("`{section}.{key}`: expected {expected}"),
            }),
        }
    }

    /// Returns the names of the models of the library.
    pub fn names() -> impl Iterator<Item = &'static str> {
        KNOWN.into_iter().map(|(name, _)| name)
    }

    /// Converts an angle of the robot to rad.
    #[must_use]
    pub fn angle(&self, units: i16) -> f64 {
        f64::from(units) * TAU / self.units.angle_per_turn
    }

    /// Returns the first invalid number: section, key, what was expected.
    fn fault(&self) -> Option<(&'static str, &'static str, &'static str)> {
        const POSITIVE: &str = "a number greater than 0";
        let positive = [
            ("units", "angle_per_turn", self.units.angle_per_turn),
            ("units", "distance_mm", self.units.distance_mm),
            ("units", "velocity_mm_s", self.units.velocity_mm_s),
            ("units", "range_mm", self.units.range_mm),
            ("units", "wheel_difference", self.units.wheel_difference),
            ("body", "length_mm", self.body.length_mm),
            ("body", "width_mm", self.body.width_mm),
            ("body", "radius_mm", self.body.radius_mm),
            ("limits", "velocity_mm_s", self.limits.velocity_mm_s),
            ("limits", "rotation_deg_s", self.limits.rotation_deg_s),
            ("sonar", "cone_deg", self.sonar.cone_deg),
            ("sonar", "max_mm", self.sonar.max_mm),
            ("battery", "nominal_v", self.battery.nominal_v),
            ("battery", "full_v", self.battery.full_v - self.battery.empty_v),
        ];
        let not_positive = positive
            .into_iter()
            .find(|(_, _, value)| !(value.is_finite() && *value > 0.0));
        if let Some((section, key, _)) = not_positive {
            let expected = if key == "full_v" {
                "more than `empty_v`"
            } else {
                POSITIVE
            };
            return Some((section, key, expected));
        }
        let mounts = self
            .sonar
            .mounts
            .iter()
            .flatten()
            .all(|number| number.is_finite());
        let checks = [
            (
                ("units", "position_bits", "8 to 16"),
                (8..=16).contains(&self.units.position_bits),
            ),
            (
                ("sonar", "min_mm", "0 to `max_mm`"),
                (0.0..self.sonar.max_mm).contains(&self.sonar.min_mm),
            ),
            (
                ("sonar", "mounts", "at most 32 of three finite numbers"),
                mounts && self.sonar.mounts.len() <= 32,
            ),
            (("bumpers", "front", "0 to 7"), self.bumpers.front <= 7),
            (("bumpers", "rear", "0 to 7"), self.bumpers.rear <= 7),
            (
                ("encoders", "per_mm", "a number from 0 on"),
                self.encoders.per_mm.is_finite() && self.encoders.per_mm >= 0.0,
            ),
            (
                ("battery", "empty_v", "a number"),
                self.battery.empty_v.is_finite(),
            ),
            (("laser", "x_mm", "a number"), self.laser.x_mm.is_finite()),
            (("laser", "y_mm", "a number"), self.laser.y_mm.is_finite()),
        ];
        checks
            .into_iter()
            .find_map(|(fault, is_valid)| (!is_valid).then_some(fault))
    }
}

fn names() -> String {
    Model::names()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Returns the line, from 1, of a section's key.
fn line_of(text: &str, section: &str, key: &str) -> usize {
    let header = format!("[{section}]");
    let lines = text.lines().enumerate();
    let mut within = lines.skip_while(|(_, line)| line.trim() != header);
    within
        .find(|(_, line)| line.split('=').next().is_some_and(|name| name.trim() == key))
        .map_or(1, |(number, _)| number + 1)
}
