//! Recordings: the variables and decisions of a run in MCAP files. The files contain ROS 2 definitions of
//! their messages, so Foxglove, Rerun, PlotJuggler and ROS 2 read them without conversion.
//!
//! [`Recording`] reads a file, including one that a power cut left incomplete. The modules [`log_line`], [`panel`], [`part`]
//! and [`record`] define what is particular to our recordings, for those who write them too (`jde-recorder`). This crate
//! runs nothing, decides nothing and prints nothing.

mod bag;
mod common;
mod foreign;
pub mod log_line;
pub mod panel;
pub mod part;
mod pattern;
pub mod record;
mod recording;
mod survey;
mod turns;
mod variable;

pub use foreign::Error as DecodeError;
pub use jde_files::LeftOut;
pub use pattern::{Selection, UnknownPattern, variables};
pub use recording::{Channel, Damage, Messages, ReadError, RecordedMessage, Recording};
pub use survey::{Cause, Damaged, GroupSurvey, PartsSurvey, SchemaProblems, Survey, TopicSurvey};
pub use turns::{RecordedGroup, RecordedHierarchy, RecordedSchema, TURNS_TOPIC};
pub use variable::{RecordedVariable, RecordedVariables, topic_name, value_type};
