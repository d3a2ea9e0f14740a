//! What Zenoh's threads leave for those of the link. They never serve a request and never wait: what there is no room for is dropped
//! and its sender told so.

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

/// What has been done and waits to be answered.
const DONE: usize = 256;
/// Questions of one line in a second: more than tools ask, and so few that even many who ask without end leave time for others.
const LOOKS: f64 = 200.0;
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
    /// Its client's line.
    pub(super) line: usize,
    pub(super) query: Query,
}

/// Which requests go first, wherever they come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rank {
    /// That everything be stopped. Whoever carries it out does nothing else.
    Stop,
    /// What operators want done.
    Order,
    /// What people do to panels: so much that it may not fill the place of orders.
    Touch,
    /// What else is asked.
    Look,
}

/// How many ranks there are.
const RANKS: usize = 4;

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
    /// By their [`Rank`], and then by their clients: whoever asks much fills the place of no other kind, and takes turns with others
    /// who ask for the same.
    asks: [Lines<Ask>; RANKS],
    /// What is left of each line's questions.
    looks: [Mutex<Bucket>; LINES],
    /// What clients call themselves is put into lines by it, differently in each run: nobody can choose somebody else's.
    mix: RandomState,
    pub(super) done: ArrayQueue<Done>,
    /// The same of orders to stop everything. Anybody may ask for that as often as he likes, which may cost nobody else his answer.
    pub(super) stopped: ArrayQueue<Done>,
    wants: Mutex<Wants>,
    wants_changed: AtomicBool,
    /// A variable of which every value is wanted has a new one, or a panel was drawn.
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

    /// Says who answers, who sends values and who stops everything; once.
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
        // Those who do not say who they are share the first line of their origin.
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
        // What there is no room for is dropped, which ends it without an answer: its sender knows at once.
        if self.asks[rank as usize].push(line, Ask { origin, line, query }) {
            match rank {
                Rank::Stop => self.wake_stopper(),
                Rank::Order | Rank::Touch | Rank::Look => self.wake(),
            }
        }
    }

    /// The order to stop everything that is next. One thread alone may take them.
    pub(super) fn next_stop(&self) -> Option<Ask> {
        self.asks[Rank::Stop as usize].pop()
    }

    /// The request that is next, those to stop everything aside; a question first, if there is one and that is wanted. One thread alone
    /// may take them.
    pub(super) fn next_ask(&self, look: bool) -> Option<Ask> {
        let [_, order, touch, asked] = &self.asks;
        let first = look.then(|| asked.pop()).flatten();
        first.or_else(|| [order, touch, asked].into_iter().find_map(Lines::pop))
    }

    pub(super) fn is_idle(&self) -> bool {
        let [_, mine @ ..] = &self.asks;
        mine.iter().all(Lines::is_empty) && self.done.is_empty() && self.stopped.is_empty()
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
        self.wake_stopper();
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

/// Whether a question is one to do something: at the exact key of an application, or, about everything, at those of many.
pub(super) fn is_order(key: &str) -> bool {
    key.strip_suffix(OPERATE)
        .is_some_and(|before| before.ends_with('/'))
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
