//! What Zenoh's threads leave for those of the link. They never serve a request and never wait: what there is no room for is dropped
//! and its sender told so.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::Thread;

use crossbeam_queue::ArrayQueue;
use serde::Deserialize;
use zenoh::query::Query;

use super::hands::Done;
use crate::keys::{self, Keys, OPERATE, Rate, Wanted};

/// Requests that wait.
const ASKS: usize = 256;
/// Tokens of clients that are minded, of each origin: more values and panels than anybody watches at once.
const TOKENS: usize = 4096;
/// Longest token that is minded, bytes: the longest names there are, and room for a client's.
const LONGEST_TOKEN: usize = 1024;

/// Longest message of a gesture that is looked for, bytes: its names, each letter of which may take six, and its numbers.
const LONGEST_TOUCH: usize = 8 << 10;

/// Through which session something came. Each has its own listeners, so nobody can pretend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Origin {
    /// The private socket of this user on this machine.
    Local,
    /// Whatever `[link]` opened.
    Network,
}

/// A request.
pub(super) struct Ask {
    pub(super) origin: Origin,
    pub(super) query: Query,
}

/// Which requests of one origin go first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rank {
    /// What operators want done.
    Order,
    /// What people do to panels: so much that it may not fill the place of orders.
    Touch,
    /// What else is asked.
    Look,
}

/// How many ranks there are.
const RANKS: usize = 3;

/// What clients want of one variable or panel at one rate.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Want {
    pub(super) what: Wanted,
    pub(super) rate: Rate,
    pub(super) origin: Origin,
}

/// All that is wanted.
#[derive(Default)]
struct Wants {
    wants: BTreeMap<Want, Wanting>,
    /// Tokens there are, by origin.
    tokens: [usize; 2],
    /// Tokens that ever came. It never starts again, so that whoever comes as the last one goes is seen to be another.
    arrivals: u64,
    /// It has been told that there were too many. Once is enough: a client that floods must not fill a log.
    told: bool,
}

/// Who wants it.
#[derive(Default)]
struct Wanting {
    tokens: BTreeSet<String>,
    /// Which arrival the last one was.
    joined: u64,
}

/// What waits for the worker.
pub(super) struct Inbox {
    /// By their [`Origin`], and then by their [`Rank`]: whoever asks much fills the place of no other kind, and the network keeps
    /// nobody on this machine waiting.
    asks: [[ArrayQueue<Ask>; RANKS]; 2],
    pub(super) done: ArrayQueue<Done>,
    wants: Mutex<Wants>,
    wants_changed: AtomicBool,
    /// A variable of which every value is wanted has a new one, or a panel was drawn.
    fresh: AtomicBool,
    stop: AtomicBool,
    worker: OnceLock<Thread>,
    values: OnceLock<Thread>,
}

impl Inbox {
    pub(super) fn new() -> Self {
        Self {
            asks: std::array::from_fn(|_| std::array::from_fn(|_| ArrayQueue::new(ASKS))),
            done: ArrayQueue::new(ASKS),
            wants: Mutex::default(),
            wants_changed: AtomicBool::new(false),
            fresh: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            worker: OnceLock::new(),
            values: OnceLock::new(),
        }
    }

    /// Says who answers and who sends values; once.
    pub(super) fn attach(&self, worker: &Thread, values: &Thread) {
        // Set here only.
        let _ = self.worker.set(worker.clone());
        let _ = self.values.set(values.clone());
        self.wake();
        self.wake_values();
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

    pub(super) fn ask(&self, origin: Origin, query: Query) {
        let rank = if query.key_expr().as_str().ends_with(OPERATE) {
            let message = query.payload().map(|payload| payload.to_bytes());
            rank(message.as_deref().unwrap_or_default())
        } else {
            Rank::Look
        };
        let queue = &self.asks[origin as usize][rank as usize];
        // A full queue drops the request, which ends it without an answer: its sender knows at once.
        if queue.push(Ask { origin, query }).is_ok() {
            self.wake();
        }
    }

    /// The request that is next.
    pub(super) fn next_ask(&self) -> Option<Ask> {
        self.asks.iter().flatten().find_map(ArrayQueue::pop)
    }

    pub(super) fn is_idle(&self) -> bool {
        self.asks.iter().flatten().all(ArrayQueue::is_empty) && self.done.is_empty()
    }

    /// A variable has a new value, or a panel was drawn. Called by whoever did it.
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
    }

    pub(super) fn stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// A token appeared or went.
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

    /// What is wanted and which arrival the last was who came for it, if that changed.
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

/// The rank of what an operator wants. It is looked into, not believed: whoever reads it decides what it is.
fn rank(message: &[u8]) -> Rank {
    #[derive(Deserialize)]
    struct Head<'m> {
        #[serde(borrow)]
        action: Cow<'m, str>,
    }
    let short = message.len() <= LONGEST_TOUCH;
    let head = short.then(|| serde_json::from_slice::<Head<'_>>(message).ok());
    match head.flatten() {
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
    fn gestures_have_a_rank_of_their_own_and_the_rest_is_an_order() {
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
        // One that was never minded goes, and takes nobody's place.
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
