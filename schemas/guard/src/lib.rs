//! Guards: schemas that judge the commands of others before they take effect (R18).

mod arm;
mod footprint;
mod memory;
mod panel;
mod zones;

pub use arm::{Arm, ArmState};
pub use footprint::Footprint;
pub use zones::{Occupied, Zones};

jde_schema::export!(
    "guard",
    "Judges commands before they take effect.",
    [Arm, Footprint, Zones]
);

#[cfg(test)]
mod tests;
