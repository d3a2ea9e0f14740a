//! What came of planning, in words that a person and a father can read.

use core::fmt;

use jde_grid::{GeometryError, PlanError};

use crate::drawn::DrawnError;
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
    /// There is a path toward a target off the map.
    Toward {
        /// The length of the way on the map, m.
        length: f64,
        /// Whether it has more poses than a path can have, so that its end is missing.
        cut: bool,
        /// How far the target is from where the way leaves the map, m.
        left: f64,
    },
    /// There is no target to plan to.
    NoTarget,
    /// There is no map yet, or its schema has retracted it.
    NoMap,
    /// The place of the robot is not known.
    NoPose,
    /// What is seen is in another frame than the pose.
    OtherFrame,
    /// The map, what is seen or the footprint is wrong.
    BadMap(MapError),
    /// A keep-out zone or a lane is wrong.
    BadDrawing(DrawnError),
    /// The map has no way.
    NoWay(PlanError),
    /// The map may have a way, but not outside the keep-out zones.
    NoWayOutside,
    /// The map may have a way, but not past the obstacles that are seen.
    NoWayPast,
    /// No way leads the robot out of a keep-out zone.
    NoWayOut,
    /// The target is in a keep-out zone, or too close to one.
    TargetInZone,
    /// The target is off the map, and no way leads off the map.
    NoWayOff,
    /// The target is off the map, and the robot is at its edge.
    AtEdge,
    /// The target is off any map that has cells of this size.
    TooFar {
        /// How far it is, m.
        distance: f64,
        /// The longest side of a map, m.
        side: f64,
    },
}

impl Situation {
    /// Whether there is no way to a target, while map, place and target are known.
    pub(crate) const fn is_without_way(&self) -> bool {
        match self {
            Self::NoWay(_)
            | Self::NoWayOutside
            | Self::NoWayPast
            | Self::NoWayOut
            | Self::TargetInZone
            | Self::NoWayOff
            | Self::AtEdge
            | Self::TooFar { .. } => true,
            Self::Path { .. }
            | Self::Toward { .. }
            | Self::NoTarget
            | Self::NoMap
            | Self::NoPose
            | Self::OtherFrame
            | Self::BadMap(_)
            | Self::BadDrawing(_) => false,
        }
    }
}

impl From<MapError> for Situation {
    fn from(error: MapError) -> Self {
        Self::BadMap(error)
    }
}

impl From<GeometryError> for Situation {
    fn from(error: GeometryError) -> Self {
        Self::BadMap(error.into())
    }
}

impl From<DrawnError> for Situation {
    fn from(error: DrawnError) -> Self {
        Self::BadDrawing(error)
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
            Self::Toward { length, cut, left } => {
                let beginning = if *cut { "the beginning of " } else { "" };
                write!(
                    f,
                    "{beginning}a path of {length:.2} m to the edge of the map, {left:.0} m before the goal"
                )
            }
            Self::NoTarget => f.write_str("there is no target"),
            Self::NoMap => f.write_str("there is no map"),
            Self::NoPose => f.write_str("the place of the robot is not known"),
            Self::OtherFrame => f.write_str("the obstacles of `seen` are in another frame than the pose"),
            Self::BadMap(error) => error.fmt(f),
            Self::BadDrawing(error) => error.fmt(f),
            Self::NoWay(error) => error.fmt(f),
            Self::NoWayOutside => f.write_str("no way leads to the goal outside the keep-out zones"),
            Self::NoWayPast => f.write_str("no way leads to the goal past what the robot has seen"),
            Self::NoWayOut => f.write_str("no way leads the robot out of the keep-out zone"),
            Self::TargetInZone => f.write_str("the goal is in a keep-out zone"),
            Self::NoWayOff => f.write_str("the goal is outside the map, and no way leads off the map"),
            Self::AtEdge => f.write_str("the goal is outside the map, which does not grow"),
            Self::TooFar { distance, side } => {
                write!(
                    f,
                    "the goal is {distance:.0} m away, farther than a map can reach: {side:.0} m"
                )
            }
        }
    }
}
