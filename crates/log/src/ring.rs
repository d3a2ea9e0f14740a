//! The last minute, kept in memory: messages of all channels in the order in which they came, bounded in time and in bytes, and
//! what was in force before the first of them. Knows no file; whoever writes one asks for the messages by their numbers.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_board::Nanos;

use crate::writer::Times;

/// What a message costs besides its own bytes: its place in the queue, and what the allocator adds to it.
const OVERHEAD: usize = size_of::<Entry>() + 16;

/// Messages of the recent past.
pub(crate) struct Ring {
    entries: VecDeque<Entry>,
    /// Number of the oldest; they count from 0 and never change.
    first: u64,
    bytes: usize,
    most: usize,
    before: Nanos,
    /// What those that have gone say.
    base: InForce<Arc<[u8]>>,
    /// Messages that went before their time was up.
    short: u64,
}

/// A message, or that some were lost.
#[derive(Clone)]
pub(crate) struct Entry {
    pub(crate) channel: usize,
    pub(crate) times: Times,
    pub(crate) content: Content,
}

#[derive(Clone)]
pub(crate) enum Content {
    /// A message, and what it says about: its channel alone, or one schema or group of many on that channel.
    Message { about: About, data: Arc<[u8]> },
    /// That the value of a channel was taken back, told on this one.
    Retracted { of: usize, data: Arc<[u8]> },
    /// So many were lost.
    Lost(u64),
}

/// What stays as a message says until another one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum About {
    /// Nothing: it was an event.
    Nothing,
    /// The value of the channel.
    Value,
    /// The one of this name.
    Named(Arc<str>),
}

/// What stays as messages say until others: the newest message about each state.
#[derive(Default)]
pub(crate) struct InForce<Data>(BTreeMap<(usize, About), (Times, Data)>);

impl<Data: Default> InForce<Data> {
    /// The message about something on a channel, to be replaced.
    pub(crate) fn of(&mut self, channel: usize, about: About) -> &mut (Times, Data) {
        self.0.entry((channel, about)).or_default()
    }

    /// The channel has no value any more.
    pub(crate) fn retract(&mut self, channel: usize) {
        self.0.remove(&(channel, About::Value));
    }

    /// All of them: channel, when it was made, the message.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, Times, &Data)> {
        let all = self.0.iter();
        all.map(|((channel, _), (times, data))| (*channel, *times, data))
    }
}

impl Ring {
    /// Holds messages for so long, and at most so many bytes of them.
    pub(crate) fn new(before: Nanos, most: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            first: 0,
            bytes: 0,
            most,
            before,
            base: InForce::default(),
            short: 0,
        }
    }

    /// Adds a message; what there is no room for any more goes, the oldest first. Answers with its numbers and channels.
    pub(crate) fn push(&mut self, entry: Entry) -> Vec<(u64, usize)> {
        let mut gone = Vec::new();
        self.bytes += entry.cost();
        self.entries.push_back(entry);
        while self.bytes > self.most && self.entries.len() > 1 {
            gone.extend(self.entries.front().map(|oldest| (self.first, oldest.channel)));
            self.pop();
        }
        self.short += gone.len() as u64;
        gone
    }

    /// Lets go of what is older than it need be, up to number `keep`, which is still wanted.
    pub(crate) fn forget(&mut self, now: Nanos, keep: u64) {
        let since = now.saturating_sub(self.before);
        while self.first < keep
            && self
                .entries
                .front()
                .is_some_and(|oldest| oldest.times.log < since)
        {
            self.pop();
        }
    }

    /// Number of the oldest message.
    pub(crate) fn first(&self) -> u64 {
        self.first
    }

    /// Number that the next message will have.
    pub(crate) fn next(&self) -> u64 {
        self.first + self.entries.len() as u64
    }

    /// A message by its number; none if it has gone or not come yet.
    pub(crate) fn get(&self, number: u64) -> Option<&Entry> {
        let place = usize::try_from(number.checked_sub(self.first)?).ok()?;
        self.entries.get(place)
    }

    /// What was in force before the oldest message: its channel, when it was made, the message.
    pub(crate) fn base(&self) -> impl Iterator<Item = (usize, Times, &Arc<[u8]>)> {
        self.base.iter()
    }

    /// How many messages had to go before their time was up, so far.
    pub(crate) fn short(&self) -> u64 {
        self.short
    }

    fn pop(&mut self) {
        let Some(entry) = self.entries.pop_front() else {
            return;
        };
        self.first += 1;
        self.bytes -= entry.cost();
        match entry.content {
            Content::Message {
                about: About::Nothing,
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

impl Entry {
    /// Bytes it takes.
    pub(crate) fn cost(&self) -> usize {
        let data = match &self.content {
            Content::Message { data, .. } | Content::Retracted { data, .. } => data.len(),
            Content::Lost(_) => 0,
        };
        OVERHEAD + data
    }
}

#[cfg(test)]
mod tests;
