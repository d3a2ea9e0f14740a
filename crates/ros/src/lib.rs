//! Values of variables in the form of ROS 2: the definition of a described type, and its bytes in CDR. The
//! recordings, the link and the driver of topics use it. It refuses to open anything and to know schemas.

pub mod cdr;
pub mod definition;
pub mod hash;

pub use jde_abi::describe::Type;

#[cfg(test)]
mod random;
