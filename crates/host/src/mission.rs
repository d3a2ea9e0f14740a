//! Ends an application when the variable that it names as its mission says so.

use std::mem::offset_of;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use jde_types::Mission;

use crate::engine::Engine;
use crate::event::Outcome;

/// Concludes as soon as the mission is published as done or failed.
pub(crate) fn follow(engine: &Arc<Engine>) {
    let Some((instance, port)) = engine.application.mission else {
        return;
    };
    let variable = Arc::clone(
        engine
            .variables
            .of(instance, port)
            .expect("a mission is an export"),
    );
    let reader = Mutex::new(variable.reader("mission"));
    let engine: Weak<Engine> = Arc::downgrade(engine);
    variable.subscribe(Arc::new(move || {
        let mut reader = reader.lock().unwrap_or_else(PoisonError::into_inner);
        let state = reader
            .latch()
            .and_then(|latched| latched.bytes.get(offset_of!(Mission, state)).copied());
        reader.release();
        let outcome = match state {
            Some(Mission::DONE) => Outcome::Done,
            Some(Mission::FAILED) => Outcome::Failed,
            _ => return,
        };
        if let Some(engine) = engine.upgrade() {
            engine.conclude(outcome);
        }
    }));
}
