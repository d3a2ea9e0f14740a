//! Wakes the threads that wait for the next value. It costs the writer one load while no thread waits.

use std::sync::atomic::{AtomicU32, Ordering, fence};
use std::time::{Duration, Instant};

use rustix::thread::futex;
use rustix::time::Timespec;

/// A futex and the number of threads that wait on it.
#[derive(Default)]
pub(crate) struct Notifier {
    sequence: AtomicU32,
    waiters: AtomicU32,
}

impl Notifier {
    /// Wakes all waiting threads. The caller must first write what they wait for, with a sequentially
    /// consistent store.
    pub(crate) fn notify_all(&self) {
        // With the fence in `wait`: either this thread sees the waiting thread, or that thread sees the new
        // value.
        if self.waiters.load(Ordering::SeqCst) != 0 {
            self.sequence.fetch_add(1, Ordering::Release);
            // This fails only for an invalid address, and this one is valid.
            let _ = futex::wake(&self.sequence, futex::Flags::PRIVATE, u32::MAX >> 1);
        }
    }

    /// Waits until `done` returns true or the timeout ends.
    pub(crate) fn wait(&self, timeout: Duration, done: impl Fn() -> bool) {
        let deadline = Instant::now().checked_add(timeout);
        self.waiters.fetch_add(1, Ordering::Relaxed);
        loop {
            let observed = self.sequence.load(Ordering::Acquire);
            fence(Ordering::SeqCst);
            if done() {
                break;
            }
            let remaining = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
            if remaining.is_some_and(|remaining| remaining.is_zero()) {
                break;
            }
            let remaining = remaining.and_then(|remaining| Timespec::try_from(remaining).ok());
            // Whether woken, interrupted, notified meanwhile or timed out, the loop checks again.
            let _ = futex::wait(
                &self.sequence,
                futex::Flags::PRIVATE,
                observed,
                remaining.as_ref(),
            );
        }
        self.waiters.fetch_sub(1, Ordering::Relaxed);
    }
}
