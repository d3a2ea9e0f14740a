//! How an application ended. The first outcome counts.

use std::sync::atomic::{AtomicBool, Ordering};

use jde_records::event::Outcome;
use parking_lot::{Condvar, Mutex};

/// The outcome of an application, once there is one.
#[derive(Default)]
pub(crate) struct RunOutcome {
    outcome: Mutex<Option<Outcome>>,
    /// Whether there is an outcome. Checked far more often than it changes.
    is_concluded: AtomicBool,
    concluded: Condvar,
}

impl RunOutcome {
    /// Ends the application.
    pub(crate) fn conclude(&self, outcome: Outcome) {
        let mut slot = self.outcome.lock();
        slot.get_or_insert(outcome);
        self.is_concluded.store(true, Ordering::Release);
        drop(slot);
        self.concluded.notify_all();
    }

    /// Returns the outcome; `None` while the application runs.
    pub(crate) fn get(&self) -> Option<Outcome> {
        let is_concluded = self.is_concluded.load(Ordering::Acquire);
        is_concluded.then(|| self.outcome.lock().clone()).flatten()
    }

    /// Blocks until the application concludes.
    pub(crate) fn wait(&self) -> Outcome {
        let mut slot = self.outcome.lock();
        self.concluded.wait_while(&mut slot, |slot| slot.is_none());
        slot.clone().expect("waited for it")
    }
}
