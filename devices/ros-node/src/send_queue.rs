//! What the owner of a node and Zenoh's threads submit to the thread of the node. It sends nothing and does not lock.

use std::time::{Duration, Instant};

use crate::keys::{Direction, Topic};
use crate::outbox::Outbox;
use crate::services::Request;

/// The work that waits for the thread.
#[derive(Debug)]
pub(crate) struct SendQueue {
    /// The messages to send next, per publication.
    pub(crate) outboxes: Vec<Outbox>,
    /// Requests to send: client, number and message.
    pub(crate) calls: Vec<(usize, i64, Vec<u8>)>,
    /// Responses to send, or the reasons why there are none.
    pub(crate) replies: Vec<(Request, Result<Vec<u8>, String>)>,
    /// Publications to query for their newest messages: subscription, and key.
    pub(crate) caches: Vec<(usize, String)>,
    /// What other nodes have, or no longer have.
    pub(crate) met: Vec<Meeting>,
    /// Whether the owner has begun or ceased to want a subscription.
    pub(crate) is_rewired: bool,
    /// Whether the owner waits until messages are taken.
    pub(crate) is_awaited: bool,
    pub(crate) ending: bool,
    pub(crate) ended: bool,
}

/// Another node, or a bridge, begins or ends to have a topic in the opposite direction.
#[derive(Debug)]
pub(crate) struct Meeting {
    /// The direction of the own topic, and its number there.
    pub(crate) place: (Direction, usize),
    /// The token of the other one.
    pub(crate) token: String,
    /// Whether it begins.
    pub(crate) appears: bool,
}

/// The next work of the thread.
#[derive(Debug, Default)]
pub(crate) struct Work {
    /// Requests to send: client, number and message.
    pub(crate) calls: Vec<(usize, i64, Vec<u8>)>,
    /// Responses to send, or the reasons why there are none.
    pub(crate) replies: Vec<(Request, Result<Vec<u8>, String>)>,
    /// Publications to query for their newest messages: subscription, and key.
    pub(crate) caches: Vec<(usize, String)>,
    /// What other nodes have, or no longer have.
    pub(crate) met: Vec<Meeting>,
    /// Whether the owner has begun or ceased to want a subscription.
    pub(crate) is_rewired: bool,
    /// Whether the node must end afterwards.
    pub(crate) ending: bool,
}

impl SendQueue {
    pub(crate) fn new(publications: &[Topic]) -> Self {
        Self {
            outboxes: publications.iter().map(Outbox::new).collect(),
            calls: Vec::new(),
            replies: Vec::new(),
            caches: Vec::new(),
            met: Vec::new(),
            is_rewired: false,
            is_awaited: false,
            ending: false,
            ended: false,
        }
    }

    /// How long there is nothing to do, at most `longest`.
    pub(crate) fn pause(&self, longest: Duration) -> Duration {
        let has_requests = !self.met.is_empty()
            || !self.calls.is_empty()
            || !self.replies.is_empty()
            || !self.caches.is_empty()
            || self.is_rewired;
        if self.ending || has_requests {
            return Duration::ZERO;
        }
        let now = Instant::now();
        let pauses = self.outboxes.iter().filter_map(|outbox| outbox.pause(now));
        pauses.fold(longest, Duration::min)
    }
}
