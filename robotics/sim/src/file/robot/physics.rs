//! The masses and wheels of a robot file, for simulators of bodies and forces. The world of this crate uses none.

use super::super::values::{self, between, place};
use super::section;
use crate::model::Physics;
use jde_document::{FaultReport, Section};

const KEYS: [&str; 10] = [
    "mass",
    "height",
    "center",
    "wheel_radius",
    "wheel_width",
    "wheels",
    "casters",
    "torque",
    "friction",
    "track_multiplier",
];

/// The most wheels, and the most casters: more than any robot has.
const MOST_WHEELS: usize = 16;

pub(super) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Option<Physics>> {
    if root.get("physics").is_none() {
        return Some(None);
    }
    let table = section(report, root, "physics", &KEYS)?;
    let mass = table.required(report, "mass", between(0.01, 1e4, "kg"));
    let height = table.required(report, "height", between(0.01, 10.0, "m"));
    let center = table.required(report, "center", place);
    let wheel_radius = table.required(report, "wheel_radius", between(0.005, 2.0, "m"));
    let wheel_width = table.required(report, "wheel_width", between(0.001, 2.0, "m"));
    let wheels = table.required(report, "wheels", values::centers);
    let casters = table.optional(report, "casters", Vec::new(), values::centers);
    let torque = table.required(report, "torque", between(0.01, 1e4, "N m"));
    let friction = table.optional(report, "friction", 0.8, between(0.01, 5.0, ""));
    let track_multiplier = table.optional(report, "track_multiplier", 1.0, between(0.1, 10.0, ""));
    let (wheels, casters) = (wheels?, casters?);
    let sides = [1.0, -1.0].map(|side| wheels.iter().any(|wheel: &[f64; 2]| wheel[1] * side > 0.0));
    if sides != [true; 2] || wheels.len() > MOST_WHEELS || casters.len() > MOST_WHEELS {
        let message = format!("needs a wheel on either side, and at most {MOST_WHEELS} wheels and casters");
        table.fault(report, &table.span, message);
        return None;
    }
    Some(Some(Physics {
        mass: mass?,
        height: height?,
        center: center?,
        wheel_radius: wheel_radius?,
        wheel_width: wheel_width?,
        wheels,
        casters,
        torque: torque?,
        friction: friction?,
        track_multiplier: track_multiplier?,
    }))
}
