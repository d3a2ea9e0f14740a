//! Queues from Zenoh's threads to those of the link. Zenoh's threads never serve a request and never wait: if
//! a queue is full, the request is dropped, which its sender notices at once.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, RandomState};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::Instant;

use crossbeam_queue::ArrayQueue;
use parking_lot::Mutex;
use serde::Deserialize;
use zenoh::query::Query;

use super::bucket::TokenBucket;
use super::fair_queue::{FairQueue, QUEUES};
use super::operator_workers::JobOutcome;
use crate::keys::{self, Keys, OPERATE, Rate, TokenTarget};

/// Most outcomes that wait to be sent as replies.
const MAX_OUTCOMES: usize = 256;
/// Queries per second and queue: more than tools send, and few enough that many endless senders leave time
/// for others.
const QUERIES_PER_SECOND: f64 = 200.0;
/// Most tokens accepted per origin: more values and panels than clients watch at once.
const MAX_TOKENS: usize = 4096;
/// Longest accepted token, bytes: the longest names, and room for a client's.
const MAX_TOKEN_BYTES: usize = 1024;

/// Longest message that is examined for a gesture, bytes: its names, each character of which may take six
/// bytes, and its numbers.
const MAX_GESTURE_MESSAGE: usize = 8 << 10;

/// The session through which a message arrived. Each session has its own subscribers, so an origin cannot be
/// forged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Origin {
    /// The private socket of this user on this machine.
    Local,
    /// The sessions that `[link]` opened on the network.
    Network,
}

/// A query with its origin and queue.
pub(super) struct QueuedQuery {
    pub(super) origin: Origin,
    /// The queue of its client.
    pub(super) queue: usize,
    pub(super) query: Query,
}

/// The precedence of requests from any origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rank {
    /// Stop everything. Served by a thread that does nothing else.
    Stop,
    /// Other requests of operators.
    Operate,
    /// Gestures on panels. Separate, since their number must not displace requests of operators.
    Gesture,
    /// Queries.
    Query,
}

/// The number of ranks.
const RANK_COUNT: usize = 4;

/// A request of clients for one variable or panel at one rate.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Demand {
    pub(super) target: TokenTarget,
    pub(super) rate: Rate,
    pub(super) origin: Origin,
}

/// The demands of all clients.
#[derive(Default)]
struct Demands {
    demands: BTreeMap<Demand, DemandClients>,
    /// The number of tokens by origin.
    tokens: [usize; 2],
    /// Counts all tokens ever accepted. It never restarts, so that a client that arrives when the last one
    /// leaves is recognised as a new one.
    arrivals: u64,
    /// Whether the excess of tokens was logged. It is logged once, so that a flood does not fill the log.
    is_excess_logged: bool,
}

/// The clients with the same demand.
#[derive(Default)]
struct DemandClients {
    tokens: BTreeSet<String>,
    /// The number of the last arrival.
    last_arrival: u64,
}

/// The queues of the link.
pub(super) struct Inbox {
    /// Requests by [`Rank`] and then by client: a busy client displaces no other kind of request, and takes
    /// turns with other clients of the same kind.
    queries: [FairQueue<QueuedQuery>; RANK_COUNT],
    /// The rate limit of each queue.
    limiters: [Mutex<TokenBucket>; QUEUES],
    /// Hashes clients' names to queues, differently in each run, so that no client can choose another's
    /// queue.
    hasher: RandomState,
    pub(super) outcomes: ArrayQueue<JobOutcome>,
    /// Outcomes of requests to stop everything. Any client may send these at any rate, which must not
    /// displace other replies.
    pub(super) stop_outcomes: ArrayQueue<JobOutcome>,
    demands: Mutex<Demands>,
    demands_changed: AtomicBool,
    /// A variable that a client watches at full rate has a new value, or a panel was drawn.
    fresh: AtomicBool,
    stop: AtomicBool,
    worker: OnceLock<Thread>,
    values: OnceLock<Thread>,
    stopper: OnceLock<Thread>,
}

impl Inbox {
    pub(super) fn new() -> Self {
        Self {
            queries: std::array::from_fn(|_| FairQueue::new()),
            limiters: std::array::from_fn(|_| {
                Mutex::new(TokenBucket::new(QUERIES_PER_SECOND, Instant::now()))
            }),
            hasher: RandomState::new(),
            outcomes: ArrayQueue::new(MAX_OUTCOMES),
            stop_outcomes: ArrayQueue::new(MAX_OUTCOMES),
            demands: Mutex::default(),
            demands_changed: AtomicBool::new(false),
            fresh: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            worker: OnceLock::new(),
            values: OnceLock::new(),
            stopper: OnceLock::new(),
        }
    }

