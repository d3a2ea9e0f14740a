//! Ends an application when the variable that it names as its mission says so.

use std::mem::offset_of;
use std::sync::{Arc, Weak};

use jde_types::Mission;

use crate::engine::Engine;
use crate::event::Outcome;

/// Concludes as soon as the mission is published as done or failed.
pub(crate) fn follow(engine: &Arc<Engine>) {
    let Some((instance, port)) = engine.application.mission else {
        return;
    };
    let Some(variable) = engine.variables.of(instance, port) else {
        unreachable!("a mission is an export");
    };
    // A reader or an engine kept in the watch would keep what keeps the watch.
    let weak: Weak<Engine> = Arc::downgrade(engine);
    engine.keep([variable.watch(move || {
        let Some(engine) = weak.upgrade() else { return };
        let Some(variable) = engine.variables.of(instance, port) else {
            return;
        };
        let state = variable
            .reader("mission")
            .latch()
            .and_then(|latched| latched.bytes.get(offset_of!(Mission, state)).copied());
        let outcome = match state {
            Some(Mission::DONE) => Outcome::Done,
            Some(Mission::FAILED) => Outcome::Failed,
            _ => return,
        };
        engine.conclude(outcome);
    })]);
}
