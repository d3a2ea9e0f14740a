//! Wakes the threads that wait for the next value. Costs the writer a load while nobody waits.

use std::sync::atomic::{AtomicU32, Ordering, fence};
use std::time::{Duration, Instant};

use rustix::thread::futex;
use rustix::time::Timespec;

/// A futex and the number of threads that wait on it.
#[derive(Default)]
pub(crate) struct Bell {
    rung: AtomicU32,
    waiting: AtomicU32,
}

impl Bell {
    /// Wakes everybody who waits. To be called after what they wait for has been written, sequentially consistent.
    pub(crate) fn ring(&self) {
        // With the fence in `wait`: either this thread sees that somebody waits, or that one sees the new value.
        if self.waiting.load(Ordering::SeqCst) != 0 {
            self.rung.fetch_add(1, Ordering::Release);
            // Fails only for a bad address, which this is not.
            let _ = futex::wake(&self.rung, futex::Flags::PRIVATE, u32::MAX >> 1);
        }
    }

    /// Waits until `done` or the time is over.
    pub(crate) fn wait(&self, timeout: Duration, done: impl Fn() -> bool) {
        let deadline = Instant::now().checked_add(timeout);
        self.waiting.fetch_add(1, Ordering::Relaxed);
        loop {
            let rung = self.rung.load(Ordering::Acquire);
            fence(Ordering::SeqCst);
            if done() {
                break;
            }
            let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
            if left.is_some_and(|left| left.is_zero()) {
                break;
            }
            let left = left.and_then(|left| Timespec::try_from(left).ok());
            // Woken, interrupted, rung meanwhile or out of time: in every case the loop looks again.
            let _ = futex::wait(&self.rung, futex::Flags::PRIVATE, rung, left.as_ref());
        }
        self.waiting.fetch_sub(1, Ordering::Relaxed);
    }
}
