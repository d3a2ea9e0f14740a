//! Ordinary schemas that misbehave on request, one of each kind, for testing the effects on all other
//! schemas. Without a request they do nothing wrong.

mod device;
mod eye;
mod motor;
mod request;
mod trouble;

pub use device::Device;
pub use eye::Eye;
pub use motor::Motor;

jde_schema::export!(
    "fault",
    "Schemas that misbehave on request, to test the effects on other schemas.",
    [Motor, Eye, Device]
);

#[cfg(test)]
mod tests;
