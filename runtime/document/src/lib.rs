//! TOML files that people write: applications, experiments. A file is read with the position of everything in
//! it, and refused with all its faults at once, each with its line and a suggestion.
//!
//! The crate knows neither schemas nor experiments, and prints nothing.

mod fault;
mod file;
pub mod period;
mod report;
pub mod section;
mod syntax;
pub mod time;
pub mod units;

pub use fault::{Fault, FaultLocation, Faults, MAX_LISTED};
pub use file::read;
pub use report::{FaultReport, quote, quote_all};
pub use section::{Node, Section, Text, WordOrTable};
pub use syntax::parse;
