//! What can be wrong with a world, a robot or a request, said so that a person can mend it.
//!
//! One type for the crate. Nothing here prints.

use std::fmt;
use std::path::PathBuf;

use crate::geometry::{Bounds, Pose2};
use crate::head::HeadCommand;

/// One thing wrong, or doubtful, in a file of a world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The file: the world, its map or the map's image.
    pub file: PathBuf,
    /// The line, from 1; none when the file could not be read at all.
    pub line: Option<usize>,
    /// What is wrong, what was expected, what to do.
    pub message: String,
}

/// Why a world was not made, or a request to it refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The world's files have faults: all of them, in the order of the lines.
    #[error("{}", lines(.0))]
    Faults(Vec<Fault>),
    /// A robot that the world has no start for.
    #[error("the world `{world}` has no robot `{robot}`; {}", offer(.known, .nearest))]
    UnknownRobot {
        /// The world's name.
        world: String,
        /// The robot asked for.
        robot: String,
        /// The robots it has starts for.
        known: Vec<String>,
        /// The known name most like the one asked for.
        nearest: Option<String>,
    },
    /// The robot is in the world already.
    #[error("robot `{robot}` is in the world already: add it once and share its id")]
    AlreadyAdded {
        /// The robot.
        robot: String,
    },
    /// The robot does not fit where it should start.
    #[error(
        "{place}: robot `{robot}` of radius {radius} m starts on `{by}`: move its start at least {need:.3} m away from it"
    )]
    StartBlocked {
        /// File and line of the start, or the time when the place was found taken.
        place: String,
        /// The robot.
        robot: String,
        /// Its radius in metres.
        radius: f64,
        /// What stands there.
        by: String,
        /// How much farther away it must be at least, in metres; more if it is in the middle of what stands there.
        need: f64,
    },
    /// A number in a configuration that cannot work.
    #[error("{what} is {value}: expected {expected}")]
    BadConfig {
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would do.
        expected: &'static str,
    },
    /// A command with a number that is not finite; the robot keeps the one before.
    #[error("command of robot `{robot}` is {linear} m/s, {angular} rad/s: expected finite numbers")]
    BadCommand {
        /// The robot.
        robot: String,
        /// The speed ahead that was asked for.
        linear: f64,
        /// The turn rate that was asked for.
        angular: f64,
    },
    /// A command of the head with a number that is not finite; the head keeps the one before.
    #[error("command of the head of robot `{robot}` is {command:?}: expected finite numbers")]
    BadHeadCommand {
        /// The robot.
        robot: String,
        /// What was asked for.
        command: HeadCommand,
    },
    /// A robot cannot stand where it should be put; it stays where it is.
    #[error(
        "robot `{robot}` of radius {radius} m cannot be put at ({:.3}, {:.3}): `{by}` is there; choose a place at \
         least {need:.3} m farther from it", .pose.x, .pose.y
    )]
    PlaceBlocked {
        /// The robot.
        robot: String,
        /// Its radius in metres.
        radius: f64,
        /// Where it should be put.
        pose: Pose2,
        /// What stands there.
        by: String,
        /// How much farther away it must be at least, in metres; more if it is in the middle of what stands there.
        need: f64,
    },
    /// A place that is not in this world; the robot stays where it is.
    #[error(
        "robot `{robot}` cannot be put at ({}, {}), heading {}: expected a place within the world, from {:?} to {:?}",
        .pose.x, .pose.y, .pose.heading, .bounds.min, .bounds.max
    )]
    BadPlace {
        /// The robot.
        robot: String,
        /// Where it should be put.
        pose: Pose2,
        /// Where the world is.
        bounds: Bounds,
    },
    /// A buffer that does not hold one value a beam or sonar.
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

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file.display(), self.message),
            None => write!(f, "{}: {}", self.file.display(), self.message),
        }
    }
}

impl WorldError {
    /// Gives the faults of the files, or nothing for a refused request.
    pub fn faults(&self) -> &[Fault] {
        match self {
            Self::Faults(faults) => faults,
            _ => &[],
        }
    }
}

/// Refuses a number that is not finite or that `fits` does not accept.
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

fn lines(faults: &[Fault]) -> String {
    faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("\n")
}

fn offer(known: &[String], nearest: &Option<String>) -> String {
    match (nearest, known) {
        (Some(name), _) => format!("did you mean `{name}`?"),
        (None, []) => "add a `[robots.NAME]` with a `start` to its file".to_owned(),
        (None, names) => format!("it has `{}`", names.join("`, `")),
    }
}
