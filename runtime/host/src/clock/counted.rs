//! Virtual time for the executors of real time. It advances when every registered thread waits, to the first
//! instant that one of them waits for. A call takes exactly the time that it spends, however busy the machine
//! is. Threads that are not registered do not delay it.
//!
//! A waiting thread checks repeatedly whether it has work. Time advances once all threads have checked since
//! the last work ended and found none. So no thread with pending signals is skipped, and the clock needs no
//! access to mailboxes.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, ThreadId};
use std::time::Duration;

use jde_core::Nanos;
use parking_lot::{Condvar, Mutex, MutexGuard};

/// How long a waiting thread sleeps between two checks.
const CHECK_INTERVAL: Duration = Duration::from_micros(50);

/// The time, and which thread waits for which instant.
#[derive(Debug, Default)]
pub(crate) struct Counted {
    now: AtomicU64,
    state: Mutex<CountedState>,
}

#[derive(Debug, Default)]
struct CountedState {
    /// The number of registered threads.
    threads: usize,
    waiting: HashMap<ThreadId, Wait>,
    working: HashSet<ThreadId>,
    /// Grows whenever work begins or ends, and when time advances.
    version: u64,
}

#[derive(Debug)]
struct Wait {
    until: Option<Nanos>,
    /// The value of `version` when the thread last found no work.
    seen_version: u64,
}

impl Counted {
    pub(crate) fn now(&self) -> Nanos {
        self.now.load(Ordering::Acquire)
    }

    /// Registers one more thread: time does not advance until it waits, too.
    pub(super) fn register_thread(&self) {
        self.state.lock().threads += 1;
    }

    /// Removes one thread.
    pub(super) fn unregister_thread(&self) {
        let mut state = self.state.lock();
        state.threads = state.threads.saturating_sub(1);
        state.remove_current_thread();
        state.version += 1;
    }

    /// Marks this thread as busy.
    pub(super) fn mark_busy(&self) {
        let mut state = self.state.lock();
        state.working.insert(thread::current().id());
        state.version += 1;
    }

    /// Waits a moment for a notification, or for that time.
    pub(super) fn wait<T>(&self, condition: &Condvar, guard: &mut MutexGuard<'_, T>, until: Option<Nanos>) {
        self.begin_wait(until);
        condition.wait_for(guard, CHECK_INTERVAL);
        self.state.lock().waiting.remove(&thread::current().id());
    }

    /// Lets that much time pass, as part of this thread's work.
    pub(super) fn spend(&self, time: Nanos) {
        let until = self.now().saturating_add(time);
        while self.now() < until {
            self.begin_wait(Some(until));
            thread::sleep(CHECK_INTERVAL);
        }
        self.state.lock().waiting.remove(&thread::current().id());
        self.mark_busy();
    }

    fn begin_wait(&self, until: Option<Nanos>) {
        let mut state = self.state.lock();
        let this = thread::current().id();
        if state.working.remove(&this) {
            state.version += 1;
        }
        let version = state.version;
        state.waiting.insert(
            this,
            Wait {
                until,
                seen_version: version,
            },
        );
        if state.waiting.len() < state.threads
            || state.waiting.values().any(|wait| wait.seen_version != version)
        {
            return;
        }
        let next = state.waiting.values().filter_map(|wait| wait.until).min();
        if let Some(next) = next.filter(|next| *next > self.now()) {
            self.now.store(next, Ordering::Release);
            state.version += 1;
        }
    }
}

impl CountedState {
    fn remove_current_thread(&mut self) {
        let this = thread::current().id();
        self.working.remove(&this);
        self.waiting.remove(&this);
    }
}
