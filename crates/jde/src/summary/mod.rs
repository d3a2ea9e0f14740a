//! The result of a run: its summary, in words or as JSON, and its picture.

mod data;
mod drive;
mod words;

pub(crate) use data::Summary;
pub(crate) use drive::{draw, world};
pub(crate) use words::{counted, tell, tell_recording};
