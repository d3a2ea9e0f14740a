//! The destination of messages: one file for the whole recording, one file after the other, or the files that
//! conditions cause. No sink blocks the writing thread forever: it counts what it cannot write.

mod continuous;
mod current_file;
mod file;
mod names;
mod split;
mod syncer;
mod triggered;

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;
use jde_conditions::Firing;
use jde_log::record;
use jde_records::RecordKind;
use jde_ros::definition;

use crate::pre_trigger_buffer::StateKey;
use crate::topic::{Shared, TopicContent, TopicQueue};
use crate::writer::{Times, Writer};

pub(crate) use continuous::ContinuousSink;
pub(crate) use file::OpenFile;
pub(crate) use split::PartSequence;
pub(crate) use syncer::Disk;
pub(crate) use triggered::{Plan, TriggeredSink};

/// A destination of messages. It receives them in the order of their arrival.
pub(crate) trait Sink: Send {
    /// Adds a channel. Channels have the numbers 0, 1, 2 and so on, in the order of these calls.
    fn open(&mut self, channel: SinkChannel);

    /// Writes a message.
    fn write_message(&mut self, channel: usize, times: Times, data: &[u8], effect: Effect);

    /// Reports that a condition became true by the last message.
    fn fired(&mut self, firing: &Firing, condition: &str);

    /// Called after all messages that had arrived. Returns whether there is more work to do at once. `now` is
    /// the application's time.
    fn poll(&mut self, now: Nanos) -> bool;

    /// Called after the last message.
    fn finish(&mut self);
}

/// The effect of a message on the values in force.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// A state is in force until the next message about it.
    State(StateKey),
    /// Another channel no longer has a value.
    Retracts(usize),
}

/// The contents of a channel.
#[derive(Clone)]
pub(crate) enum SinkChannel {
    /// Records of selections, states and events.
    Records(RecordKind),
    /// Values of a variable, or other messages.
    Topic(Arc<TopicQueue>),
}

impl SinkChannel {
    fn add_to(&self, writer: &mut Writer) -> io::Result<u16> {
        match self {
            Self::Records(kind) => writer.channel(kind.topic(), record::schema(*kind), BTreeMap::new()),
            Self::Topic(queue) => {
                let (name, text);
                let schema = match &queue.content {
                    TopicContent::Values(value_type) => {
                        (name, text) = (definition::name(value_type), definition::definition(value_type));
                        (name.as_str(), text.as_str())
                    }
                    TopicContent::Messages { schema, .. } => *schema,
                };
                writer.channel(&queue.name, schema, queue.metadata.clone())
            }
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Records(kind) => kind.topic(),
            Self::Topic(queue) => &queue.name,
        }
    }

    /// Counts messages that no file contains.
    fn add_lost(&self, count: u64, shared: &Shared) {
        match self {
            Self::Records(_) => shared.lost_events.fetch_add(count, Ordering::Relaxed),
            Self::Topic(queue) => queue.lost.fetch_add(count, Ordering::Relaxed),
        };
    }
}

/// Returns the metadata of a file about its lost messages: the number for each topic.
fn lost_metadata(lost: &BTreeMap<String, u64>) -> BTreeMap<String, String> {
    lost.iter()
        .filter(|(_, lost)| **lost > 0)
        .map(|(topic, lost)| (topic.clone(), lost.to_string()))
        .collect()
}