    /// Sets the threads to wake for queries, values and stops. Called once.
    pub(super) fn attach(&self, worker: &Thread, values: &Thread, stopper: &Thread) {
        // Set only by this method.
        let _ = self.worker.set(worker.clone());
        let _ = self.values.set(values.clone());
        let _ = self.stopper.set(stopper.clone());
        self.wake();
        self.wake_values();
        self.wake_stopper();
    }

    pub(super) fn wake(&self) {
        if let Some(worker) = self.worker.get() {
            worker.unpark();
        }
    }

    fn wake_values(&self) {
        if let Some(values) = self.values.get() {
            values.unpark();
        }
    }

    fn wake_stopper(&self) {
        if let Some(stopper) = self.stopper.get() {
            stopper.unpark();
        }
    }

    pub(super) fn push_query(&self, origin: Origin, query: Query) {
        let rank = if is_operate_key(query.key_expr().as_str()) {
            let message = query.payload().map(|payload| payload.to_bytes());
            rank(message.as_deref().unwrap_or_default())
        } else {
            Rank::Query
        };
        let client = query.attachment().map(|client| client.to_bytes());
        let client = client.filter(|client| !client.is_empty());
        // Clients without a name share the first queue of their origin.
        let queue = client.map_or(0, |client| {
            let hash = self.hasher.hash_one(&*client) as usize;
            1 + hash % (QUEUES / 2 - 1)
        }) + origin as usize * (QUEUES / 2);
        if rank == Rank::Query {
            let mut limiter = self.limiters[queue].lock();
            if !limiter.try_take(Instant::now()) {
                return;
            }
        }
        // A dropped request ends without a reply, so its sender notices at once.
        if self.queries[rank as usize].push(queue, QueuedQuery { origin, queue, query }) {
            match rank {
                Rank::Stop => self.wake_stopper(),
                Rank::Operate | Rank::Gesture | Rank::Query => self.wake(),
            }
        }
    }

    /// Takes the next request to stop everything. Only one thread may call this.
    pub(super) fn next_stop(&self) -> Option<QueuedQuery> {
        self.queries[Rank::Stop as usize].pop()
    }

    /// Takes the next request other than a stop. With `prefer_query`, a query takes precedence. Only one
    /// thread may call this.
    pub(super) fn next_query(&self, prefer_query: bool) -> Option<QueuedQuery> {
        let [_, requests, gestures, queries] = &self.queries;
        let first = prefer_query.then(|| queries.pop()).flatten();
        first.or_else(|| [requests, gestures, queries].into_iter().find_map(FairQueue::pop))
    }

    pub(super) fn is_idle(&self) -> bool {
        let [_, queues @ ..] = &self.queries;
        queues.iter().all(FairQueue::is_empty) && self.outcomes.is_empty() && self.stop_outcomes.is_empty()
    }

    /// Notifies the value thread that a variable has a new value or a panel was drawn. Called by the writing
    /// thread.
    pub(super) fn mark_fresh(&self) {
        if !self.fresh.swap(true, Ordering::AcqRel) {
            self.wake_values();
        }
    }

    pub(super) fn take_fresh(&self) -> bool {
        self.fresh.swap(false, Ordering::AcqRel)
    }

    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Release);
        self.wake();
        self.wake_values();
        self.wake_stopper();
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Adds or removes a token.
    pub(super) fn update_demand(&self, origin: Origin, keys: &Keys, token: &str, is_present: bool) {
        let Some((target, rate)) = keys.strip_root(token).and_then(keys::parse_token) else {
            return;
        };
        let demand = Demand { target, rate, origin };
        let mut demands = self.demands.lock();
        if is_present {
            demands.add(demand, token);
        } else {
            demands.remove(&demand, token);
        }
        drop(demands);
        self.demands_changed.store(true, Ordering::Release);
        self.wake_values();
    }

    /// All demands, each with the number of its last arrival; `None` if nothing changed since the last call.
    pub(super) fn take_demands(&self) -> Option<BTreeMap<Demand, u64>> {
        if !self.demands_changed.swap(false, Ordering::AcqRel) {
            return None;
        }
        let demands = self.demands.lock();
        let arrivals = demands
            .demands
            .iter()
            .map(|(demand, clients)| (demand.clone(), clients.last_arrival));
        Some(arrivals.collect())
    }
}

/// Whether a key is one for operators' requests: the exact key of an application, or an expression for many.
pub(super) fn is_operate_key(key: &str) -> bool {
    key.strip_suffix(OPERATE)
        .is_some_and(|before| before.ends_with('/'))
}

