//! Time that stands still: a running application to look at, step by step. The clock keeps it.

use std::time::Duration;

use jde_records::event::Outcome;

use crate::running::{Handle, Lockstep};

/// How often an application in lockstep whose time stands still looks whether it is to end.
const STILL_INTERVAL: Duration = Duration::from_millis(50);

impl Lockstep {
    /// Waits while time stands still, and makes the steps that are requested meanwhile. Returns when time
    /// passes again, or the application's outcome.
    pub fn wait_while_still(&mut self) -> Option<Outcome> {
        while let Some(reason) = self.engine.clock.standstill_reason() {
            if let Some(outcome) = self.engine.outcome.get() {
                return Some(outcome);
            }
            if !self.engine.clock.wait_while_still(STILL_INTERVAL) {
                continue;
            }
            let Some(next) = self.next_instant() else { continue };
            self.engine.clock.go_on();
            let outcome = self.run_until(next);
            self.engine.clock.stand_still(&reason);
            if outcome.is_some() {
                return outcome;
            }
        }
        None
    }
}

impl Handle {
    /// Lets time stand still for this reason, if [`Options::may_stand_still`] permits it: no schema takes a
    /// turn, and nothing is late or ends. Everything can be looked at. In lockstep, the present instant ends
    /// first.
    pub fn stand_still(&self, reason: &str) {
        self.engine.clock.stand_still(reason);
    }

    /// Returns why time stands still; `None` while it passes.
    #[must_use]
    pub fn standstill(&self) -> Option<String> {
        self.engine.clock.standstill_reason()
    }

    /// Lets time pass again.
    pub fn go_on(&self) {
        self.engine.clock.go_on();
    }

    /// Lets a little time pass while it stands still: to the next instant in lockstep, otherwise 10 ms.
    pub fn step(&self) {
        self.engine.clock.step();
    }
}
