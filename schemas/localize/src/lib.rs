//! Says where a robot is on a map. It drives nowhere, and it changes no map.

mod mcl;
mod memory;
mod panel;
mod tags;

use jde_schema::prelude::*;

pub use mcl::Mcl;
pub use tags::{TagPlace, TagPlaces, Tags};

/// A turn of the odometry in one step from which on it is a jump, rad.
const JUMP_TURN: f64 = core::f64::consts::FRAC_PI_2;

/// Returns what is said of a step of the odometry that is no motion: one longer than `most` m, or a turn that is too
/// large.
fn jump(step: &Pose2D, most: f64) -> Option<String> {
    let way = step.x.hypot(step.y);
    let degrees = step.theta.abs().to_degrees();
    (way > most || step.theta.abs() > JUMP_TURN)
        .then(|| format!("the odometry jumped by {way:.2} m and {degrees:.0} degrees"))
}

jde_schema::export!("localize", "Says where a robot is on a map.", [Mcl, Tags]);

#[cfg(test)]
mod tests;
