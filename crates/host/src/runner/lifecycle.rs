//! Transitions of an instance between its turns: awakening, falling asleep, unloading, failing and being
//! given up.

use jde_core::Nanos;
use jde_records::turn::Turn;

use super::{InstanceState, Runner};

impl Runner {
    /// Wakes the instance, which the rules woke at `woken`.
    pub(super) fn wake_up(&mut self, woken: Nanos) {
        // The rules woke it before it was unloaded, and it has slept since then.
        if self.engine.is_unloaded(self.number) {
            return;
        }
        if let Err(reason) = self.create() {
            return self.fault(reason);
        }
        match std::mem::replace(&mut self.state, InstanceState::Changing) {
            InstanceState::Slept(mut instance) => {
                let now = self.engine.clock.now();
                self.begin_grid(woken);
                self.last_check = now;
                self.turn_record = Turn::new(Turn::AWOKE, self.number);
                let result = instance.awake();
                self.turn_record.looked = instance.copy_last_call(&mut self.turn_record, &mut self.overflow);
                self.state = InstanceState::Awake { instance, due: now };
                if let Err(reason) = result {
                    self.fault(reason);
                }
                self.record_turn();
            }
            // It slept and woke while the application was closing, and the signal to sleep was withheld.
            other => self.state = other,
        }
    }

    pub(super) fn fall_asleep(&mut self) {
        self.turn_record = Turn::new(Turn::SLEPT, self.number);
        if let Err(reason) = self.put_to_sleep()
            && !self.roll_back(&reason)
        {
            if self.claim_failure_report() {
                self.turn_record.failed = self.engine.report_fault(self.number, reason);
            }
            self.end_instance();
        }
        self.record_turn();
        self.finish_unload();
    }

    /// Ends the instance, now or when it sleeps. The next awakening creates a new one.
    pub(super) fn unload(&mut self) {
        self.unloading = true;
        self.finish_unload();
    }

    pub(super) fn finish_unload(&mut self) {
        if self.unloading && !matches!(self.state, InstanceState::Awake { .. }) {
            self.unloading = false;
            if !self.engine.is_unloaded(self.number) {
                // It was loaded again before it slept.
                return;
            }
            self.end_instance();
            // Its exports are no longer valid.
            self.engine.variables.retract_exports(self.number);
        }
    }

    pub(super) fn put_to_sleep(&mut self) -> Result<(), String> {
        match std::mem::replace(&mut self.state, InstanceState::Changing) {
            InstanceState::Awake { mut instance, .. } => {
                let result = instance.sleep();
                if self.turn_record.kind == Turn::SLEPT {
                    self.turn_record.looked =
                        instance.copy_last_call(&mut self.turn_record, &mut self.overflow);
                }
                self.engine.metrics[self.number].pause();
                self.state = InstanceState::Slept(instance);
                result
            }
            other => {
                self.state = other;
                Ok(())
            }
        }
    }

    /// Handles a failed call. The instance is not trusted any more, and the next awakening creates a new one.
    /// A build on trial is replaced by the previous one instead, which continues without a fault.
    pub(super) fn fault(&mut self, reason: String) {
        if self.roll_back(&reason) {
            return;
        }
        // The level selects again before the broken instance is called for its sleep.
        if self.claim_failure_report() {
            self.turn_record.failed = self.engine.report_fault(self.number, reason);
        }
        self.give_up();
    }

    /// Ends an instance that faulted.
    pub(super) fn give_up(&mut self) {
        if let Err(reason) = self.put_to_sleep() {
            tracing::error!(
                schema = self.engine.name(self.number),
                "also failed while going to sleep: {reason}"
            );
        }
        // Values that it exported while it fell asleep are invalid too.
        self.engine.variables.retract_exports(self.number);
        self.end_instance();
    }

    pub(super) fn end_instance(&mut self) {
        // The next instance starts without a record of lateness, and so does its health.
        self.late = [false; 2];
        self.end_trial();
        let undelivered = self
            .engine
            .panels
            .remove_instance(self.number, self.engine.clock.now());
        self.engine.report_undelivered(self.number, undelivered);
        self.state = match std::mem::replace(&mut self.state, InstanceState::Changing) {
            // Dropping the instance ends it.
            InstanceState::Slept(_) | InstanceState::Awake { .. } => InstanceState::Absent,
            other => other,
        };
    }
}
