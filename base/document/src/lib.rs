//! Files that people write: applications, experiments, worlds, robots, maps. A file is read with the position of everything
//! in it, and refused with all its faults at once, each with its line where it has one, and a suggestion.
//!
//! The crate reads TOML, and collects the faults of files in any format. It knows neither schemas nor robots, and prints
//! nothing.

mod fault;
mod file;
mod report;
pub mod section;
mod syntax;

pub use fault::{Excerpt, Fault, FaultLocation, Faults, MAX_LISTED};
pub use file::{MAX_BYTES, read};
pub use report::{FaultReport, quote, quote_all};
pub use section::{Checked, Node, Section, Text, WordOrTable, WrongValue};
pub use syntax::parse;
