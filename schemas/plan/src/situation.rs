//! What came of planning, in words that a person and a father can read.

use core::fmt;

use jde_grid::PlanError;

use crate::followed::MapError;

/// What came of the last iteration.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Situation {
    /// There is a path of this length in metres.
    Path {
        /// The length of the whole way, m.
        length: f64,
        /// Whether it has more poses than a path can have, so that its end is missing.
        cut: bool,
    },
    /// There is no target to plan to.
    NoTarget,
    /// There is no map yet, or its schema has retracted it.
    NoMap,
    /// The place of the robot is not known.
    NoPose,
    /// The map or the footprint is wrong.
    BadMap(MapError),
    /// The map has no way.
    NoWay(PlanError),
}

impl From<MapError> for Situation {
    fn from(error: MapError) -> Self {
        Self::BadMap(error)
    }
}

impl From<PlanError> for Situation {
    fn from(error: PlanError) -> Self {
        Self::NoWay(error)
    }
}

impl fmt::Display for Situation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path { length, cut: false } => write!(f, "a path of {length:.2} m"),
            Self::Path { length, cut: true } => write!(f, "the beginning of a path of {length:.2} m"),
            Self::NoTarget => f.write_str("there is no target"),
            Self::NoMap => f.write_str("there is no map"),
            Self::NoPose => f.write_str("the place of the robot is not known"),
            Self::BadMap(error) => error.fmt(f),
            Self::NoWay(error) => error.fmt(f),
        }
    }
}
