//! An instance's life between its turns: it awakes and falls asleep, is unloaded, fails and is let go of.

use jde_core::Nanos;

use super::{Life, Runner};
use crate::turn::Turn;

impl Runner {
    /// The rules woke it then.
    pub(super) fn wake_up(&mut self, woken: Nanos) {
        // It was woken before it was unloaded, and is asleep again since.
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
            // It slept and woke while the application was closing, when nobody told it of the first.
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

    /// Ends the instance, now or when it sleeps; the next awakening makes a fresh one.
    pub(super) fn unload(&mut self) {
        self.unloading = true;
        self.put_away();
    }

    pub(super) fn put_away(&mut self) {
        if self.unloading && !matches!(self.life, Life::Awake { .. }) {
            self.unloading = false;
            if !self.engine.is_unloaded(self.number) {
                // Somebody let go of it before it slept.
                return;
            }
            self.dismiss();
            // What it exported nobody vouches for any more.
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

    /// A call failed: nothing of the instance is trusted any more, the next awakening makes a fresh one. A build on trial gives way
    /// to the one before instead, which goes on as if nothing had happened.
    pub(super) fn fault(&mut self, reason: String) {
        if self.go_back(&reason) {
            return;
        }
        // The level selects again before anything else is tried with what is broken.
        if self.is_to_tell() {
            self.told.failed = self.engine.faulted(self.number, reason);
        }
        self.give_up();
    }

    /// Lets go of an instance that faulted.
    pub(super) fn give_up(&mut self) {
        if let Err(reason) = self.lie_down() {
            tracing::error!(
                schema = self.engine.name(self.number),
                "also failed while going to sleep: {reason}"
            );
        }
        // What it exported on its way to sleep nobody vouches for any more than for what was before.
        self.engine.variables.retract_exports(self.number);
        self.dismiss();
    }

    pub(super) fn dismiss(&mut self) {
        // The next instance begins with a clean sheet, and so does its health.
        self.late = [false; 2];
        self.pass();
        let left = self.engine.panels.went(self.number, self.engine.clock.now());
        self.engine.untouched(self.number, left);
        self.life = match std::mem::replace(&mut self.life, Life::Changing) {
            // Dropped, it ends.
            Life::Slept(_) | Life::Awake { .. } => Life::Absent,
            other => other,
        };
    }
}
