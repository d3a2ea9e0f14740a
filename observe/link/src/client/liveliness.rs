//! Whether an application is reachable, with waits and callbacks for changes.

use std::time::Duration;

use parking_lot::{Condvar, Mutex};

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
        let mut state = self.state.lock();
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
        self.state.lock().alive
    }

    /// Waits until the application is alive or gone, as `alive` states, at most for `timeout`. Returns
    /// whether it is.
    pub(super) fn wait(&self, alive: bool, timeout: Duration) -> bool {
        let mut state = self.state.lock();
        self.changed
            .wait_while_for(&mut state, |state| state.alive != alive, timeout);
        state.alive == alive
    }

    pub(super) fn on_gone(&self, callback: OnGone) {
        let mut state = self.state.lock();
        if state.alive {
            state.on_gone.push(callback);
        } else {
            drop(state);
            callback();
        }
    }
}
