//! Says where a robot is on a map. It drives nowhere, and it changes no map.

mod mcl;
mod memory;
mod panel;
mod ports;
mod tags;

pub use mcl::Mcl;
pub use tags::{TagPlace, TagPlaces, Tags};

jde_schema::export!("localize", "Says where a robot is on a map.", [Mcl, Tags]);

#[cfg(test)]
mod tests;
