//! The destination of messages: one file for the whole recording, one file after the other, or the files that
//! conditions cause. No sink blocks the writing thread for ever: it counts what it cannot write.

mod around;
mod file;
mod names;
mod split;
mod syncer;
mod triggered;
mod whole;

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;
use jde_host::story::Kind;

use crate::lane::{Holds, Lane, Shared};
use crate::ring::About;
use crate::trigger::Firing;
use crate::writer::{Times, Writer};

pub(crate) use file::Begun;
pub(crate) use names::{create, numbered};
pub(crate) use split::Split;
pub(crate) use syncer::Disk;
pub(crate) use triggered::{Plan, Triggered};
pub(crate) use whole::Whole;

/// A destination of messages. It receives them in the order of their arrival.
pub(crate) trait Sink: Send {
    /// Adds a channel. Channels have the numbers 0, 1, 2 and so on, in the order of these calls.
    fn open(&mut self, channel: Channel);

    /// Writes a message.
    fn message(&mut self, channel: usize, times: Times, data: &[u8], says: Says);

    /// Reports that a condition became true by the last message.
    fn fired(&mut self, firing: &Firing, condition: &str);

    /// Called after all messages that had arrived. Returns whether there is more work to do at once. `now` is
    /// the application's time.
    fn round(&mut self, now: Nanos) -> bool;

    /// Called after the last message.
    fn finish(&mut self);
}

/// The effect of a message on the values in force.
#[derive(Clone, Debug)]
pub(crate) enum Says {
    /// A state is in force until the next message about it.
    State(About),
    /// Another channel no longer has a value.
    Retracts(usize),
}

/// The contents of a channel.
#[derive(Clone)]
pub(crate) enum Channel {
    /// Messages of the story.
    Story(Kind),
    /// Values of a variable, or the drawings of a panel.
    Lane(Arc<Lane>),
}

impl Channel {
    fn add_to(&self, writer: &mut Writer) -> io::Result<u16> {
        match self {
            Self::Story(kind) => {
                let (name, schema) = kind.schema();
                writer.json(kind.topic(), name, schema)
            }
            Self::Lane(lane) => match &lane.holds {
                Holds::Values(value_type) => writer.variable(&lane.name, value_type, &lane.about),
                Holds::Panel => writer.panel(&lane.name, &lane.about),
            },
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Story(kind) => kind.topic(),
            Self::Lane(lane) => &lane.name,
        }
    }

    /// Counts messages that no file contains.
    fn lose(&self, count: u64, shared: &Shared) {
        match self {
            Self::Story(_) => shared.lost_events.fetch_add(count, Ordering::Relaxed),
            Self::Lane(lane) => lane.lost.fetch_add(count, Ordering::Relaxed),
        };
    }
}

/// Returns the metadata of a file about its lost messages: the number for each topic.
fn lost_words(lost: &BTreeMap<String, u64>) -> BTreeMap<String, String> {
    lost.iter()
        .filter(|(_, lost)| **lost > 0)
        .map(|(topic, lost)| (topic.clone(), lost.to_string()))
        .collect()
}
