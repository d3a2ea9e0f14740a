//! The result of a run: its summary, as text or as JSON, and its picture.

mod data;
mod drive;
mod text;

pub(crate) use data::RunSummary;
pub(crate) use drive::{draw, world_file};
pub(crate) use text::{pluralize, print_recording, print_summary};
