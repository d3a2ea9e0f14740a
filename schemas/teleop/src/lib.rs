//! Teleoperation: a person drives the base and turns the head through ordinary motor schemas, which compete
//! like any other (R13). The person's wish is a modulation that an operator writes periodically (R14). The
//! schemas do not know the person or the input device.

mod base;
mod head;
mod pilot;
mod setpoint;

pub use base::Base;
pub use head::Head;
pub use pilot::Pilot;
pub use setpoint::{Drive, Look};

jde_schema::export!(
    "teleop",
    "A person drives a base and turns a head.",
    [Base, Head, Pilot]
);

#[cfg(test)]
mod tests;
