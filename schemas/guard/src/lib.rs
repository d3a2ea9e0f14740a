//! Guards: schemas that judge the commands of others before they take effect (R18).

mod footprint;
mod memory;
mod panel;

pub use footprint::Footprint;

jde_schema::export!("guard", "Judges commands before they take effect.", [Footprint]);

#[cfg(test)]
mod tests;
