//! Networks of ONNX files, as policies have them: up to a few million weights of 32 bits, one run per period.
//!
//! A file is refused as a whole, with the name of the node, unless every operator, attribute and type of number in it is
//! one that this crate computes as ONNX defines it. So a network either runs with the right numbers or does not start.
//! Sums have a fixed order and functions are those of `libm`, so that the same file and the same inputs give the same bits
//! on every machine. The crate has no clock, starts no thread, and does nothing with the outputs.

mod attributes;
mod error;
mod external;
mod graph;
mod model;
mod network;
mod ops;
mod tensor;
mod wire;

pub use error::OnnxError;
pub use network::{Network, Port};

/// The versions of ONNX's operators that are read. The numbers of tests are of some of them; between them, no operator
/// of this crate changed.
pub const OPSET_VERSIONS: std::ops::RangeInclusive<i64> = 9..=25;

/// The largest file, and the largest sum of its weights: more than any processor of a robot runs in a period.
const MAX_BYTES: u64 = 256 << 20;

/// The most operations of a run, in multiplications of a product of matrices: about a second of one core. They are counted
/// from the shapes, before a node is run for the first time.
const MAX_OPERATIONS: u64 = 1 << 31;

#[cfg(test)]
mod tests;
