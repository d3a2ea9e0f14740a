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
    /// The newest of those that have gone, of every state that stays until the next.
    base: BTreeMap<State, (Times, Arc<[u8]>)>,
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

/// The channel and what on it.
type State = (usize, About);

impl Ring {
    /// Holds messages for so long, and at most so many bytes of them.
    pub(crate) fn new(before: Nanos, most: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            first: 0,
            bytes: 0,
            most,
            before,
            base: BTreeMap::new(),
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
        self.base
            .iter()
            .map(|((channel, _), (times, data))| (*channel, *times, data))
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
                about: About::Nothing, ..
            }
            | Content::Lost(_) => {}
            Content::Message { about, data } => {
                self.base.insert((entry.channel, about), (entry.times, data));
            }
            Content::Retracted { of, .. } => {
                self.base.remove(&(of, About::Value));
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
mod tests {
    use super::*;

    fn value(channel: usize, log: Nanos, bytes: usize) -> Entry {
        Entry {
            channel,
            times: Times {
                log,
                publish: log,
                sequence: log,
            },
            content: Content::Message {
                about: About::Value,
                data: vec![0; bytes].into(),
            },
        }
    }

    fn times(ring: &Ring) -> Vec<Nanos> {
        (ring.first()..ring.next())
            .map(|number| ring.get(number).unwrap().times.log)
            .collect()
    }

    #[test]
    fn what_is_older_than_the_time_goes_and_the_newest_of_it_stays_in_force() {
        let mut ring = Ring::new(100, usize::MAX);
        for (channel, log) in [(0, 10), (1, 20), (1, 30), (0, 110), (1, 120)] {
            ring.push(value(channel, log, 8));
        }
        ring.forget(131, ring.next());
        assert_eq!(times(&ring), [110, 120]);
        let base: Vec<_> = ring.base().map(|(channel, times, _)| (channel, times.log)).collect();
        assert_eq!(base, [(0, 10), (1, 30)]);
        assert_eq!((ring.first(), ring.next(), ring.short()), (3, 5, 0));
        assert!(ring.get(2).is_none() && ring.get(5).is_none());
    }

    #[test]
    fn what_is_still_wanted_stays_and_memory_is_bounded_all_the_same() {
        let mut ring = Ring::new(0, 10 * (OVERHEAD + 100));
        for log in 0..10 {
            ring.push(value(0, log, 100));
        }
        ring.forget(1000, 4);
        assert_eq!(times(&ring), [4, 5, 6, 7, 8, 9]);
        for log in 10..20 {
            ring.push(value(0, log, 100));
        }
        assert_eq!(times(&ring), (10..20).collect::<Vec<_>>());
        assert_eq!(ring.short(), 6);
        ring.push(value(0, 20, 5000));
        assert_eq!(times(&ring), [20], "the newest is always there");
    }

    #[test]
    fn a_value_that_was_taken_back_is_not_in_force_and_states_are_told_apart() {
        let mut ring = Ring::new(0, usize::MAX);
        ring.push(value(0, 1, 8));
        let mut entry = value(1, 2, 8);
        entry.content = Content::Retracted {
            of: 0,
            data: Arc::new([]),
        };
        ring.push(entry);
        for (log, name) in [(3, "goon"), (4, "stop"), (5, "goon")] {
            let mut entry = value(2, log, 8);
            entry.content = Content::Message {
                about: About::Named(name.into()),
                data: Arc::new([]),
            };
            ring.push(entry);
        }
        ring.forget(1000, ring.next());
        let base: Vec<_> = ring.base().map(|(channel, times, _)| (channel, times.log)).collect();
        assert_eq!(base, [(2, 5), (2, 4)], "the last of each, by name");
    }
}
