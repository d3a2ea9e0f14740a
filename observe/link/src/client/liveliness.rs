//! Whether an application is reachable, with waits and callbacks for changes.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

type OnGone = Box<dyn FnOnce() + Send>;

/// The liveliness of an application.
#[derive(Default)]
pub(super) struct Liveliness {
    state: Mutex<LivelinessState>,
    changed: Condvar,
}

#[derive(Default)]
struct LivelinessState {
    alive: bool,
    on_gone: Vec<OnGone>,
}

impl Liveliness {
    pub(super) fn set(&self, alive: bool) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.alive = alive;
        let callbacks = if alive {
            Vec::new()
        } else {
            std::mem::take(&mut state.on_gone)
        };
        drop(state);
        self.changed.notify_all();
        callbacks.into_iter().for_each(|callback| callback());
    }

    pub(super) fn is_alive(&self) -> bool {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).alive
    }

    /// Waits until the application is alive or gone, as `alive` states, at most for `timeout`. Returns
    /// whether it is.
    pub(super) fn wait(&self, alive: bool, timeout: Duration) -> bool {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (state, _) = self
            .changed
            .wait_timeout_while(state, timeout, |state| state.alive != alive)
            .unwrap_or_else(PoisonError::into_inner);
        state.alive == alive
    }

    pub(super) fn on_gone(&self, callback: OnGone) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.alive {
            state.on_gone.push(callback);
        } else {
            drop(state);
            callback();
        }
    }
}
