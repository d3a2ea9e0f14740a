//! Experiments: one application driven many times in lockstep, each drive judged and measured.
//!
//! [`file::read`] turns a file into an [`Experiment`], or into all its faults. A
//! [`PreparedDrive`](drive::PreparedDrive) runs one drive and returns its
//! [`DriveResult`](result::DriveResult). [`pool::run`] runs all of them in processes of their own. Of the
//! results, [`store`] reads and writes `results.jsonl`, [`comparison`] computes the rows that tables show,
//! and [`summary`] writes all files. The crate prints nothing, and no result depends on a clock of the
//! machine.

pub mod applications;
pub mod comparison;
pub mod csv;
pub mod digits;
pub mod drive;
mod experiment;
pub mod file;
pub mod folder;
pub mod junit;
mod page;
pub mod pool;
pub mod result;
pub mod statistics;
pub mod store;
pub mod summary;
pub mod worker;

pub use experiment::{Axis, AxisChoice, AxisValues, Experiment, Mission, Variant};
