//! Recordings: the variables and decisions of a run in MCAP files. The files contain ROS 2 definitions of
//! their messages, so Foxglove, Rerun, PlotJuggler and ROS 2 read them without conversion.
//!
//! [`Recorder`] records what a running application publishes and decides. [`Recording`] reads a file,
//! including one that a power cut left incomplete. A robot never waits for a recording: messages that cannot
//! be recorded are counted and reported. This crate decides nothing and prints nothing.

mod error;
mod lane;
mod origin;
pub mod panel;
mod part;
mod pattern;
mod recorder;
mod recording;
pub mod replay;
mod ring;
mod scribe;
mod sink;
mod survey;
mod tap;
pub mod trigger;
mod turns;
mod writer;

pub use error::Error;
pub use lane::{Stamps, Topic};
pub use origin::Origin;
pub use pattern::{Selection, UnknownPattern, variables};
pub use recorder::{
    Clock, Every, Happened, OnFile, OnTrouble, Options, Parts, Recorder, Split, Status, When, Written,
};
pub use recording::{Channel, Damage, Message, Messages, ReadError, Recording};
pub use survey::{Cause, Damaged, GroupSurvey, PartsSurvey, Survey, TopicSurvey, Troubled};
pub use tap::topic_name;
pub use turns::{Cast, Member, Troupe, turns};