/// The rank of a request, by shallow parsing of its message. The thread that serves it parses it fully.
fn rank(message: &[u8]) -> Rank {
    #[derive(Deserialize)]
    struct Head<'m> {
        #[serde(borrow)]
        action: Cow<'m, str>,
    }
    let short = message.len() <= MAX_GESTURE_MESSAGE;
    let head = short.then(|| serde_json::from_slice::<Head<'_>>(message).ok());
    match head.flatten() {
        Some(head) if head.action == "stop-all" => Rank::Stop,
        Some(head) if head.action == "touch" => Rank::Gesture,
        Some(_) | None => Rank::Operate,
    }
}

impl Demands {
    fn add(&mut self, demand: Demand, token: &str) {
        let count = &mut self.tokens[demand.origin as usize];
        if *count >= MAX_TOKENS || token.len() > MAX_TOKEN_BYTES {
            if !std::mem::replace(&mut self.is_excess_logged, true) {
                tracing::warn!(
                    "clients subscribe to more than {MAX_TOKENS} values and panels at once, or by names of more than {MAX_TOKEN_BYTES} bytes; the excess is ignored"
                );
            }
            return;
        }
        let clients = self.demands.entry(demand).or_default();
        if clients.tokens.insert(token.to_owned()) {
            *count += 1;
            self.arrivals += 1;
            clients.last_arrival = self.arrivals;
        }
    }

    fn remove(&mut self, demand: &Demand, token: &str) {
        let Some(clients) = self.demands.get_mut(demand) else {
            return;
        };
        if clients.tokens.remove(token) {
            self.tokens[demand.origin as usize] -= 1;
        }
        if clients.tokens.is_empty() {
            self.demands.remove(demand);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Keys {
        Keys::new("robot", "ab12")
    }

    fn token(variable: &str, client: &str) -> String {
        keys().value_token("pioneer", variable, Rate::Full, client)
    }

    #[test]
    fn stops_and_gestures_have_ranks_of_their_own_and_other_requests_share_one() {
        assert_eq!(rank(br#"{"by": "ana", "action": "stop-all"}"#), Rank::Stop);
        assert!(is_operate_key("jde/1/*/*/operate"));
        assert!(!is_operate_key("jde/1/robot/ab12/var/goon/co-operate"));
        let touch = r#"{"by": "ana", "action": "touch", "schema": "goon", "gesture": {"widget": "stop", "touch": "pressed"}}"#;
        assert_eq!(rank(touch.as_bytes()), Rank::Gesture);
        let stop = r#"{"by": "touch", "action": "stop", "schema": "touch"}"#;
        assert_eq!(rank(stop.as_bytes()), Rank::Operate);
        assert_eq!(rank(b"touch"), Rank::Operate);
        let long = format!("{touch}{}", " ".repeat(MAX_GESTURE_MESSAGE));
        assert_eq!(rank(long.as_bytes()), Rank::Operate);
    }

    fn update(inbox: &Inbox, origin: Origin, token: &str, is_present: bool) {
        inbox.update_demand(origin, &keys(), token, is_present);
    }

    #[test]
    fn a_client_that_replaces_the_last_one_counts_as_a_new_arrival() {
        let inbox = Inbox::new();
        update(&inbox, Origin::Local, &token("laser", "a"), true);
        let before = inbox.take_demands().unwrap();
        update(&inbox, Origin::Local, &token("laser", "a"), false);
        update(&inbox, Origin::Local, &token("laser", "b"), true);
        let after = inbox.take_demands().unwrap();
        assert!(before.keys().eq(after.keys()));
        assert_ne!(before, after, "`b` receives the newest value at once");
    }

    #[test]
    fn tokens_are_limited_separately_for_each_origin() {
        let inbox = Inbox::new();
        for number in 0..MAX_TOKENS + 10 {
            let token = token(&format!("v{number}"), "a");
            update(&inbox, Origin::Network, &token, true);
        }
        update(
            &inbox,
            Origin::Local,
            &token("laser", &"x".repeat(MAX_TOKEN_BYTES)),
            true,
        );
        assert_eq!(inbox.take_demands().unwrap().len(), MAX_TOKENS);
        update(&inbox, Origin::Local, &token("laser", "a"), true);
        assert_eq!(
            inbox.take_demands().unwrap().len(),
            MAX_TOKENS + 1,
            "tokens of this machine have a limit of their own"
        );
        // Removing a token that exceeded the limit frees no room.
        update(
            &inbox,
            Origin::Network,
            &token(&format!("v{}", MAX_TOKENS + 5), "a"),
            false,
        );
        update(&inbox, Origin::Network, &token("more", "a"), true);
        assert_eq!(inbox.take_demands().unwrap().len(), MAX_TOKENS + 1);
        update(&inbox, Origin::Network, &token("v0", "a"), false);
        update(&inbox, Origin::Network, &token("more", "a"), true);
        let demands = inbox.take_demands().unwrap();
        let more = TokenTarget::Variable("pioneer/more".to_owned());
        assert!(demands.keys().any(|demand| demand.target == more));
    }
}
