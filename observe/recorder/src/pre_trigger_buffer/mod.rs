//! The recent past in memory: the messages of all channels in the order of their arrival, limited in time and
//! in bytes, and the values that were in force before the first of them.
//!
//! The buffer is independent of files. The writer of a file reads the messages by their numbers.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_board::Nanos;

use crate::writer::Times;

/// The memory that a message needs besides its own bytes: its entry in the queue, and the allocator's
/// overhead.
const MESSAGE_OVERHEAD: usize = size_of::<BufferedMessage>() + 16;

/// The messages of the recent past.
pub(crate) struct PreTriggerBuffer {
    entries: VecDeque<BufferedMessage>,
    /// The number of the oldest message. Numbers start at 0 and never change.
    first: u64,
    bytes: usize,
    max_bytes: usize,
    duration: Nanos,
    /// The state that the removed messages leave in force.
    base: InForce<Arc<[u8]>>,
    /// Messages that were removed before their time ended.
    evicted: u64,
}

/// A message, or a count of lost messages.
#[derive(Clone)]
pub(crate) struct BufferedMessage {
    pub(crate) channel: usize,
    pub(crate) times: Times,
    pub(crate) content: Content,
}

#[derive(Clone)]
pub(crate) enum Content {
    /// A message and its subject: its channel alone, or one of several schemas or groups on that channel.
    Message { about: StateKey, data: Arc<[u8]> },
    /// A message that the value of another channel was retracted.
    Retracted { of: usize, data: Arc<[u8]> },
    /// The number of messages that were lost.
    Lost(u64),
}

/// The state that a message describes. It stays in force until the next message about the same state.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum StateKey {
    /// None: the message is an event.
    Stateless,
    /// The value of the channel.
    Value,
    /// The state of the schema or group of this name.
    Named(Arc<str>),
}

/// The messages in force: the newest one about each state.
#[derive(Default)]
pub(crate) struct InForce<Data>(BTreeMap<(usize, StateKey), (Times, Data)>);

impl<Data: Default> InForce<Data> {
    /// Returns the message about a state on a channel, to be replaced.
    pub(crate) fn of(&mut self, channel: usize, about: StateKey) -> &mut (Times, Data) {
        self.0.entry((channel, about)).or_default()
    }

    /// Removes the value of a channel.
    pub(crate) fn retract(&mut self, channel: usize) {
        self.0.remove(&(channel, StateKey::Value));
    }

    /// Returns all messages in force: channel, times, data.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, Times, &Data)> {
        let all = self.0.iter();
        all.map(|((channel, _), (times, data))| (*channel, *times, data))
    }
}

impl PreTriggerBuffer {
    /// Creates a buffer that keeps messages for `duration` ns, and at most `max_bytes` bytes of them.
    pub(crate) fn new(duration: Nanos, max_bytes: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            first: 0,
            bytes: 0,
            max_bytes,
            duration,
            base: InForce::default(),
            evicted: 0,
        }
    }

    /// Adds a message. If there is no room, the oldest messages are removed. Returns their numbers and
    /// channels.
    pub(crate) fn push(&mut self, entry: BufferedMessage) -> Vec<(u64, usize)> {
        let mut removed = Vec::new();
        self.bytes += entry.cost();
        self.entries.push_back(entry);
        while self.bytes > self.max_bytes && self.entries.len() > 1 {
            removed.extend(self.entries.front().map(|oldest| (self.first, oldest.channel)));
            self.pop();
        }
        self.evicted += removed.len() as u64;
        removed
    }

    /// Removes messages that are older than the time limit, but none from number `keep` on, which are still
    /// needed.
    pub(crate) fn expire(&mut self, now: Nanos, keep: u64) {
        let since = now.saturating_sub(self.duration);
        while self.first < keep
            && self
                .entries
                .front()
                .is_some_and(|oldest| oldest.times.log < since)
        {
            self.pop();
        }
    }

    /// Returns the number of the oldest message.
    pub(crate) fn first(&self) -> u64 {
        self.first
    }

    /// Returns the number of the next message.
    pub(crate) fn next(&self) -> u64 {
        self.first + self.entries.len() as u64
    }

    /// Returns a message by its number. `None` if it was removed or has not arrived yet.
    pub(crate) fn get(&self, number: u64) -> Option<&BufferedMessage> {
        let index = usize::try_from(number.checked_sub(self.first)?).ok()?;
        self.entries.get(index)
    }

    /// Returns the messages that were in force before the oldest one: channel, times, data.
    pub(crate) fn base(&self) -> impl Iterator<Item = (usize, Times, &Arc<[u8]>)> {
        self.base.iter()
    }

    /// Returns how many messages were removed before their time ended.
    pub(crate) fn evicted(&self) -> u64 {
        self.evicted
    }

    fn pop(&mut self) {
        let Some(entry) = self.entries.pop_front() else {
            return;
        };
        self.first += 1;
        self.bytes -= entry.cost();
        match entry.content {
            Content::Message {
                about: StateKey::Stateless,
                ..
            }
            | Content::Lost(_) => {}
            Content::Message { about, data } => {
                *self.base.of(entry.channel, about) = (entry.times, data);
            }
            Content::Retracted { of, .. } => {
                self.base.retract(of);
            }
        }
    }
}

impl BufferedMessage {
    /// Returns the bytes of memory that the entry needs.
    pub(crate) fn cost(&self) -> usize {
        let data = match &self.content {
            Content::Message { data, .. } | Content::Retracted { data, .. } => data.len(),
            Content::Lost(_) => 0,
        };
        MESSAGE_OVERHEAD + data
    }
}

#[cfg(test)]
mod tests;
