//! The publications of a jde robot: each sends new values while it has subscribers.

use jde_schema::prelude::*;

use crate::clock::Clock;
use crate::keys::{Quality, Topic};
use crate::messages::{Codec, Stamped};
use crate::node::Node;

/// A publication.
pub(super) struct TopicPublisher<T> {
    pub(super) number: usize,
    pub(super) codec: Codec<T>,
    /// Sequence number of the last value sent.
    sent: u64,
}

/// Adds a publication of that topic, unless its name is empty or its import is not bound.
pub(super) fn topic_publisher<T: Value>(
    topics: &mut Vec<Topic>,
    namespace: &str,
    bound: bool,
    name: &Text<128>,
    quality: Quality,
) -> Result<Option<TopicPublisher<T>>> {
    let topic = crate::names::topic(namespace, name.as_str())?;
    let Some(topic) = topic.filter(|_| bound) else {
        return Ok(None);
    };
    if topics.iter().any(|other| other.name == topic) {
        return Err(format!("two of its topics are called {topic}; give one another name, or \"\"").into());
    }
    let codec = Codec::new();
    topics.push(codec.topic(topic, quality));
    Ok(Some(TopicPublisher {
        number: topics.len() - 1,
        codec,
        sent: 0,
    }))
}

/// Returns a publication that has subscribers, with its new value; `None` otherwise.
pub(super) fn due<'a, 'call, T, V: Value>(
    node: &Node,
    outlet: &'a mut Option<TopicPublisher<T>>,
    value: Option<Sample<'call, V>>,
) -> Option<(&'a TopicPublisher<T>, Sample<'call, V>)> {
    let (outlet, value) = (outlet.as_mut()?, value?);
    if outlet.sent == value.sequence() || !node.is_wanted(outlet.number) {
        return None;
    }
    outlet.sent = value.sequence();
    Some((outlet, value))
}

/// Publishes a new value if it has subscribers.
pub(super) fn offer<T: Stamped>(
    node: &Node,
    clock: &Clock,
    outlet: &mut Option<TopicPublisher<T>>,
    value: Option<Sample<'_, T>>,
) {
    if let Some((outlet, value)) = due(node, outlet, value) {
        let message = outlet.codec.encode_stamped(&value, value.time(), clock);
        node.publish(outlet.number, vec![message]);
    }
}
