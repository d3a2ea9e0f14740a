//! Ordinary schemas that misbehave when they are told to: one of each kind, for trying what becomes of everybody else.
//! Never told, they do nothing wrong.

mod device;
mod eye;
mod motor;
mod orders;
mod trouble;

pub use device::Device;
pub use eye::Eye;
pub use motor::Motor;

jde_schema::export!(
    "fault",
    "Schemas that misbehave as they are told, to try what becomes of the others.",
    [Motor, Eye, Device]
);

#[cfg(test)]
mod tests;
