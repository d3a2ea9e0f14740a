//! The result of a run: its summary, as text or as JSON, and its picture.

mod data;
mod drive;
mod text;

pub use data::{Ending, RunSummary};
pub use drive::{draw, world_file};
pub use text::{print_recording, print_summary};
