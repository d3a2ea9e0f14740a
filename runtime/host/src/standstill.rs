//! Time that stands still: a running application to look at, step by step. The clock keeps it.

use std::time::Duration;

use jde_records::event::{Outcome, What};

use crate::operator_handle::OperatorHandle;
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
    /// Lets time stand still for this reason, if [`Options::may_stand_still`](crate::Options::may_stand_still)
    /// permits it: nothing becomes due, and nothing is late or ends. What is due or triggered at this instant
    /// still takes its turn. It waits for nothing, so an observer may call it.
    pub fn stand_still(&self, reason: &str) {
        if self.engine.clock.stand_still(reason) {
            self.engine.rules.report_later(
                What::StoodStill {
                    reason: reason.to_owned(),
                }
                .at(self.engine.clock.now()),
            );
        }
    }

    /// Returns why time stands still; `None` while it passes.
    #[must_use]
    pub fn standstill(&self) -> Option<String> {
        self.engine.clock.standstill_reason()
    }
}

impl OperatorHandle {
    /// Lets time pass again that stands still.
    ///
    /// # Errors
    /// Time passes already.
    pub fn continue_time(&self) -> Result<(), String> {
        self.pass_time(false)
    }

    /// Lets a little time pass, and then stand still again: to the next instant in lockstep, otherwise 10 ms.
    ///
    /// # Errors
    /// Time passes already.
    pub fn step_time(&self) -> Result<(), String> {
        self.pass_time(true)
    }

    fn pass_time(&self, one_step: bool) -> Result<(), String> {
        if !self.engine.clock.is_still() {
            return Err(String::from(
                "its time passes; `jde run --break CONDITION` lets it stand still",
            ));
        }
        // Reports the standstill before its end.
        self.engine.rules.transact(|_| ());
        self.engine.rules.report_now(What::WentOn {
            by: self.by.name.clone(),
            one_step,
        });
        if one_step {
            self.engine.clock.step();
        } else {
            self.engine.clock.go_on();
        }
        Ok(())
    }
}
