//! Who is called after each publication of a variable, and how that ends. The calls run on the writer's thread, so a publication takes as
//! long as they do. The end of a watch holds up no writer.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use arc_swap::ArcSwap;

use crate::Variable;
use crate::bell::Bell;

thread_local! {
    /// How many calls of watches this thread is inside of.
    static INSIDE: Cell<usize> = const { Cell::new(0) };
}

/// Somebody who is called after each publish of a variable.
///
/// Dropped, it ends, and once the drop has returned the call runs nowhere and never again. So the drop waits for a call that
/// another thread is inside of: whoever drops must hold nothing that the call wants. Dropped inside of such a call, of this watch
/// or another, it does not wait: what already runs comes to its end, and nothing begins anew.
pub struct Watch {
    variable: Arc<Variable>,
    watcher: Arc<Watcher>,
}

/// All watches of a variable.
#[derive(Default)]
pub(crate) struct Watchers {
    count: AtomicUsize,
    watchers: ArcSwap<Vec<Arc<Watcher>>>,
}

struct Watcher {
    call: Box<dyn Fn() + Send + Sync>,
    ended: AtomicBool,
    /// Threads that are about to call, or are inside of it.
    calling: AtomicUsize,
    returned: Bell,
}

/// One call under way; over when it is dropped, also by a panic.
struct Calling<'a>(&'a Watcher);

impl Watch {
    pub(crate) fn begin(variable: &Arc<Variable>, call: impl Fn() + Send + Sync + 'static) -> Self {
        let watcher = Arc::new(Watcher {
            call: Box::new(call),
            ended: AtomicBool::new(false),
            calling: AtomicUsize::new(0),
            returned: Bell::default(),
        });
        variable.watchers.add(&watcher);
        Self {
            variable: Arc::clone(variable),
            watcher,
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.variable.watchers.remove(&self.watcher);
        self.watcher.end();
    }
}

impl Watchers {
    /// Calls everybody.
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

    fn remove(&self, gone: &Arc<Watcher>) {
        self.watchers.rcu(|watchers| {
            let rest = watchers.iter().filter(|watcher| !Arc::ptr_eq(watcher, gone));
            rest.cloned().collect::<Vec<_>>()
        });
        self.count.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Watcher {
    fn call(&self) {
        let calling = Calling::begin(self);
        // Sequentially consistent with `end`: either this thread sees that it ended, or that one sees this thread calling.
        if !self.ended.load(Ordering::SeqCst) {
            (self.call)();
        }
        drop(calling);
    }

    fn end(&self) {
        self.ended.store(true, Ordering::SeqCst);
        if INSIDE.get() > 0 {
            return;
        }
        while self.calling.load(Ordering::SeqCst) > 0 {
            let returned = || self.calling.load(Ordering::SeqCst) == 0;
            self.returned.wait(Duration::from_secs(1), returned);
        }
    }
}

impl<'a> Calling<'a> {
    fn begin(watcher: &'a Watcher) -> Self {
        INSIDE.set(INSIDE.get() + 1);
        watcher.calling.fetch_add(1, Ordering::SeqCst);
        Self(watcher)
    }
}

impl Drop for Calling<'_> {
    fn drop(&mut self) {
        self.0.calling.fetch_sub(1, Ordering::SeqCst);
        self.0.returned.ring();
        INSIDE.set(INSIDE.get() - 1);
    }
}
