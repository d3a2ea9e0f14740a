//! Where the writing thread puts what has come: one file from beginning to end, one after the other, or the files that conditions ask for. No sink
//! ever stops the thread for good: what it cannot write it counts.

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

/// Takes messages in the order in which they came.
pub(crate) trait Sink: Send {
    /// Adds a channel; they are numbered from 0 in the order in which they are added.
    fn open(&mut self, channel: Channel);

    /// Takes a message.
    fn message(&mut self, channel: usize, times: Times, data: &[u8], says: Says);

    /// A condition came true with what came last.
    fn fired(&mut self, firing: &Firing, condition: &str);

    /// All that had come has been put; answers whether it has more to do at once. `now` is the application's time.
    fn round(&mut self, now: Nanos) -> bool;

    /// Nothing more comes.
    fn finish(&mut self);
}

/// What a message says beyond itself.
#[derive(Clone, Debug)]
pub(crate) enum Says {
    /// Something is so until another message says otherwise.
    State(About),
    /// Another channel has no value any more.
    Retracts(usize),
}

/// What goes through a channel.
#[derive(Clone)]
pub(crate) enum Channel {
    /// Messages of the story.
    Story(Kind),
    /// Values.
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

    /// Counts messages that are in no file.
    fn lose(&self, count: u64, shared: &Shared) {
        match self {
            Self::Story(_) => shared.lost_events.fetch_add(count, Ordering::Relaxed),
            Self::Lane(lane) => lane.lost.fetch_add(count, Ordering::Relaxed),
        };
    }
}

/// What a file says of what it lacks: how many messages of which topic.
fn lost_words(lost: &BTreeMap<String, u64>) -> BTreeMap<String, String> {
    lost.iter()
        .filter(|(_, lost)| **lost > 0)
        .map(|(topic, lost)| (topic.clone(), lost.to_string()))
        .collect()
}
