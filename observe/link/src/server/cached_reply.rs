//! A reply that takes work: it is fetched on demand, at a bounded rate, and never older than the last
//! operation whose outcome a client knows.

use std::time::{Duration, Instant};

use zenoh::query::Query;

use super::fair_queue::QUEUES;
use super::worker::{JsonMessage, reply};

/// Least time between two fetches.
const MIN_INTERVAL: Duration = Duration::from_millis(50);
/// Most queries of one queue that wait for the same reply.
const MAX_PENDING: usize = 256 / QUEUES;

#[derive(Default)]
pub(super) struct CachedReply {
    /// The newest reply and when it arrived.
    newest: Option<(Instant, JsonMessage)>,
    is_fetching: bool,
    /// Whether an operation ended after the newest fetch began.
    is_outdated: bool,
    pending: Vec<Pending>,
}

struct Pending {
    queue: usize,
    query: Query,
    /// Whether the reply being fetched is too old for it.
    waits_for_next: bool,
}

impl CachedReply {
    /// Replies with the newest result if it is recent, and keeps the query until one arrives otherwise.
    pub(super) fn query(&mut self, query: Query, key: &str, queue: usize) {
        let waiting = self.pending.iter().filter(|pending| pending.queue == queue);
        match &self.newest {
            Some((at, message)) if !self.is_outdated && at.elapsed() < MIN_INTERVAL => {
                reply(&query, key, message.clone());
            }
            // Beyond the limit the query ends without a reply.
            _ if waiting.count() < MAX_PENDING => self.pending.push(Pending {
                queue,
                query,
                waits_for_next: self.is_fetching && self.is_outdated,
            }),
            _ => {}
        }
    }

    pub(super) fn is_awaited(&self) -> bool {
        !self.pending.is_empty()
    }

    /// Begins a fetch with `send` unless one is under way or it is too early. Returns when to try again.
    pub(super) fn fetch(&mut self, send: impl FnOnce() -> bool) -> Option<Instant> {
        if self.is_fetching {
            return None;
        }
        let now = Instant::now();
        match &self.newest {
            Some((at, _)) if now < *at + MIN_INTERVAL => Some(*at + MIN_INTERVAL),
            _ => {
                self.is_fetching = send();
                self.is_outdated &= !self.is_fetching;
                (!self.is_fetching).then(|| now + MIN_INTERVAL)
            }
        }
    }

    /// Marks what was fetched before an operation ended. Call it before the operation's outcome is sent.
    pub(super) fn outdate(&mut self) {
        self.is_outdated = true;
    }

    /// Replies to the queries for which a fetched result is new enough.
    pub(super) fn complete(&mut self, key: &str, message: JsonMessage) {
        self.is_fetching = false;
        self.pending.retain_mut(|pending| {
            if !pending.waits_for_next {
                reply(&pending.query, key, message.clone());
            }
            std::mem::take(&mut pending.waits_for_next)
        });
        self.newest = Some((Instant::now(), message));
    }
}
