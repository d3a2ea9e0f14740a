//! The messages of a publication that wait until the thread of the node sends them.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::keys::Topic;

/// Most messages at once of a topic with a gap, if the thread is late.
const MOST_AT_ONCE: usize = 2;

/// Messages to send, the oldest first.
#[derive(Debug)]
pub(crate) struct Outbox {
    messages: VecDeque<Vec<u8>>,
    depth: usize,
    is_latched: bool,
    gap: Duration,
    /// When the next message may be sent.
    due: Instant,
}

impl Outbox {
    /// Without messages.
    pub(crate) fn new(topic: &Topic) -> Self {
        Self {
            messages: VecDeque::new(),
            depth: topic.quality.depth,
            is_latched: topic.quality.latched,
            gap: topic.gap,
            due: Instant::now(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Replaces the messages that were not sent in time.
    pub(crate) fn replace(&mut self, messages: Vec<Vec<u8>>) {
        self.messages = messages.into();
        self.due = self.due.max(Instant::now());
    }

    /// Adds a message. The oldest ones beyond the depth of the topic are dropped.
    pub(crate) fn append(&mut self, message: Vec<u8>) {
        self.messages.push_back(message);
        let surplus = self.messages.len().saturating_sub(self.depth);
        self.messages.drain(..surplus);
    }

    /// Drops what is late, unless it is latched.
    pub(crate) fn drop_volatile(&mut self) {
        if !self.is_latched {
            self.messages.clear();
        }
    }

    /// Returns the time until a message may be sent; `None` without messages.
    pub(crate) fn pause(&self, now: Instant) -> Option<Duration> {
        (!self.is_empty()).then(|| self.due.saturating_duration_since(now))
    }

    /// Takes the messages to send now: those that are due if the topic has a gap between two, and all of them at the end.
    pub(crate) fn take(&mut self, now: Instant, is_ending: bool) -> Vec<Vec<u8>> {
        if self.gap.is_zero() || is_ending {
            return std::mem::take(&mut self.messages).into();
        }
        let mut taken = Vec::new();
        while now >= self.due
            && taken.len() < MOST_AT_ONCE
            && let Some(message) = self.messages.pop_front()
        {
            taken.push(message);
            self.due += self.gap;
        }
        if !taken.is_empty() && self.due <= now {
            self.due = now + self.gap;
        }
        taken
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Twist, Value as _};

    use super::*;
    use crate::keys::Quality;

    #[test]
    fn messages_of_a_topic_with_a_gap_are_sent_one_at_a_time_and_all_at_the_end() {
        let gap = Duration::from_millis(2);
        let topic = Topic::new("/sonar".to_owned(), &Twist::describe(), Quality::SENSOR_DATA);
        let mut outbox = Outbox::new(&Topic { gap, ..topic });
        outbox.replace((0..16).map(|number| vec![number]).collect());
        let begin = Instant::now();
        outbox.due = begin;
        let sent: Vec<_> = (0..8)
            .map(|millisecond| outbox.take(begin + Duration::from_millis(millisecond), false))
            .collect();
        let expected: Vec<Vec<Vec<u8>>> = (0..8)
            .map(|millisecond| match millisecond % 2 {
                0 => vec![vec![millisecond / 2]],
                _ => Vec::new(),
            })
            .collect();
        assert_eq!(sent, expected);
        let last = begin + Duration::from_millis(6);
        assert_eq!(outbox.pause(last + gap / 4), Some(3 * gap / 4));
        assert_eq!(outbox.pause(last + 9 * gap), Some(Duration::ZERO));
        // Due were those of 8, 10, 12 and 14 ms; two of them make good for the delay.
        let late = last + 4 * gap + gap / 2;
        assert_eq!(outbox.take(late, false), [[4], [5]]);
        assert_eq!(outbox.pause(late), Some(gap));
        assert_eq!(outbox.take(late, true).len(), 10);
        assert_eq!(outbox.pause(late), None);
    }
}
