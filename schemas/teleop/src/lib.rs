//! Teleoperation: a person drives the base and turns the head through ordinary motor schemas, which compete
//! like any other (R13). The person's wish is a modulation that an operator writes periodically (R14), or what a
//! gamepad holds. The schemas read no device.

mod base;
mod gamepad;
mod head;
mod pilot;
mod ramp;
mod setpoint;

pub use base::Base;
pub use gamepad::Gamepad;
pub use head::Head;
pub use pilot::Pilot;
pub use setpoint::{Drive, Look};

jde_schema::export!(
    "teleop",
    "A person drives a base and turns a head.",
    [Base, Gamepad, Head, Pilot]
);

#[cfg(test)]
mod tests;
