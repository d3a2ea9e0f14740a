//! Transitions of an instance between its turns: it awakes and falls asleep, is unloaded, fails and is given
//! up.

use jde_core::Nanos;

use super::{Life, Runner};
use crate::turn::Turn;

impl Runner {
    /// Wakes the instance, which the rules woke at `woken`.
    pub(super) fn wake_up(&mut self, woken: Nanos) {
        // The rules woke it before it was unloaded, and it is asleep again since.
        if self.engine.is_unloaded(self.number) {
            return;
        }
        if let Err(reason) = self.create() {
            return self.fault(reason);
        }
        match std::mem::replace(&mut self.life, Life::Changing) {
            Life::Slept(mut instance) => {
                let now = self.engine.clock.now();
                self.begin_grid(woken);
                self.last_check = now;
                self.told = Turn::of(Turn::AWOKE, self.number);
                let result = instance.awake();
                self.told.looked = instance.called(&mut self.told, &mut self.beyond);
                self.life = Life::Awake { instance, due: now };
                if let Err(reason) = result {
                    self.fault(reason);
                }
                self.tell();
            }
            // It slept and woke while the application was closing, and the signal to sleep was withheld.
            other => self.life = other,
        }
    }

    pub(super) fn fall_asleep(&mut self) {
        self.told = Turn::of(Turn::SLEPT, self.number);
        if let Err(reason) = self.lie_down()
            && !self.go_back(&reason)
        {
            if self.is_to_tell() {
                self.told.failed = self.engine.faulted(self.number, reason);
            }
            self.dismiss();
        }
        self.tell();
        self.put_away();
    }

    /// Ends the instance, now or when it sleeps. The next awakening creates a new one.
    pub(super) fn unload(&mut self) {
        self.unloading = true;
        self.put_away();
    }

    pub(super) fn put_away(&mut self) {
        if self.unloading && !matches!(self.life, Life::Awake { .. }) {
            self.unloading = false;
            if !self.engine.is_unloaded(self.number) {
                // It was loaded again before it slept.
                return;
            }
            self.dismiss();
            // Its exports are no longer valid.
            self.engine.variables.retract_exports(self.number);
        }
    }

    pub(super) fn lie_down(&mut self) -> Result<(), String> {
        match std::mem::replace(&mut self.life, Life::Changing) {
            Life::Awake { mut instance, .. } => {
                let result = instance.sleep();
                if self.told.kind == Turn::SLEPT {
                    self.told.looked = instance.called(&mut self.told, &mut self.beyond);
                }
                self.engine.meters[self.number].pause();
                self.life = Life::Slept(instance);
                result
            }
            other => {
                self.life = other;
                Ok(())
            }
        }
    }

    /// Handles a failed call. The instance is not trusted any more, and the next awakening creates a new one.
    /// A build on trial is replaced by the one before instead, which continues as if nothing had happened.
    pub(super) fn fault(&mut self, reason: String) {
        if self.go_back(&reason) {
            return;
        }
        // The level selects again before the broken instance is called for its sleep.
        if self.is_to_tell() {
            self.told.failed = self.engine.faulted(self.number, reason);
        }
        self.give_up();
    }

    /// Ends an instance that faulted.
    pub(super) fn give_up(&mut self) {
        if let Err(reason) = self.lie_down() {
            tracing::error!(
                schema = self.engine.name(self.number),
                "also failed while going to sleep: {reason}"
            );
        }
        // What it exported while it fell asleep is no more valid than its earlier exports.
        self.engine.variables.retract_exports(self.number);
        self.dismiss();
    }

    pub(super) fn dismiss(&mut self) {
        // The next instance starts without a record of lateness, and so does its health.
        self.late = [false; 2];
        self.pass();
        let left = self.engine.panels.went(self.number, self.engine.clock.now());
        self.engine.untouched(self.number, left);
        self.life = match std::mem::replace(&mut self.life, Life::Changing) {
            // Dropping the instance ends it.
            Life::Slept(_) | Life::Awake { .. } => Life::Absent,
            other => other,
        };
    }
}
