//! The calls after each publication and each end of a value of a variable, and how they end. They run on the writer's thread, so a
//! publication takes as long as they do. The end of a watch delays no writer.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use arc_swap::ArcSwap;

use crate::Variable;
use crate::notifier::Notifier;

thread_local! {
    /// The number of watch calls that this thread is inside of.
    static CALL_DEPTH: Cell<usize> = const { Cell::new(0) };
}

/// A call after each publication or each end of a value of a variable, until the watch is dropped.
///
/// When the drop has returned, the call does not run and never will again. So the drop waits for a call on
/// another thread: the dropping thread must hold nothing that the call needs. A drop inside a watch call, of
/// this watch or another, does not wait: a running call completes, and no new one begins.
pub struct Watch {
    variable: Arc<Variable>,
    occasion: Occasion,
    watcher: Arc<Watcher>,
}

/// What a watch is called after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Occasion {
    /// Each publication, and each end of a value without another.
    Change,
    /// Each end of a value without another.
    End,
}

/// The watches of a variable for one occasion.
#[derive(Default)]
pub(crate) struct Watchers {
    count: AtomicUsize,
    watchers: ArcSwap<Vec<Arc<Watcher>>>,
}

struct Watcher {
    call: Box<dyn Fn() + Send + Sync>,
    cancelled: AtomicBool,
    /// Threads that are about to call, or are inside the call.
    active_calls: AtomicUsize,
    returned: Notifier,
}

/// A call in progress. It ends when the guard is dropped, also by a panic.
struct CallGuard<'a>(&'a Watcher);

impl Watch {
    pub(crate) fn new(
        variable: &Arc<Variable>,
        occasion: Occasion,
        call: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let watcher = Arc::new(Watcher {
            call: Box::new(call),
            cancelled: AtomicBool::new(false),
            active_calls: AtomicUsize::new(0),
            returned: Notifier::default(),
        });
        variable.watchers(occasion).add(&watcher);
        Self {
            variable: Arc::clone(variable),
            occasion,
            watcher,
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.variable.watchers(self.occasion).remove(&self.watcher);
        self.watcher.cancel();
    }
}

impl Watchers {
    /// Calls all watchers.
    #[inline]
    pub(crate) fn call(&self) {
        if self.count.load(Ordering::Acquire) > 0 {
            self.watchers.load().iter().for_each(|watcher| watcher.call());
        }
    }

    fn add(&self, watcher: &Arc<Watcher>) {
        self.count.fetch_add(1, Ordering::AcqRel);
        self.watchers
            .rcu(|watchers| watchers.iter().chain([watcher]).cloned().collect::<Vec<_>>());
    }

    fn remove(&self, removed: &Arc<Watcher>) {
        self.watchers.rcu(|watchers| {
            let remaining = watchers.iter().filter(|watcher| !Arc::ptr_eq(watcher, removed));
            remaining.cloned().collect::<Vec<_>>()
        });
        self.count.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Watcher {
    fn call(&self) {
        let guard = CallGuard::new(self);
        // Sequentially consistent with `cancel`: either this thread sees the end, or that thread sees this
        // call.
        if !self.cancelled.load(Ordering::SeqCst) {
            (self.call)();
        }
        drop(guard);
    }

    fn cancel(&self) {
        self.cancelled.store(true, Ordering::SeqCst);
        if CALL_DEPTH.get() > 0 {
            return;
        }
        while self.active_calls.load(Ordering::SeqCst) > 0 {
            let returned = || self.active_calls.load(Ordering::SeqCst) == 0;
            self.returned.wait(Duration::from_secs(1), returned);
        }
    }
}

impl<'a> CallGuard<'a> {
    fn new(watcher: &'a Watcher) -> Self {
        CALL_DEPTH.set(CALL_DEPTH.get() + 1);
        watcher.active_calls.fetch_add(1, Ordering::SeqCst);
        Self(watcher)
    }
}

impl Drop for CallGuard<'_> {
    fn drop(&mut self) {
        self.0.active_calls.fetch_sub(1, Ordering::SeqCst);
        self.0.returned.notify_all();
        CALL_DEPTH.set(CALL_DEPTH.get() - 1);
    }
}
