//! Teleoperation: a person drives the base and turns the head, as ordinary motor schemas that compete like any other (R13). What
//! the person wants is a modulation that an operator writes again and again (R14); nothing here knows who that is, or by what means.

mod base;
mod head;
mod pilot;
mod wish;

pub use base::Base;
pub use head::Head;
pub use pilot::Pilot;
pub use wish::{Drive, Look};

jde_schema::export!(
    "teleop",
    "A person drives a base and turns a head.",
    [Base, Head, Pilot]
);

#[cfg(test)]
mod tests;
