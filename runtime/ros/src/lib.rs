//! Values of variables in the form of ROS 2: the definition of a described type, and its bytes in CDR. It opens nothing,
//! and knows no schemas.

pub mod cdr;
pub mod definition;

pub use jde_abi::describe::Type;

#[cfg(test)]
mod random;
