//! Shared by the drivers of this plugin: a node, the clocks of both sides, and reports of the connection. It
//! does not depend on any topic.

use core::time::Duration;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_device::{ConnectionReport, ConnectionState};
use jde_ros_node::{Clock, Measured, Node, NodeConfig, NodeState};
use jde_schema::prelude::*;

use crate::messages::Codec;

/// Most warnings until the driver wakes again.
const MAX_WARNINGS: usize = 32;

/// A node and its state.
pub(crate) struct RosConnection {
    pub(crate) node: Node,
    pub(crate) clock: Clock,
    report: ConnectionReport,
    warnings: Vec<String>,
    /// Its name, domain and address, for messages.
    description: String,
}

/// A subscription.
pub(crate) struct TopicSubscription<T> {
    number: usize,
    topic: String,
    codec: Codec<T>,
    /// Arrival of the newest readable message, until it is stale.
    last_received: Option<Duration>,
}

impl RosConnection {
    pub(crate) fn start(config: NodeConfig) -> Result<Self> {
        let description = format!(
            "node {}, domain {}, {}",
            config.name.full(),
            config.name.domain,
            config.endpoint
        );
        Ok(Self {
            node: Node::start(config)?,
            clock: Clock::default(),
            report: ConnectionReport::default(),
            warnings: Vec::new(),
            description,
        })
    }

    /// Compares the clocks and logs new remarks. Called first in each iteration.
    pub(crate) fn begin(&mut self, cx: &Context) {
        let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        self.clock.compare(cx.now(), wall);
        for remark in self.node.remarks() {
            warn!(cx, "{remark}");
        }
    }

    /// Warns of an invalid message, once per text.
    pub(crate) fn warn_once(&mut self, cx: &Context, message: String) {
        if self.warnings.len() >= MAX_WARNINGS || self.warnings.contains(&message) {
            return;
        }
        warn!(cx, "{message}");
        self.warnings.push(message);
        if self.warnings.len() == MAX_WARNINGS {
            warn!(cx, "too many different warnings; further ones are not logged");
        }
    }

    /// Takes the newest message of a subscription into `value`. Returns the time of its arrival.
    pub(crate) fn receive<T: Value>(
        &mut self,
        cx: &Context,
        subscription: &mut TopicSubscription<T>,
        value: &mut T,
    ) -> Option<Duration> {
        let (message, arrived) = self.take(cx, subscription.number)?;
        match subscription.codec.decode_into(&message, value) {
            Ok(()) => Some(arrived),
            Err(error) => {
                self.warn_once(cx, format!("{}: {error}", subscription.topic));
                None
            }
        }
    }

    /// Takes the newest message of the subscription of that number, and the time of its arrival.
    pub(crate) fn take(&self, cx: &Context, number: usize) -> Option<(Vec<u8>, Duration)> {
        let arrived = self.node.take(number)?;
        let age = arrived.received_at.elapsed();
        Some((
            arrived.message.to_bytes().into_owned(),
            cx.now().saturating_sub(age),
        ))
    }

    /// Returns when a value with this arrival was measured, and sets its stamp to that time.
    pub(crate) fn stamp<T: Value>(
        &mut self,
        cx: &Context,
        subscription: &TopicSubscription<T>,
        header: &mut Header,
        arrived: Duration,
    ) -> Duration {
        let time = self.measured(cx, &subscription.topic, header.stamp, arrived);
        header.stamp = time.into();
        time
    }

    /// Returns when a message of a topic with this stamp and arrival was measured: at its arrival if it has no stamp.
    pub(crate) fn measured(&mut self, cx: &Context, topic: &str, stamp: Time, arrived: Duration) -> Duration {
        if stamp == Time::default() {
            return arrived;
        }
        match self.clock.measured(stamp, arrived) {
            Measured::At(time) => time,
            Measured::OnArrival(time, ahead) => {
                let side = if ahead < 0.0 { "behind" } else { "ahead of" };
                let prefix = format!("{topic} is stamped ");
                let message = format!(
                    "{prefix}{:.0} s {side} this clock, perhaps in simulated time: the time of its arrival is used instead",
                    ahead.abs()
                );
                if !self.warnings.iter().any(|warning| warning.starts_with(&prefix)) {
                    self.warn_once(cx, message);
                }
                time
            }
        }
    }

    /// Reports the node's connection. `missing` names the missing counterpart of a connected node.
    pub(crate) fn export_connection(
        &mut self,
        cx: &Context,
        export: &mut Export<Connection>,
        missing: Option<&str>,
    ) {
        let (node_state, attempts) = self.node.state();
        let state = match (&node_state, missing) {
            (NodeState::Connecting, _) => ConnectionState::Connecting,
            (NodeState::Alone, _) => ConnectionState::Probing("other nodes"),
            (NodeState::Connected, Some(missing)) => ConnectionState::Probing(missing),
            (NodeState::Connected, None) => ConnectionState::Connected(&self.description),
            (NodeState::Lost(reason), _) => ConnectionState::Lost(reason),
        };
        self.report.update(cx, export, state, attempts);
    }

    /// Sends the submitted messages and ends the node. Waits for that for 300 ms at most, and not at all if the
    /// node publishes nothing.
    pub(crate) fn close(mut self, cx: &Context, export: &mut Export<Connection>) {
        self.node.close();
        self.report.retract(cx, export);
    }
}

impl<T: Value> TopicSubscription<T> {
    /// The subscription of that number.
    pub(crate) fn new(number: usize, topic: String, codec: Codec<T>) -> Self {
        Self {
            number,
            topic,
            codec,
            last_received: None,
        }
    }

    /// The name of its topic.
    pub(crate) fn topic(&self) -> &str {
        &self.topic
    }

    /// Records a valid message.
    pub(crate) fn mark_received(&mut self, arrived: Duration) {
        self.last_received = Some(arrived);
    }

    /// Whether its newest message is not stale.
    pub(crate) fn has_received(&self) -> bool {
        self.last_received.is_some()
    }

    /// Returns whether its newest message has just become older than `timeout`.
    pub(crate) fn falls_silent(&mut self, now: Duration, timeout: Duration) -> bool {
        let silent = self
            .last_received
            .is_some_and(|received| now > received + timeout);
        if silent {
            self.last_received = None;
        }
        silent
    }
}
