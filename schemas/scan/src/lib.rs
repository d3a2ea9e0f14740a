//! Scans of several sensors.

mod circle;
mod eye;
mod memory;
mod merge;
mod noticing;
mod panel;
mod sensor;
mod sonar;

pub use merge::Merge;

jde_schema::export!(
    "scan",
    "Merges lasers, sonars, bumpers and cliff sensors into one scan.",
    [Merge]
);

#[cfg(test)]
mod tests;
