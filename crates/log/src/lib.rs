//! Recordings: the variables and decisions of a run in MCAP files. The files contain ROS 2 definitions of
//! their messages, so Foxglove, Rerun, PlotJuggler and ROS 2 read them without conversion.
//!
//! [`Recorder`] records what a running application publishes and decides. [`Recording`] reads a file,
//! including one that a power cut left incomplete. A robot never waits for a recording: messages that cannot
//! be recorded are counted and reported. This crate decides nothing and prints nothing.

mod error;
mod origin;
pub mod panel;
mod part;
mod pattern;
mod pre_trigger_buffer;
mod recorder;
mod recording;
#[cfg(feature = "host")]
pub mod replay;
mod sink;
mod subscriber;
mod survey;
mod topic;
pub mod trigger;
mod turns;
mod writer;
mod writer_thread;

pub use error::Error;
pub use origin::Origin;
pub use pattern::{Selection, UnknownPattern, variables};
pub use recorder::{
    Clock, FileEvent, OnError, OnFile, Options, PartSize, Parts, Recorder, SplitOptions, Status,
    TriggerOptions, TriggeredFile,
};
pub use recording::{Channel, Damage, Message, Messages, ReadError, Recording};
pub use subscriber::topic_name;
pub use survey::{Cause, Damaged, GroupSurvey, PartsSurvey, SchemaProblems, Survey, TopicSurvey};
pub use topic::{Stamps, Topic};
pub use turns::{RecordedGroup, RecordedHierarchy, RecordedSchema, turns};
