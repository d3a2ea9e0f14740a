//! Queues from Zenoh's threads to those of the link. Zenoh's threads never serve a request and never wait: a
//! request without room is dropped, which its sender notices at once.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher as _, RandomState};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::Instant;

use crossbeam_queue::ArrayQueue;
use serde::Deserialize;
use zenoh::query::Query;

use super::bucket::Bucket;
use super::hands::Done;
use super::lines::{LINES, Lines};
use crate::keys::{self, Keys, OPERATE, Rate, Wanted};

/// Most outcomes that wait to be answered.
const DONE: usize = 256;
/// Queries per second and line: more than tools send, and few enough that many endless senders leave time for
/// others.
const LOOKS: f64 = 200.0;
/// Most tokens accepted per origin: more values and panels than clients watch at once.
const TOKENS: usize = 4096;
/// Longest accepted token, bytes: the longest names, and room for a client's.
const LONGEST_TOKEN: usize = 1024;

/// Longest message that is examined for a gesture, bytes: its names, each character of which may take six
/// bytes, and its numbers.
const LONGEST_TOUCH: usize = 8 << 10;

/// The session through which a message arrived. Each session has its own subscribers, so an origin cannot be
/// forged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Origin {
    /// The private socket of this user on this machine.
    Local,
    /// The sessions that `[link]` opened on the network.
    Network,
}

/// A request.
pub(super) struct Ask {
    pub(super) origin: Origin,
    /// The line of its client.
    pub(super) line: usize,
    pub(super) query: Query,
}

/// The precedence of requests from any origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rank {
    /// Stop everything. Served by a thread that does nothing else.
    Stop,
    /// Other requests of operators.
    Order,
    /// Gestures on panels. Separate, since their number must not displace orders.
    Touch,
    /// Queries.
    Look,
}

/// The number of ranks.
const RANKS: usize = 4;

/// A request of clients for one variable or panel at one rate.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Want {
    pub(super) what: Wanted,
    pub(super) rate: Rate,
    pub(super) origin: Origin,
}

/// All that clients want.
#[derive(Default)]
struct Wants {
    wants: BTreeMap<Want, Wanting>,
    /// The number of tokens by origin.
    tokens: [usize; 2],
    /// Counts all tokens ever accepted. It never restarts, so that a client that arrives when the last one
    /// leaves is recognised as another.
    arrivals: u64,
    /// Whether the excess of tokens was logged. It is logged once, so that a flood does not fill the log.
    told: bool,
}

/// The clients that want the same.
#[derive(Default)]
struct Wanting {
    tokens: BTreeSet<String>,
    /// The number of the last arrival.
    joined: u64,
}

