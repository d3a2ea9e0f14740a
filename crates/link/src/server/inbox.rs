//! What Zenoh's threads leave for those of the link. They never serve a request and never wait: what there is no room for is dropped
//! and its sender told so.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::Thread;

use crossbeam_queue::ArrayQueue;
use zenoh::query::Query;

use super::hands::Done;
use crate::keys::{self, Keys, OPERATE, Rate};

/// Requests that wait.
const ASKS: usize = 256;
/// Tokens of clients that are minded; more values than anybody watches at once.
const TOKENS: usize = 4096;

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

/// Which requests go first.
#[derive(Clone, Copy)]
enum Rank {
    /// What operators on this machine want done.
    Order,
    /// What else is asked on this machine.
    Local,
    /// Whatever comes from the network.
    Network,
}

/// What clients want of one variable at one rate.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Want {
    /// `owner/variable`, as it stands in keys.
    pub(super) place: String,
    pub(super) rate: Rate,
    pub(super) origin: Origin,
}

/// Who wants it.
#[derive(Default)]
pub(super) struct Wanting {
    tokens: BTreeSet<String>,
    /// Counts those who came.
    pub(super) joined: u64,
}

/// What waits for the worker.
pub(super) struct Inbox {
    /// By their [`Rank`]: whoever asks much keeps nobody of another rank waiting.
    asks: [ArrayQueue<Ask>; 3],
    pub(super) done: ArrayQueue<Done>,
    wants: Mutex<BTreeMap<Want, Wanting>>,
    wants_changed: AtomicBool,
    /// A variable of which every value is wanted has a new one.
    fresh: AtomicBool,
    stop: AtomicBool,
    worker: OnceLock<Thread>,
    values: OnceLock<Thread>,
}

impl Inbox {
    pub(super) fn new() -> Self {
        Self {
            asks: std::array::from_fn(|_| ArrayQueue::new(ASKS)),
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
        let rank = match origin {
            Origin::Network => Rank::Network,
            Origin::Local if query.key_expr().as_str().ends_with(OPERATE) => Rank::Order,
            Origin::Local => Rank::Local,
        };
        // A full queue drops the request, which ends it without an answer: its sender knows at once.
        if self.asks[rank as usize].push(Ask { origin, query }).is_ok() {
            self.wake();
        }
    }

    /// The request that is next.
    pub(super) fn next_ask(&self) -> Option<Ask> {
        self.asks.iter().find_map(ArrayQueue::pop)
    }

    pub(super) fn is_idle(&self) -> bool {
        self.asks.iter().all(ArrayQueue::is_empty) && self.done.is_empty()
    }

    /// A variable has a new value. Called by whoever publishes it.
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
        let Some((place, rate)) = keys.below(token).and_then(keys::wanted) else {
            return;
        };
        let want = Want { place, rate, origin };
        let mut wants = self.wants.lock().unwrap_or_else(PoisonError::into_inner);
        if there {
            let many = wants.values().map(|wanting| wanting.tokens.len()).sum::<usize>();
            if many >= TOKENS {
                return;
            }
            let wanting = wants.entry(want).or_default();
            if wanting.tokens.insert(token.to_owned()) {
                wanting.joined += 1;
            }
        } else if let Some(wanting) = wants.get_mut(&want) {
            wanting.tokens.remove(token);
            if wanting.tokens.is_empty() {
                wants.remove(&want);
            }
        }
        drop(wants);
        self.wants_changed.store(true, Ordering::Release);
        self.wake_values();
    }

    /// What is wanted and how many have come for it, if that changed.
    pub(super) fn wants(&self) -> Option<BTreeMap<Want, u64>> {
        if !self.wants_changed.swap(false, Ordering::AcqRel) {
            return None;
        }
        let wants = self.wants.lock().unwrap_or_else(PoisonError::into_inner);
        let joined = wants.iter().map(|(want, wanting)| (want.clone(), wanting.joined));
        Some(joined.collect())
    }
}
