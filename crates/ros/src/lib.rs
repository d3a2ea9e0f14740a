//! How ROS 2 sees the values of variables: the definition of a described type, and its bytes in CDR. The recordings, the link
//! and the driver of topics all speak by it. Opens nothing and knows no schema.

pub mod cdr;
pub mod definition;
pub mod hash;

pub use jde_abi::describe::Type;

#[cfg(test)]
mod random;
