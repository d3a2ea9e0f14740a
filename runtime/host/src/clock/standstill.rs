//! Time that stands still: nothing is due, nothing is late, and everything can be looked at. Only for
//! applications that were started with that permission, which no device tolerates.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use jde_core::Nanos;
use parking_lot::{Condvar, Mutex};

/// The value of [`Standstill::frozen`] while time passes.
const TIME_PASSES: Nanos = Nanos::MAX;

/// Whether time stands still, and since when.
#[derive(Debug)]
pub(crate) struct Standstill {
    /// The application's time while it stands still.
    frozen: AtomicU64,
    /// How much less time has passed than on the machine, ns. It wraps: steps may pass more.
    lost: AtomicU64,
    /// `None` while it passes.
    still: Mutex<Option<Still>>,
    changed: Condvar,
}

#[derive(Clone, Debug)]
struct Still {
    reason: String,
    /// Whether one step is requested, in virtual time.
    step: bool,
}

impl Default for Standstill {
    fn default() -> Self {
        Self {
            frozen: AtomicU64::new(TIME_PASSES),
            lost: AtomicU64::new(0),
            still: Mutex::default(),
            changed: Condvar::new(),
        }
    }
}

impl Standstill {
    /// Returns the application's time, where `running` would be the time if it had never stood still. It
    /// never goes back.
    ///
    /// Not inlined, so that the clock of an application that never stands still stays small enough to be.
    #[inline(never)]
    pub(crate) fn now(&self, running: impl Fn() -> Nanos) -> Nanos {
        loop {
            let frozen = self.frozen.load(Ordering::Acquire);
            if frozen != TIME_PASSES {
                return frozen;
            }
            let lost = self.lost.load(Ordering::Acquire);
            let now = running().wrapping_sub(lost);
            // Otherwise it may have been stopped in between, at an earlier time than this.
            if self.frozen.load(Ordering::Acquire) == TIME_PASSES && self.lost.load(Ordering::Acquire) == lost
            {
                return now;
            }
        }
    }

    /// Lets time stand still, for this reason. Returns whether it passed until now.
    pub(crate) fn stop(&self, now: impl Fn() -> Nanos, reason: &str) -> bool {
        let mut current = self.still.lock();
        if current.is_some() {
            return false;
        }
        *current = Some(Still {
            reason: reason.to_owned(),
            step: false,
        });
        self.frozen.store(now(), Ordering::Release);
        true
    }

    /// Lets time pass again.
    pub(crate) fn go_on(&self, running: impl Fn() -> Nanos) {
        let mut current = self.still.lock();
        if current.take().is_some() {
            let frozen = self.frozen.load(Ordering::Acquire);
            self.lost.store(running().wrapping_sub(frozen), Ordering::Release);
            self.frozen.store(TIME_PASSES, Ordering::Release);
        }
        drop(current);
        self.changed.notify_all();
    }

    /// Lets a little time pass at once.
    pub(crate) fn step(&self, time: Nanos) {
        let current = self.still.lock();
        if current.is_some() {
            self.frozen.fetch_add(time, Ordering::AcqRel);
        }
    }

    /// Requests a step of virtual time.
    pub(crate) fn request_step(&self) {
        if let Some(still) = &mut *self.still.lock() {
            still.step = true;
        }
        self.changed.notify_all();
    }

    /// Waits until time passes or a step is requested, at most for `timeout`. Returns whether a step is
    /// requested, and takes that back.
    pub(crate) fn wait(&self, timeout: Duration) -> bool {
        let waits = |still: &mut Option<Still>| still.as_ref().is_some_and(|still| !still.step);
        let mut still = self.still.lock();
        self.changed.wait_while_for(&mut still, waits, timeout);
        still
            .as_mut()
            .is_some_and(|still| std::mem::take(&mut still.step))
    }

    /// Returns why time stands still; `None` while it passes.
    pub(crate) fn reason(&self) -> Option<String> {
        self.still.lock().as_ref().map(|still| still.reason.clone())
    }

    /// Whether time stands still.
    pub(crate) fn is_still(&self) -> bool {
        self.frozen.load(Ordering::Acquire) != TIME_PASSES
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn time_stands_still_and_passes_again_without_a_jump() {
        let machine = Cell::new(100);
        let still = Standstill::default();
        let running = || machine.get();
        assert_eq!(still.now(running), 100);
        assert!(still.stop(|| still.now(running), "a reason"));
        assert!(!still.stop(|| still.now(running), "another"), "it stands already");
        machine.set(150);
        assert_eq!(
            (still.now(running), still.reason().as_deref()),
            (100, Some("a reason"))
        );
        still.step(7);
        assert_eq!(still.now(running), 107);
        still.go_on(running);
        assert_eq!((still.now(running), still.reason()), (107, None));
        machine.set(160);
        assert_eq!(still.now(running), 117);
    }

    #[test]
    fn time_never_goes_back_although_steps_pass_more_time_than_the_machine() {
        let machine = Cell::new(100);
        let still = Standstill::default();
        let running = || machine.get();
        assert!(still.stop(|| still.now(running), "a reason"));
        (0..20).for_each(|_| still.step(10));
        machine.set(105);
        still.go_on(running);
        assert_eq!(still.now(running), 300);
        machine.set(106);
        assert_eq!(still.now(running), 301);
    }
}
