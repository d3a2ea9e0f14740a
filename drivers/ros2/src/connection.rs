//! Shared by the drivers of this plugin: a node, the clocks of both sides, and reports of the connection. It
//! does not depend on any topic.

use core::time::Duration;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_device::{ConnectionReport, ConnectionState};
use jde_ros_node::{
    Announced, Arrival, Clock, Measured, Node, NodeConfig, NodeState, Quality, ReceivedMessage, Topic,
};
use jde_schema::ListedExport;
use jde_schema::prelude::*;

use crate::clock_source::{self, ClockMessage, ClockSource, ClockWatch, Tick};
use crate::described::DescribedCodec;
use crate::messages::Codec;

/// Most warnings until the driver wakes again.
const MAX_WARNINGS: usize = 32;

/// A node and its state.
pub(crate) struct RosConnection {
    pub(crate) node: Node,
    pub(crate) clock: Clock,
    source: ClockSource,
    /// The topic of the time of a simulation, which is subscribed to while it is followed.
    followed: Option<TopicSubscription<ClockMessage>>,
    watch: ClockWatch,
    /// The publication of the time of the application, if that is the one of ROS 2.
    published: Option<(usize, Codec<ClockMessage>)>,
    /// Whether the time of ROS 2 has jumped in this turn.
    jumped: bool,
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
    is_used: bool,
}

/// Lets what arrives at a node request a turn of its schema, which then does not wait for its period.
pub(crate) fn arrival(cx: &Context) -> Arrival {
    let requester = cx.turn_requester();
    requester.map_or_else(Arrival::default, |requester| {
        Arrival::new(move || requester.request())
    })
}

impl RosConnection {
    pub(crate) fn start(mut config: NodeConfig, source: ClockSource) -> Result<Self> {
        let (codec, name) = (Codec::new(), clock_source::TOPIC.to_owned());
        let number = config.subscriptions.len();
        config.subscriptions.push(Topic {
            announced: Announced::WhileWanted,
            has_one_source: true,
            ..codec.topic(name.clone(), Quality::SENSOR_DATA)
        });
        // A clock of 1 kHz is no reason for as many iterations.
        config.arrival = config.arrival.except(number);
        let followed = TopicSubscription::new(number, name.clone(), codec);
        let published = (source == ClockSource::Publish).then(|| {
            let codec = Codec::new();
            config.publications.push(codec.topic(name, Quality::DEFAULT));
            (config.publications.len() - 1, codec)
        });
        let description = format!(
            "node {}, domain {}, {}",
            config.name.full(),
            config.name.domain,
            config.endpoint
        );
        let node = Node::start(config)?;
        node.want(number, source == ClockSource::Follow);
        Ok(Self {
            node,
            clock: Clock::default(),
            source,
            followed: Some(followed),
            watch: ClockWatch::default(),
            published,
            jumped: false,
            report: ConnectionReport::default(),
            warnings: Vec::new(),
            description,
        })
    }

    /// Compares the clocks and logs new remarks. Called first in each iteration, with the clock that the schema states now.
    /// Returns whether the time of ROS 2 has jumped, or is another one.
    pub(crate) fn begin(&mut self, cx: &Context, source: ClockSource) -> bool {
        for remark in self.node.remarks() {
            warn!(cx, "{remark}");
        }
        let is_chosen = self.choose(cx, source);
        let now = cx.now();
        let jumped = match self.source {
            ClockSource::Wall => {
                let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
                self.clock.compare(now, time)
            }
            ClockSource::Follow => self.follow(cx),
            ClockSource::Publish => {
                if let Some((number, codec)) = &self.published {
                    let message = ClockMessage { clock: now.into() };
                    self.node.publish(*number, vec![codec.encode(&message)]);
                }
                self.clock.compare(now, now)
            }
        };
        self.jumped = jumped || is_chosen;
        self.jumped
    }

