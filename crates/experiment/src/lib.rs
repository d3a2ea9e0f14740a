//! Experiments: one application driven many times in lockstep, each drive judged and measured.
//!
//! The crate runs drives and computes results. It prints nothing.

pub mod comparison;
pub mod result;
pub mod statistics;
