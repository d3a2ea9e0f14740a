//! Values of variables in the form of ROS 2: the definition of a described type, and its bytes in CDR;
//! and the services of ROS 2. It opens nothing, and knows no schemas.

pub mod cdr;
pub mod definition;
#[cfg(feature = "network")]
pub mod hash;
#[cfg(feature = "network")]
pub mod interface;

pub use jde_abi::describe::Type;

#[cfg(test)]
mod random;
