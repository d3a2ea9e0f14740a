//! Recorders: they write the variables and decisions of a run to MCAP files, whose form `jde-log` defines.
//!
//! [`Recorder`] records what a running application publishes and decides. A robot never waits for a recording: messages
//! that cannot be recorded are counted and reported. This crate decides nothing and prints nothing.

mod error;
mod origin;
mod pre_trigger_buffer;
mod recorder;
mod sink;
mod subscriber;
mod topic;
mod writer;
mod writer_thread;

pub use error::Error;
pub use origin::Origin;
pub use recorder::{
    Clock, FileEvent, OnFile, OnTrouble, PartSize, Parts, Recorder, RecorderOptions, SplitOptions, Status,
    TriggerOptions, TriggeredFile, Trouble, turns,
};
pub use topic::{Stamps, Topic};
