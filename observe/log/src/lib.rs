//! Recordings: the variables and decisions of a run in MCAP files. The files contain ROS 2 definitions of
//! their messages, so Foxglove, Rerun, PlotJuggler and ROS 2 read them without conversion.
//!
//! [`Recorder`] records what a running application publishes and decides. [`Recording`] reads a file,
//! including one that a power cut left incomplete. A robot never waits for a recording: messages that cannot
//! be recorded are counted and reported. This crate decides nothing and prints nothing.

mod bag;
mod common;
#[cfg(feature = "record")]
mod error;
mod foreign;
#[cfg(feature = "host")]
mod mock;
#[cfg(feature = "record")]
mod origin;
pub mod panel;
mod part;
mod pattern;
#[cfg(feature = "record")]
mod pre_trigger_buffer;
pub mod record;
#[cfg(feature = "record")]
mod recorder;
mod recording;
#[cfg(feature = "host")]
pub mod replay;
#[cfg(feature = "record")]
mod sink;
#[cfg(feature = "record")]
mod subscriber;
mod survey;
#[cfg(feature = "record")]
mod topic;
mod turns;
mod variable;
#[cfg(feature = "record")]
mod writer;
#[cfg(feature = "record")]
mod writer_thread;

#[cfg(feature = "record")]
pub use error::Error;
pub use foreign::Error as DecodeError;
pub use jde_files::LeftOut;
#[cfg(feature = "host")]
pub use mock::mock;
#[cfg(feature = "record")]
pub use origin::Origin;
pub use part::Gap;
pub use pattern::{Selection, UnknownPattern, variables};
#[cfg(feature = "record")]
pub use recorder::{
    Clock, FileEvent, OnFile, OnTrouble, Options, PartSize, Parts, Recorder, SplitOptions, Status,
    TriggerOptions, TriggeredFile, Trouble, turns,
};
pub use recording::{Channel, Damage, Message, Messages, ReadError, Recording};
#[cfg(feature = "record")]
pub use subscriber::topic_name;
pub use survey::{Cause, Damaged, GroupSurvey, PartsSurvey, SchemaProblems, Survey, TopicSurvey};
#[cfg(feature = "record")]
pub use topic::{Stamps, Topic};
pub use turns::{RecordedGroup, RecordedHierarchy, RecordedSchema};
pub use variable::{RecordedVariable, RecordedVariables, value_type};
