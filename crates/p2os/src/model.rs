//! What is known of a model of robot: units, body, limits, sonars. Data, in files of TOML; nothing is
//! computed from the robot's words.

use core::f64::consts::TAU;

use serde::Deserialize;

/// The models that come with the library: name, text of the file.
const KNOWN: [(&str, &str); 7] = [
    ("p3dx", include_str!("../models/p3dx.toml")),
    ("p3dx-sh", include_str!("../models/p3dx-sh.toml")),
    ("p3at", include_str!("../models/p3at.toml")),
    ("p3at-sh", include_str!("../models/p3at-sh.toml")),
    ("p2dx", include_str!("../models/p2dx.toml")),
    ("amigo", include_str!("../models/amigo.toml")),
    ("amigo-sh", include_str!("../models/amigo-sh.toml")),
];

/// A model of robot. Every number is in the unit its name ends with, in the frame of the base: x ahead, y
/// left.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// What it is called here.
    pub name: String,
    /// The classes by which such robots call themselves.
    pub class: String,
    /// The subclasses by which such robots call themselves.
    pub subclasses: Vec<String>,
    /// What its numbers mean.
    pub units: Units,
    /// How big it is.
    pub body: Body,
    /// What it can do.
    pub limits: Limits,
    /// Its sonars.
    pub sonar: Sonars,
    /// Its bumpers, if it has any.
    pub bumpers: Bumpers,
    /// Its encoders.
    pub encoders: Ticks,
    /// Its battery.
    pub battery: Battery,
    /// Its laser, if it has one.
    pub laser: LaserMount,
}

/// What a robot's numbers mean.
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
    /// Turning, rad/s, for a difference of 2 mm/s between the wheels.
    pub wheel_difference: f64,
    /// Bits after which positions wrap; fewer than the robot has is right too, as long as half of them is not
    /// driven at once.
    pub position_bits: u32,
}

/// How big a robot is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// From front to rear.
    pub length_mm: f64,
    /// From side to side.
    pub width_mm: f64,
    /// Of the circle it turns in.
    pub radius_mm: f64,
}

/// What a robot can do at most.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Speed.
    pub velocity_mm_s: f64,
    /// Speed of turning.
    pub rotation_deg_s: f64,
}

/// A robot's sonars.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sonars {
    /// Width of the cone.
    pub cone_deg: f64,
    /// Least distance.
    pub min_mm: f64,
    /// From here on nothing was heard.
    pub max_mm: f64,
    /// Where each sits, mm ahead and mm to the left, and where it looks, degrees; in the order of the robot's
    /// numbers.
    pub mounts: Vec<[f64; 3]>,
}

/// How many bumpers a robot can have.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bumpers {
    /// Ahead, at most 7.
    pub front: usize,
    /// Behind, at most 7.
    pub rear: usize,
}

/// What a robot's encoders count.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ticks {
    /// Ticks while a wheel rolls a millimetre; 0 if unknown, then the robot's own word counts.
    pub per_mm: f64,
}

/// A robot's battery.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Battery {
    /// Its voltage by name.
    pub nominal_v: f64,
    /// Empty, for the percentage of a battery that does not tell it.
    pub empty_v: f64,
    /// Full.
    pub full_v: f64,
}

/// Where a laser usually sits.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaserMount {
    /// Ahead.
    pub x_mm: f64,
    /// To the left.
    pub y_mm: f64,
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// No model has the name.
    #[error(
        "there is no model `{name}`; expected one of {}, or the path of a file of the same form",
        names()
    )]
    Unknown {
        /// The name.
        name: String,
    },
    /// A file is not of the form, or a number in it cannot be.
    #[error("{file}:{line}: {message}")]
    File {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The key, what is wrong with it, what was expected.
        message: String,
    },
}

impl Model {
    /// A model that comes with the library.
    ///
    /// # Errors
    /// If there is none of the name; the message names those there are.
    pub fn named(name: &str) -> Result<Self, ModelError> {
        let known = KNOWN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let (name, text) = known.ok_or_else(|| ModelError::Unknown {
            name: name.to_owned(),
        })?;
        Self::parse(text, name)
    }

    /// The model of robots that give themselves this subclass.
    ///
    /// # Errors
    /// If none does.
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

    /// Reads the text of a model's file; `file` is what errors call it.
    ///
    /// # Errors
    /// If it is not of the form, with the line and the key.
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

    /// The names of the models that come with the library.
    pub fn names() -> impl Iterator<Item = &'static str> {
        KNOWN.into_iter().map(|(name, _)| name)
    }

    /// An angle of the robot, rad.
    #[must_use]
    pub fn angle(&self, units: i16) -> f64 {
        f64::from(units) * TAU / self.units.angle_per_turn
    }

    /// The first number that cannot be: section, key, what was expected.
    fn fault(&self) -> Option<(&'static str, &'static str, &'static str)> {
        const MORE: &str = "a number greater than 0";
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
        let bad = positive
            .into_iter()
            .find(|(_, _, value)| !(value.is_finite() && *value > 0.0));
        if let Some((section, key, _)) = bad {
            let expected = if key == "full_v" {
                "more than `empty_v`"
            } else {
                MORE
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
            .find_map(|(fault, fits)| (!fits).then_some(fault))
    }
}

fn names() -> String {
    Model::names()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// The line, from 1, on which a section's key stands.
fn line_of(text: &str, section: &str, key: &str) -> usize {
    let header = format!("[{section}]");
    let lines = text.lines().enumerate();
    let mut within = lines.skip_while(|(_, line)| line.trim() != header);
    within
        .find(|(_, line)| line.split('=').next().is_some_and(|left| left.trim() == key))
        .map_or(1, |(number, _)| number + 1)
}
