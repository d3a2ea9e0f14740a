//! Reports on recordings without a screen: pictures of a robot's path, the schemas' states and the values of
//! variables over time, and a page with all of these. And the page of an experiment.
//!
//! The crate reads recordings and has `jde-drawing` draw. It runs no schema, uses no network and prints nothing.

mod analysis;
mod chart;
mod document;
pub mod experiment;
mod moment;
mod page;
mod sheet;
#[cfg(test)]
mod tests;

pub use analysis::{Analysis, Number, Series, Wanted};
pub use moment::view_command;
pub use page::{columns, page};
pub use sheet::{Numbers, SIDES, Size, draw_numbers, draw_recording};
