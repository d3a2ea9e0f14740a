//! Shared by the drivers of this plugin: a node, the clocks of both sides, and reports of the connection. It
//! knows no topics.

use core::time::Duration;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_device::{Report, Standing};
use jde_schema::prelude::*;

use crate::clock::{Clock, Measured};
use crate::messages::Codec;
use crate::node::{Link, Node, Plan};

/// Most complaints until the driver wakes again.
const MOST_COMPLAINTS: usize = 32;

/// A node and its state.
pub(crate) struct Wire {
    pub(crate) node: Node,
    pub(crate) clock: Clock,
    report: Report,
    complaints: Vec<String>,
    /// Its name, domain and address, for messages.
    who: String,
}

/// A subscription.
pub(crate) struct Inlet<T> {
    number: usize,
    topic: String,
    codec: Codec<T>,
    /// Arrival of the newest readable message, until it is stale.
    heard: Option<Duration>,
}

impl Wire {
    pub(crate) fn start(plan: Plan) -> Result<Self> {
        let who = format!(
            "node {}, domain {}, {}",
            plan.name.full(),
            plan.name.domain,
            plan.place
        );
        Ok(Self {
            node: Node::start(plan)?,
            clock: Clock::default(),
            report: Report::default(),
            complaints: Vec::new(),
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
    pub(crate) fn complain(&mut self, cx: &Context, words: String) {
        if self.complaints.len() >= MOST_COMPLAINTS || self.complaints.contains(&words) {
            return;
        }
        warn!(cx, "{words}");
        self.complaints.push(words);
        if self.complaints.len() == MOST_COMPLAINTS {
            warn!(cx, "so much is wrong that no more of it is said");
        }
    }

    /// Takes the newest message of a subscription into `value`. Returns the time of its arrival.
    pub(crate) fn receive<T: Value>(
        &mut self,
        cx: &Context,
        inlet: &mut Inlet<T>,
        value: &mut T,
    ) -> Option<Duration> {
        let arrived = self.node.take(inlet.number)?;
        match inlet.codec.decode_into(&arrived.message.to_bytes(), value) {
            Ok(()) => Some(cx.now().saturating_sub(arrived.at.elapsed())),
            Err(error) => {
                self.complain(cx, format!("{}: {error}", inlet.topic));
                None
            }
        }
    }

    /// Returns when a value with this arrival was measured, and sets its stamp to that time.
    pub(crate) fn stamp<T: Value>(
        &mut self,
        cx: &Context,
        inlet: &Inlet<T>,
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
                if !self.complaints.iter().any(|told| told.starts_with(&known)) {
                    self.complain(cx, words);
                }
                time
            }
        };
        header.stamp = time.into();
        time
    }

    /// Reports the node's connection. `looking` names the missing counterpart of a connected node.
    pub(crate) fn tell(&mut self, cx: &Context, export: &mut Export<Connection>, looking: Option<&str>) {
        let (link, attempts) = self.node.link();
        let standing = match (&link, looking) {
            (Link::Connecting, _) => Standing::Connecting,
            (Link::Alone, _) => Standing::Looking("other nodes"),
            (Link::Connected, Some(looking)) => Standing::Looking(looking),
            (Link::Connected, None) => Standing::Connected(&self.who),
            (Link::Lost(why), _) => Standing::Lost(why),
        };
        self.report.tell(cx, export, standing, attempts);
    }

    /// Sends the submitted messages and ends the node.
    pub(crate) fn rest(mut self, cx: &Context, export: &mut Export<Connection>) {
        self.node.rest();
        self.report.retract(cx, export);
    }
}

impl<T: Value> Inlet<T> {
    /// The subscription of that number.
    pub(crate) fn new(number: usize, topic: String, codec: Codec<T>) -> Self {
        Self {
            number,
            topic,
            codec,
            heard: None,
        }
    }

    /// The name of its topic.
    pub(crate) fn topic(&self) -> &str {
        &self.topic
    }

    /// Records a valid message.
    pub(crate) fn hear(&mut self, arrived: Duration) {
        self.heard = Some(arrived);
    }

    /// Whether its newest message still counts.
    pub(crate) fn is_heard(&self) -> bool {
        self.heard.is_some()
    }

    /// Returns whether its newest message has just become older than `patience`.
    pub(crate) fn falls_silent(&mut self, now: Duration, patience: Duration) -> bool {
        let silent = self.heard.is_some_and(|heard| now > heard + patience);
        if silent {
            self.heard = None;
        }
        silent
    }
}
