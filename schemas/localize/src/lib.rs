//! Says where a robot is on a map. It drives nowhere, and it changes no map.

mod mcl;
mod memory;
mod panel;

pub use mcl::Mcl;

jde_schema::export!("localize", "Says where a robot is on a map.", [Mcl]);

#[cfg(test)]
mod tests;
