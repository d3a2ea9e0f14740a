//! Virtual time for the executors of real time: it goes on when every thread of theirs waits, to the first instant that one waits
//! for. A call takes what it spends and not a nanosecond more, however busy the machine is. It waits for no thread that does not
//! count.
//!
//! A thread that waits looks again and again whether there is work for it. Time goes on once all have looked since the last work
//! ended, and found none: so nobody is left behind who has mail, without a word in any mailbox about it.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use jde_core::Nanos;

/// How long a thread that waits sleeps between two looks.
const LOOK: Duration = Duration::from_micros(50);

/// The time, and who waits for which.
#[derive(Debug, Default)]
pub(crate) struct Counted {
    now: AtomicU64,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Threads that count.
    hands: usize,
    waits: HashMap<ThreadId, Wait>,
    working: HashSet<ThreadId>,
    /// Grows whenever work begins or ends, and when time goes on.
    news: u64,
}

#[derive(Debug)]
struct Wait {
    until: Option<Nanos>,
    /// The news when it last found nothing to do.
    seen: u64,
}

impl Counted {
    pub(crate) fn now(&self) -> Nanos {
        self.now.load(Ordering::Acquire)
    }

    /// One thread more: time stands still until it waits, too.
    pub(super) fn hire(&self) {
        self.lock().hands += 1;
    }

    /// One thread less.
    pub(super) fn dismiss(&self) {
        let mut state = self.lock();
        state.hands = state.hands.saturating_sub(1);
        state.forget();
        state.news += 1;
    }

    /// This thread found something to do.
    pub(super) fn works(&self) {
        let mut state = self.lock();
        state.working.insert(thread::current().id());
        state.news += 1;
    }

    /// Waits a moment for news, or for that time.
    pub(super) fn wait<'a, T>(
        &self,
        news: &Condvar,
        guard: MutexGuard<'a, T>,
        until: Option<Nanos>,
    ) -> MutexGuard<'a, T> {
        self.enter(until);
        let waited = news.wait_timeout(guard, LOOK);
        self.lock().waits.remove(&thread::current().id());
        waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Lets that much time pass, as part of what this thread does.
    pub(super) fn spend(&self, time: Nanos) {
        let until = self.now().saturating_add(time);
        while self.now() < until {
            self.enter(Some(until));
            thread::sleep(LOOK);
        }
        self.lock().waits.remove(&thread::current().id());
        self.works();
    }

    fn enter(&self, until: Option<Nanos>) {
        let mut state = self.lock();
        let this = thread::current().id();
        if state.working.remove(&this) {
            state.news += 1;
        }
        let seen = state.news;
        state.waits.insert(this, Wait { until, seen });
        if state.waits.len() < state.hands || state.waits.values().any(|wait| wait.seen != seen) {
            return;
        }
        let next = state.waits.values().filter_map(|wait| wait.until).min();
        if let Some(next) = next.filter(|next| *next > self.now()) {
            self.now.store(next, Ordering::Release);
            state.news += 1;
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn forget(&mut self) {
        let this = thread::current().id();
        self.working.remove(&this);
        self.waits.remove(&this);
    }
}
