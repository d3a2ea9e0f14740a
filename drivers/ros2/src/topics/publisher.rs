//! The publications of a jde robot: each sends new values while it has subscribers.

use jde_ros_node::{Clock, Node, Quality, Topic, names};
use jde_schema::prelude::*;

use crate::messages::{Codec, Stamped};

/// Most messages of one topic at once. A subscription of ROS 2's profile for sensors keeps five.
const MOST_AT_ONCE: usize = 4;

/// Messages of one topic that are sent in several iterations.
#[derive(Debug, Default)]
pub(super) struct Spread(std::vec::IntoIter<Vec<u8>>);

impl Spread {
    pub(super) fn new(messages: Vec<Vec<u8>>) -> Self {
        Self(messages.into_iter())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.len() == 0
    }

    /// Takes the messages of one iteration.
    pub(super) fn part(&mut self) -> Vec<Vec<u8>> {
        self.0.by_ref().take(MOST_AT_ONCE).collect()
    }
}

/// A publication.
pub(super) struct TopicPublisher<T> {
    pub(super) number: usize,
    pub(super) codec: Codec<T>,
    /// Sequence number of the last value sent.
    sent: u64,
}

/// The topics of a node.
pub(super) struct Publications<'n> {
    namespace: &'n str,
    pub(super) topics: Vec<Topic>,
}

impl<'n> Publications<'n> {
    pub(super) fn new(namespace: &'n str) -> Self {
        Self {
            namespace,
            topics: Vec::new(),
        }
    }

    /// Adds a publication of that topic, unless its name is empty or its import is not bound.
    pub(super) fn add<T: Value>(
        &mut self,
        bound: bool,
        name: Text<128>,
        quality: Quality,
    ) -> Result<Option<TopicPublisher<T>>> {
        let topic = names::topic(self.namespace, name.as_str())?;
        let Some(topic) = topic.filter(|_| bound) else {
            return Ok(None);
        };
        if self.topics.iter().any(|other| other.name == topic) {
            return Err(format!(
                "two of its topics have the name {topic}; rename one of them, or set it to \"\""
            )
            .into());
        }
        let codec = Codec::new();
        self.topics.push(codec.topic(topic, quality));
        Ok(Some(TopicPublisher {
            number: self.topics.len() - 1,
            codec,
            sent: 0,
        }))
    }
}

/// Returns a publication that has subscribers, with its new value; `None` otherwise.
pub(super) fn take_due<'a, 'call, T, V: Value>(
    node: &Node,
    publisher: &'a mut Option<TopicPublisher<T>>,
    value: Option<Sample<'call, V>>,
) -> Option<(&'a TopicPublisher<T>, Sample<'call, V>)> {
    let (publisher, value) = (publisher.as_mut()?, value?);
    if publisher.sent == value.sequence() || !node.has_subscribers(publisher.number) {
        return None;
    }
    publisher.sent = value.sequence();
    Some((publisher, value))
}

/// Publishes a new value if it has subscribers.
pub(super) fn publish_new<T: Stamped>(
    node: &Node,
    clock: &Clock,
    publisher: &mut Option<TopicPublisher<T>>,
    value: Option<Sample<'_, T>>,
) {
    if let Some((publisher, value)) = take_due(node, publisher, value) {
        let message = publisher.codec.encode_stamped(&value, value.time(), clock);
        node.publish(publisher.number, vec![message]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_spread_in_order_and_fit_a_queue_of_five() {
        let mut spread = Spread::new((0..16).map(|number| vec![number]).collect());
        let mut sent = Vec::new();
        while !spread.is_empty() {
            let part = spread.part();
            assert!(part.len() < 5, "{}", part.len());
            sent.extend(part.into_iter().flatten());
        }
        assert_eq!(sent, Vec::from_iter(0..16));
    }
}
