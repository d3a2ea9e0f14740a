//! The errors of worlds, robots and requests. Each message says how to correct the error.
//!
//! One type for the whole crate. This module prints nothing.

pub use jde_document::{Fault, Faults};

use crate::geometry::{Bounds, Pose2, Twist2};
use crate::head::HeadCommand;
use crate::shipped::SHIPPED_ROBOTS;

/// Why a world could not be created, or why it refused a request.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The world's files have faults.
    #[error(transparent)]
    Faults(#[from] Faults),
    /// A robot that has no start in the world.
    #[error("the world `{world}` has no robot `{robot}`; {}", suggestion(.known, .nearest))]
    UnknownRobot {
        /// The world's name.
        world: String,
        /// The requested robot.
        robot: String,
        /// The robots that have starts.
        known: Vec<String>,
        /// The known name that is most similar to the requested one.
        nearest: Option<String>,
    },
    /// A robot that is neither a file nor shipped.
    #[error(
        "there is no robot `{name}`: expected a file, `{name}.toml`, or one of `{}`",
        shipped()
    )]
    UnknownModel {
        /// The requested robot.
        name: String,
    },
    /// The robot is in the world already.
    #[error("robot `{robot}` is in the world already: add it once and share its id")]
    AlreadyAdded {
        /// The robot.
        robot: String,
    },
    /// The robot does not fit at its start.
    #[error(
        "{place}: robot `{robot}` of radius {radius} m starts on `{by}`: move its start at least {need:.3} m away from it"
    )]
    StartBlocked {
        /// File and line of the start, or the time at which the place was found occupied.
        place: String,
        /// The robot.
        robot: String,
        /// Its radius in metres.
        radius: f64,
        /// The thing that occupies the place.
        by: String,
        /// The least extra distance in metres; more if the place is in the middle of the thing.
        need: f64,
    },
    /// An invalid number in a configuration.
    #[error("{what} is {value}: expected {expected}")]
    BadConfig {
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The valid values.
        expected: &'static str,
    },
    /// A command with a number that is not finite. The robot keeps its earlier command.
    #[error(
        "command of robot `{robot}` is {} m/s ahead, {} m/s to the left, {} rad/s: expected finite numbers",
        .twist.linear, .twist.lateral, .twist.angular
    )]
    BadCommand {
        /// The robot.
        robot: String,
        /// The requested speeds.
        twist: Twist2,
    },
    /// A command of the head with a number that is not finite. The head keeps its earlier command.
    #[error("command of the head of robot `{robot}` is {command:?}: expected finite numbers")]
    BadHeadCommand {
        /// The robot.
        robot: String,
        /// The requested command.
        command: HeadCommand,
    },
    /// A robot cannot be put at the requested place. It stays where it is.
    #[error(
        "robot `{robot}` of radius {radius} m cannot be put at ({:.3}, {:.3}): `{by}` is there; choose a place at \
         least {need:.3} m farther from it", .pose.x, .pose.y
    )]
    PlaceBlocked {
        /// The robot.
        robot: String,
        /// Its radius in metres.
        radius: f64,
        /// The requested pose.
        pose: Pose2,
        /// The thing that occupies the place.
        by: String,
        /// The least extra distance in metres; more if the place is in the middle of the thing.
        need: f64,
    },
    /// A place outside this world. The robot stays where it is.
    #[error(
        "robot `{robot}` cannot be put at ({}, {}), heading {}: expected a place within the world, from {:?} to {:?}",
        .pose.x, .pose.y, .pose.heading, .bounds.min, .bounds.max
    )]
    BadPlace {
        /// The robot.
        robot: String,
        /// The requested pose.
        pose: Pose2,
        /// The bounds of the world.
        bounds: Bounds,
    },
    /// A change names something that is not in the world.
    #[error("the world `{world}` has no {kind} `{name}` now; {}", present(.known, .nearest))]
    UnknownThing {
        /// The world's name.
        world: String,
        /// What was expected: a thing, a mover or a robot.
        kind: &'static str,
        /// The requested name.
        name: String,
        /// The names of that kind.
        known: Vec<String>,
        /// The known name that is most similar to the requested one.
        nearest: Option<String>,
    },
    /// A box has the name of something in the world.
    #[error(
        "box `{name}` cannot be added: the world has a `{name}`; remove it first, or choose another name"
    )]
    NameTaken {
        /// The name.
        name: String,
    },
    /// A box cannot be added, because its place is occupied.
    #[error("box `{name}` cannot be added: `{by}` is there; choose another place, or wait until it is free")]
    BoxBlocked {
        /// The box.
        name: String,
        /// What occupies the place.
        by: String,
    },
    /// Edits that do not fit into one text.
    #[error("the edits have {bytes} bytes: expected at most {most}; write them one after another")]
    TooManyEdits {
        /// Their bytes.
        bytes: usize,
        /// The bytes that fit.
        most: usize,
    },
    /// A polygon that cannot be the footprint of a robot.
    #[error("the footprint {reason}")]
    BadFootprint {
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// A buffer whose length is not the sensor's number of values.
    #[error("the buffer for the {sensor} holds {given} values: expected {expected}")]
    BadBuffer {
        /// The sensor.
        sensor: &'static str,
        /// The length of the buffer.
        given: usize,
        /// The length that fits.
        expected: usize,
    },
}

impl WorldError {
    /// Returns the faults of the files; none for a refused request.
    pub fn faults(&self) -> &[Fault] {
        match self {
            Self::Faults(faults) => faults.list(),
            _ => &[],
        }
    }
}

/// Returns an error for a number that is not finite or that `fits` rejects.
pub(crate) fn check(
    what: &'static str,
    value: f64,
    expected: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Result<(), WorldError> {
    if value.is_finite() && fits(value) {
        Ok(())
    } else {
        Err(WorldError::BadConfig {
            what,
            value,
            expected,
        })
    }
}

fn present(known: &[String], nearest: &Option<String>) -> String {
    match known {
        [] => "it has none".to_owned(),
        known => suggestion(known, nearest),
    }
}

/// Returns the names of the shipped robots.
fn shipped() -> String {
    SHIPPED_ROBOTS.map(|(name, _)| name).join("`, `")
}

fn suggestion(known: &[String], nearest: &Option<String>) -> String {
    match (nearest, known) {
        (Some(name), _) => format!("did you mean `{name}`?"),
        (None, []) => "add a `[robots.NAME]` with a `start` to its file".to_owned(),
        (None, names) => format!("it has `{}`", names.join("`, `")),
    }
}
