//! How an application ended. The first outcome counts.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use jde_records::event::Outcome;

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
        let mut slot = self.lock();
        slot.get_or_insert(outcome);
        self.is_concluded.store(true, Ordering::Release);
        drop(slot);
        self.concluded.notify_all();
    }

    /// Returns the outcome; `None` while the application runs.
    pub(crate) fn get(&self) -> Option<Outcome> {
        let is_concluded = self.is_concluded.load(Ordering::Acquire);
        is_concluded.then(|| self.lock().clone()).flatten()
    }

    /// Blocks until the application concludes.
    pub(crate) fn wait(&self) -> Outcome {
        let slot = self.concluded.wait_while(self.lock(), |slot| slot.is_none());
        let slot = slot.unwrap_or_else(PoisonError::into_inner);
        slot.clone().expect("waited for it")
    }

    fn lock(&self) -> MutexGuard<'_, Option<Outcome>> {
        self.outcome.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