/// The queues of the link.
pub(super) struct Inbox {
    /// Requests by [`Rank`] and then by client: a busy client displaces no other kind of request, and takes
    /// turns with other clients of the same kind.
    asks: [Lines<Ask>; RANKS],
    /// The remaining queries of each line.
    looks: [Mutex<Bucket>; LINES],
    /// Hashes clients' names to lines, differently in each run, so that no client can choose another's line.
    mix: RandomState,
    pub(super) done: ArrayQueue<Done>,
    /// Outcomes of orders to stop everything. Any client may send these at any rate, which must not displace
    /// other answers.
    pub(super) stopped: ArrayQueue<Done>,
    wants: Mutex<Wants>,
    wants_changed: AtomicBool,
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
            asks: std::array::from_fn(|_| Lines::new()),
            looks: std::array::from_fn(|_| Mutex::new(Bucket::new(LOOKS, Instant::now()))),
            mix: RandomState::new(),
            done: ArrayQueue::new(DONE),
            stopped: ArrayQueue::new(DONE),
            wants: Mutex::default(),
            wants_changed: AtomicBool::new(false),
            fresh: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            worker: OnceLock::new(),
            values: OnceLock::new(),
            stopper: OnceLock::new(),
        }
    }

    /// Sets the threads to wake: for answers, values and stops. Called once.
    pub(super) fn attach(&self, worker: &Thread, values: &Thread, stopper: &Thread) {
        // Set here only.
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

    pub(super) fn ask(&self, origin: Origin, query: Query) {
        let rank = if is_order(query.key_expr().as_str()) {
            let message = query.payload().map(|payload| payload.to_bytes());
            rank(message.as_deref().unwrap_or_default())
        } else {
            Rank::Look
        };
        let client = query.attachment().map(|client| client.to_bytes());
        let client = client.filter(|client| !client.is_empty());
        // Clients without a name share the first line of their origin.
        let line = client.map_or(0, |client| {
            let mixed = self.mix.hash_one(&*client) as usize;
            1 + mixed % (LINES / 2 - 1)
        }) + origin as usize * (LINES / 2);
        if rank == Rank::Look {
            let mut looks = self.looks[line].lock().unwrap_or_else(PoisonError::into_inner);
            if !looks.take(Instant::now()) {
                return;
            }
        }
        // A dropped request ends without an answer, so its sender knows at once.
        if self.asks[rank as usize].push(line, Ask { origin, line, query }) {
            match rank {
                Rank::Stop => self.wake_stopper(),
                Rank::Order | Rank::Touch | Rank::Look => self.wake(),
            }
        }
    }

    /// Takes the next order to stop everything. Only one thread may call this.
    pub(super) fn next_stop(&self) -> Option<Ask> {
        self.asks[Rank::Stop as usize].pop()
    }

    /// Takes the next request other than a stop. With `look`, a query takes precedence. Only one thread may
    /// call this.
    pub(super) fn next_ask(&self, look: bool) -> Option<Ask> {
        let [_, order, touch, asked] = &self.asks;
        let first = look.then(|| asked.pop()).flatten();
        first.or_else(|| [order, touch, asked].into_iter().find_map(Lines::pop))
    }

    pub(super) fn is_idle(&self) -> bool {
        let [_, mine @ ..] = &self.asks;
        mine.iter().all(Lines::is_empty) && self.done.is_empty() && self.stopped.is_empty()
    }

    /// Notifies the value thread that a variable has a new value or a panel was drawn. Called by the writing
    /// thread.
    pub(super) fn freshen(&self) {
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

    pub(super) fn stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Adds or removes a token.
    pub(super) fn want(&self, origin: Origin, keys: &Keys, token: &str, there: bool) {
        let Some((what, rate)) = keys.below(token).and_then(keys::wanted) else {
            return;
        };
        let want = Want { what, rate, origin };
        let mut wants = self.wants.lock().unwrap_or_else(PoisonError::into_inner);
        if there {
            wants.come(want, token);
        } else {
            wants.go(&want, token);
        }
        drop(wants);
        self.wants_changed.store(true, Ordering::Release);
        self.wake_values();
    }

    /// All wants, each with the number of its last arrival; none if nothing changed since the last call.
    pub(super) fn wants(&self) -> Option<BTreeMap<Want, u64>> {
        if !self.wants_changed.swap(false, Ordering::AcqRel) {
            return None;
        }
        let wants = self.wants.lock().unwrap_or_else(PoisonError::into_inner);
        let joined = wants
            .wants
            .iter()
            .map(|(want, wanting)| (want.clone(), wanting.joined));
        Some(joined.collect())
    }
}

/// Whether a key is one for orders: the exact key of an application, or an expression for many.
pub(super) fn is_order(key: &str) -> bool {
    key.strip_suffix(OPERATE)
        .is_some_and(|before| before.ends_with('/'))
}

/// The rank of an order, by a shallow look at its message. The thread that serves it parses it fully.
fn rank(message: &[u8]) -> Rank {
    #[derive(Deserialize)]
    struct Head<'m> {
        #[serde(borrow)]
        action: Cow<'m, str>,
    }
    let short = message.len() <= LONGEST_TOUCH;
    let head = short.then(|| serde_json::from_slice::<Head<'_>>(message).ok());
    match head.flatten() {
        Some(head) if head.action == "stop-all" => Rank::Stop,
        Some(head) if head.action == "touch" => Rank::Touch,
        Some(_) | None => Rank::Order,
    }
}

impl Wants {
    fn come(&mut self, want: Want, token: &str) {
        let count = &mut self.tokens[want.origin as usize];
        if *count >= TOKENS || token.len() > LONGEST_TOKEN {
            if !std::mem::replace(&mut self.told, true) {
                tracing::warn!(
                    "clients want more than {TOKENS} values and panels at once, or by names of more than {LONGEST_TOKEN} bytes; the rest get none"
                );
            }
            return;
        }
        let wanting = self.wants.entry(want).or_default();
        if wanting.tokens.insert(token.to_owned()) {
            *count += 1;
            self.arrivals += 1;
            wanting.joined = self.arrivals;
        }
    }

    fn go(&mut self, want: &Want, token: &str) {
        let Some(wanting) = self.wants.get_mut(want) else {
            return;
        };
        if wanting.tokens.remove(token) {
            self.tokens[want.origin as usize] -= 1;
        }
        if wanting.tokens.is_empty() {
            self.wants.remove(want);
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
        keys().want("pioneer", variable, Rate::Full, client)
    }

    #[test]
    fn stops_and_gestures_have_ranks_of_their_own_and_the_rest_is_an_order() {
        assert_eq!(rank(br#"{"by": "ana", "action": "stop-all"}"#), Rank::Stop);
        assert!(is_order("jde/1/*/*/operate"));
        assert!(!is_order("jde/1/robot/ab12/var/goon/co-operate"));
        let touch = r#"{"by": "ana", "action": "touch", "schema": "goon", "gesture": {"widget": "stop", "touch": "pressed"}}"#;
        assert_eq!(rank(touch.as_bytes()), Rank::Touch);
        let stop = r#"{"by": "touch", "action": "stop", "schema": "touch"}"#;
        assert_eq!(rank(stop.as_bytes()), Rank::Order);
        assert_eq!(rank(b"touch"), Rank::Order);
        let long = format!("{touch}{}", " ".repeat(LONGEST_TOUCH));
        assert_eq!(rank(long.as_bytes()), Rank::Order);
    }

    fn want(inbox: &Inbox, origin: Origin, token: &str, there: bool) {
        inbox.want(origin, &keys(), token, there);
    }

    #[test]
    fn whoever_comes_as_the_last_one_goes_is_another() {
        let inbox = Inbox::new();
        want(&inbox, Origin::Local, &token("laser", "a"), true);
        let before = inbox.wants().unwrap();
        want(&inbox, Origin::Local, &token("laser", "a"), false);
        want(&inbox, Origin::Local, &token("laser", "b"), true);
        let after = inbox.wants().unwrap();
        assert!(before.keys().eq(after.keys()));
        assert_ne!(before, after, "or `b` would get no value until the next");
    }

    #[test]
    fn a_flood_of_tokens_is_bounded_at_each_door_for_itself() {
        let inbox = Inbox::new();
        for number in 0..TOKENS + 10 {
            let token = token(&format!("v{number}"), "a");
            want(&inbox, Origin::Network, &token, true);
        }
        want(
            &inbox,
            Origin::Local,
            &token("laser", &"x".repeat(LONGEST_TOKEN)),
            true,
        );
        assert_eq!(inbox.wants().unwrap().len(), TOKENS);
        want(&inbox, Origin::Local, &token("laser", "a"), true);
        assert_eq!(
            inbox.wants().unwrap().len(),
            TOKENS + 1,
            "not those of this machine"
        );
        // A token beyond the limit is removed, which frees no room.
        want(
            &inbox,
            Origin::Network,
            &token(&format!("v{}", TOKENS + 5), "a"),
            false,
        );
        want(&inbox, Origin::Network, &token("more", "a"), true);
        assert_eq!(inbox.wants().unwrap().len(), TOKENS + 1);
        want(&inbox, Origin::Network, &token("v0", "a"), false);
        want(&inbox, Origin::Network, &token("more", "a"), true);
        let wants = inbox.wants().unwrap();
        let more = Wanted::Variable("pioneer/more".to_owned());
        assert!(wants.keys().any(|want| want.what == more));
    }
}
