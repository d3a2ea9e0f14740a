//! What is left of a run: its summary, in words or as JSON, and its picture.

mod drive;
mod summary;
mod words;

pub(crate) use drive::{draw, world};
pub(crate) use summary::Summary;
pub(crate) use words::{counted, tell, tell_recording};