    /// Takes another clock while the schema is awake. Returns whether it is another one.
    fn choose(&mut self, cx: &Context, source: ClockSource) -> bool {
        if source == self.source {
            return false;
        }
        if [source, self.source].contains(&ClockSource::Publish) {
            let message = "clock = \"publish\" begins and ends when the schema awakes, not while it is awake";
            self.warn_once(cx, message.to_owned());
            return false;
        }
        self.source = source;
        if let Some(followed) = &self.followed {
            self.node.want(followed.number, source == ClockSource::Follow);
        }
        (self.clock, self.watch) = (Clock::default(), ClockWatch::default());
        true
    }

    /// Follows the time of a simulation. Returns whether it has jumped.
    fn follow(&mut self, cx: &Context) -> bool {
        let Some(followed) = self.followed.take() else {
            return false;
        };
        let mut message = ClockMessage::default();
        let arrived = self.receive(cx, &followed, &mut message);
        self.followed = Some(followed);
        let time = message.clock.into();
        let tick = arrived.map_or(Tick::Same, |arrived| self.watch.take(arrived, time));
        let (jumped, step, direction) = match tick {
            Tick::Onward => (false, Duration::ZERO, ""),
            Tick::Forward(step) => (true, step, "forward"),
            Tick::Back(step) => (true, step, "back"),
            Tick::Same => {
                if self.watch.ends(cx.now()) {
                    self.clock = Clock::default();
                    let message = "the time on /clock stands: nothing with a stamp is taken or published until it goes on; is the \
                                   simulation paused, or has it ended?";
                    self.warn_once(cx, message.to_owned());
                }
                return false;
            }
        };
        if jumped {
            self.clock = Clock::default();
            let prefix = format!("the time on /clock has jumped {direction}, ");
            if !self.warnings.iter().any(|warning| warning.starts_with(&prefix)) {
                let step = step.as_secs_f64();
                let message = format!("{prefix}by {step:.1} s: what was measured before has ended");
                self.warn_once(cx, message);
            }
        }
        self.clock.compare(arrived.unwrap_or_default(), time);
        jumped
    }

    /// Whether there is no time of ROS 2 with which stamps can be compared.
    pub(crate) fn is_timeless(&self) -> bool {
        self.source == ClockSource::Follow && !self.clock.is_known()
    }

    /// Whether what came from the subscription of that number has ended: the time of ROS 2 has jumped in this turn or is none,
    /// or several nodes send its messages.
    pub(crate) fn has_ended(&self, number: usize) -> bool {
        self.jumped || self.is_timeless() || self.node.is_contradicted(number)
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
        subscription: &TopicSubscription<T>,
        value: &mut T,
    ) -> Option<Duration> {
        let (received, arrived) = self.take(cx, subscription.number)?;
        self.decode(cx, subscription, &received, value).then_some(arrived)
    }

    /// Takes all messages of the subscription of that number, the oldest first, with the times of their arrival.
    pub(crate) fn take_all(&self, cx: &Context, number: usize) -> Vec<(ReceivedMessage, Duration)> {
        let received = self.node.take_all(number).into_iter();
        received
            .map(|received| {
                let arrived = self.arrived(cx, &received);
                (received, arrived)
            })
            .collect()
    }

    /// Takes the newest message of the subscription of that number, and the time of its arrival.
    pub(crate) fn take(&self, cx: &Context, number: usize) -> Option<(ReceivedMessage, Duration)> {
        let received = self.node.take(number)?;
        let arrived = self.arrived(cx, &received);
        Some((received, arrived))
    }

    fn arrived(&self, cx: &Context, received: &ReceivedMessage) -> Duration {
        match self.source {
            // Time that is not that of the machine passes otherwise.
            ClockSource::Publish => cx.now(),
            ClockSource::Wall | ClockSource::Follow => {
                cx.now().saturating_sub(received.received_at.elapsed())
            }
        }
    }

