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
        let calls = if alive {
            Vec::new()
        } else {
            std::mem::take(&mut state.on_gone)
        };
        drop(state);
        self.changed.notify_all();
        calls.into_iter().for_each(|call| call());
    }

    pub(super) fn is_alive(&self) -> bool {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).alive
    }

    /// Waits until the state is as wanted, at most for `timeout`. Returns whether it is.
    pub(super) fn wait(&self, alive: bool, timeout: Duration) -> bool {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (state, _) = self
            .changed
            .wait_timeout_while(state, timeout, |state| state.alive != alive)
            .unwrap_or_else(PoisonError::into_inner);
        state.alive == alive
    }

    pub(super) fn on_gone(&self, call: OnGone) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.alive {
            state.on_gone.push(call);
        } else {
            drop(state);
            call();
        }
    }
}
