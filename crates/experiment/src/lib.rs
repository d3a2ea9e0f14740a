//! Experiments: one application driven many times in lockstep, each drive judged and measured.
//!
//! The crate runs drives and computes results. It prints nothing.
//!
//! Of the results: [`store`] reads and writes `results.jsonl`, [`comparison`] computes the rows that tables
//! show, and [`summary`] writes all files.

pub mod comparison;
pub mod csv;
pub mod digits;
pub mod junit;
mod page;
pub mod result;
pub mod statistics;
pub mod store;
pub mod summary;