    /// Decodes a message. Returns whether it is valid, and reports it otherwise.
    fn decode<T: Value>(
        &mut self,
        cx: &Context,
        subscription: &TopicSubscription<T>,
        received: &ReceivedMessage,
        value: &mut T,
    ) -> bool {
        let decoded = subscription.codec.decode_into(&received.pieces(), value);
        if let Err(error) = &decoded {
            self.warn_once(cx, format!("{}: {error}", subscription.topic));
        }
        decoded.is_ok()
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
                    "{prefix}{:.0} s {side} this clock, perhaps in simulated time, which clock = \"follow\" takes: the time of its arrival is used instead",
                    ahead.abs()
                );
                let is_new = !self.warnings.iter().any(|warning| warning.starts_with(&prefix));
                if is_new && self.clock.is_known() {
                    self.warn_once(cx, message);
                }
                time
            }
        }
    }

    /// Returns whether a message of a topic was measured at most `stale` before its arrival, and says once if it was not.
    /// One without such a limit always was. None was while there is no time with which stamps can be compared.
    pub(crate) fn is_fresh(
        &mut self,
        cx: &Context,
        topic: &str,
        (measured, arrived): (Duration, Duration),
        stale: Option<Duration>,
    ) -> bool {
        if self.is_timeless() {
            return false;
        }
        let age = arrived.saturating_sub(measured);
        let Some(stale) = stale.filter(|stale| age > *stale) else {
            return true;
        };
        let prefix = format!("{topic}: its messages are older than `stale`, ");
        if !self.warnings.iter().any(|warning| warning.starts_with(&prefix)) {
            let (stale, age) = (stale.as_secs_f64(), age.as_secs_f64());
            let message = format!(
                "{prefix}{stale} s, when they arrive, one by {age:.1} s, and are not taken: synchronise the clocks of both machines, \
                 or find what delays them"
            );
            self.warn_once(cx, message);
        }
        false
    }

    /// Exports a message of that name, with this time or that of its stamp or arrival.
    ///
    /// # Errors
    /// If the message is of another type or does not fit. Nothing is exported then.
    pub(crate) fn export<S>(
        &mut self,
        cx: &Context,
        (name, codec, message): (&str, &DescribedCodec, &[u8]),
        time: Option<Duration>,
        export: &mut ListedExport<S>,
    ) -> Result<(), String> {
        let measured = match codec.stamp(&[message]) {
            Some(stamp) => self.measured(cx, name, stamp, cx.now()),
            None => cx.now(),
        };
        let written = export.write_with(cx, time.or(Some(measured)), |value| {
            codec.decode_into(&[message], (measured, &self.clock), value)
        });
        written.map_err(|error| error.to_string())
    }

    /// Reports the node's connection. `missing` names the missing counterpart of a connected node.
    pub(crate) fn export_connection(
        &mut self,
        cx: &Context,
        export: &mut Export<Connection>,
        missing: Option<&str>,
    ) {
        let missing = if self.clock.is_known() {
            missing
        } else {
            Some(clock_source::TOPIC)
        };
        let (node_state, attempts) = self.node.state();
        let state = match (&node_state, missing) {
            (NodeState::Connecting, _) => ConnectionState::Connecting,
            (NodeState::Alone, _) => ConnectionState::Unmet("no router and no other node is connected yet"),
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
            is_used: false,
        }
    }

    /// Its number.
    pub(crate) fn number(&self) -> usize {
        self.number
    }

    /// The name of its topic.
    pub(crate) fn topic(&self) -> &str {
        &self.topic
    }

    /// Records a valid message.
    pub(crate) fn mark_received(&mut self, arrived: Duration) {
        (self.last_received, self.is_used) = (Some(arrived), true);
    }

    /// The name of its topic, if it never had a valid message.
    pub(crate) fn unused(&self) -> Option<&str> {
        (!self.is_used).then_some(self.topic.as_str())
    }

    /// Whether its newest message is not stale.
    pub(crate) fn has_received(&self) -> bool {
        self.last_received.is_some()
    }

    /// Returns whether its newest message has just ended, or become older than `timeout`.
    pub(crate) fn falls_silent(
        &mut self,
        cx: &Context,
        connection: &RosConnection,
        timeout: Duration,
    ) -> bool {
        let silent = self
            .last_received
            .is_some_and(|received| cx.now() > received + timeout || connection.has_ended(self.number));
        if silent {
            self.last_received = None;
        }
        silent
    }
}
