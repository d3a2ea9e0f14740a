//! Says where a robot is on a map. It drives nowhere, and it changes no map.

mod mcl;
mod memory;
mod panel;
mod tags;

use jde_schema::prelude::*;

pub use mcl::Mcl;
pub use tags::{TagPlace, TagPlaces, Tags};

/// Returns what is said of a jump of the odometry.
fn jumped(from: &Pose2D, to: &Pose2D) -> String {
    let (way, turn) = (from.distance_to(to), from.localize(to).theta.abs());
    format!(
        "the odometry jumped by {way:.2} m and {:.0} degrees",
        turn.to_degrees()
    )
}

jde_schema::export!("localize", "Says where a robot is on a map.", [Mcl, Tags]);

#[cfg(test)]
mod tests;
