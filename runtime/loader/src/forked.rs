//! Ends the processes that a plugin forks, where they return from the plugin. Such a process is a copy of this one: it would
//! answer the host, command the devices and write the files of this one beside it. One that does not return, or runs another
//! program, is not touched; until it returns, it can call the host as this one does.

#![allow(unsafe_code)]

use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};

/// How often this process, or one that it comes from, was forked since [`watch`].
static FORKS: AtomicU64 = AtomicU64::new(0);

/// Begins to count. Must be called before the first plugin is loaded.
pub(super) fn watch() {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(|| {
        // SAFETY: the function may be called in a process that was just forked: it does nothing but add.
        let refused = unsafe { libc::pthread_atfork(None, None, Some(count)) };
        if refused != 0 {
            tracing::warn!("there is no memory to notice processes that plugins fork");
        }
    });
}

/// Runs in the new process, in its only thread.
extern "C" fn count() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// Calls a function of a plugin. It returns only in the process that it was called in.
pub(super) fn call<R>(function: impl FnOnce() -> R) -> R {
    let before = FORKS.load(Ordering::Relaxed);
    let result = function();
    if FORKS.load(Ordering::Relaxed) != before {
        // SAFETY: it ends this process without any code of it: locks may be held by threads that are not here.
        unsafe { libc::_exit(1) };
    }
    result
}
