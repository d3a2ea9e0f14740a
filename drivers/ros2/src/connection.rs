//! Shared by the drivers of this plugin: a node, the clocks of both sides, and reports of the connection. It
//! knows no topics.

use core::time::Duration;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_device::{ConnectionReport, ConnectionState};
use jde_schema::prelude::*;

use crate::clock::{Clock, Measured};
use crate::messages::Codec;
use crate::node::{Node, NodeConfig, NodeState};

/// Most complaints until the driver wakes again.
const MAX_WARNINGS: usize = 32;

/// A node and its state.
pub(crate) struct RosConnection {
    pub(crate) node: Node,
    pub(crate) clock: Clock,
    report: ConnectionReport,
    warnings: Vec<String>,
    /// Its name, domain and address, for messages.
    who: String,
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
    pub(crate) fn start(plan: NodeConfig) -> Result<Self> {
        let who = format!(
            "node {}, domain {}, {}",
            plan.name.full(),
            plan.name.domain,
            plan.endpoint
        );
        Ok(Self {
            node: Node::start(plan)?,
            clock: Clock::default(),
            report: ConnectionReport::default(),
            warnings: Vec::new(),
            who,
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
    pub(crate) fn warn_once(&mut self, cx: &Context, words: String) {
        if self.warnings.len() >= MAX_WARNINGS || self.warnings.contains(&words) {
            return;
        }
        warn!(cx, "{words}");
        self.warnings.push(words);
        if self.warnings.len() == MAX_WARNINGS {
            warn!(cx, "so much is wrong that no more of it is said");
        }
    }

    /// Takes the newest message of a subscription into `value`. Returns the time of its arrival.
    pub(crate) fn receive<T: Value>(
        &mut self,
        cx: &Context,
        inlet: &mut TopicSubscription<T>,
        value: &mut T,
    ) -> Option<Duration> {
        let arrived = self.node.take(inlet.number)?;
        match inlet.codec.decode_into(&arrived.message.to_bytes(), value) {
            Ok(()) => Some(cx.now().saturating_sub(arrived.received_at.elapsed())),
            Err(error) => {
                self.warn_once(cx, format!("{}: {error}", inlet.topic));
                None
            }
        }
    }

    /// Returns when a value with this arrival was measured, and sets its stamp to that time.
    pub(crate) fn stamp<T: Value>(
        &mut self,
        cx: &Context,
        inlet: &TopicSubscription<T>,
        header: &mut Header,
        arrived: Duration,
    ) -> Duration {
        let time = match self.clock.measured(header.stamp, arrived) {
            Measured::At(time) => time,
            Measured::OnArrival(time, ahead) => {
                let side = if ahead < 0.0 { "behind" } else { "ahead of" };
                let words = format!(
                    "{} is stamped {:.0} s {side} this clock, perhaps in simulated time: its arrival counts instead",
                    inlet.topic,
                    ahead.abs()
                );
                let known = format!("{} is stamped ", inlet.topic);
                if !self.warnings.iter().any(|told| told.starts_with(&known)) {
                    self.warn_once(cx, words);
                }
                time
            }
        };
        header.stamp = time.into();
        time
    }

    /// Reports the node's connection. `looking` names the missing counterpart of a connected node.
    pub(crate) fn export_connection(
        &mut self,
        cx: &Context,
        export: &mut Export<Connection>,
        looking: Option<&str>,
    ) {
        let (link, attempts) = self.node.state();
        let standing = match (&link, looking) {
            (NodeState::Connecting, _) => ConnectionState::Connecting,
            (NodeState::Alone, _) => ConnectionState::Probing("other nodes"),
            (NodeState::Connected, Some(looking)) => ConnectionState::Probing(looking),
            (NodeState::Connected, None) => ConnectionState::Connected(&self.who),
            (NodeState::Lost(why), _) => ConnectionState::Lost(why),
        };
        self.report.update(cx, export, standing, attempts);
    }

    /// Sends the submitted messages and ends the node.
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

    /// Whether its newest message still counts.
    pub(crate) fn has_received(&self) -> bool {
        self.last_received.is_some()
    }

    /// Returns whether its newest message has just become older than `patience`.
    pub(crate) fn falls_silent(&mut self, now: Duration, patience: Duration) -> bool {
        let silent = self.last_received.is_some_and(|heard| now > heard + patience);
        if silent {
            self.last_received = None;
        }
        silent
    }
}
