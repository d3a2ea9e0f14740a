//! Replaces the running instance by one of another build, and restores it if the new one fails on trial.
//!
//! The build before is put to sleep and not ended until the trial is over. Unless it failed in that, going
//! back only wakes it up, which needs no resources. Both are at one desk and are called one after the other
//! on one thread, so that two never write what belongs to one.

use std::sync::Arc;
use std::time::Instant;

use jde_core::Nanos;

use super::{Life, Runner};
use crate::build;
use crate::instance::{Instance, Remembered};
use crate::reload::{Carried, LEAST_TURNS, Swap, Takeover};
use crate::turn::{Call, Turn};

/// A build on trial, with what is needed to go back.
pub(super) struct Trial {
    before: build::Shared,
    /// The instance that ran before, asleep; `None` if it failed while going to sleep.
    kept: Option<Instance>,
    remembered: Option<Remembered>,
    until: Nanos,
    turns: u32,
}

/// Why a build could not take over.
struct Refused {
    reason: String,
    /// Why the build before cannot continue either, if it cannot.
    fault: Option<String>,
}

/// A build that took over from another.
struct Heir {
    instance: Instance,
    remembered: Option<Remembered>,
    carried: bool,
    /// Whether the instance before can be used to go back.
    kept: bool,
}

impl Runner {
    /// Puts another build in the place of the present one.
    pub(super) fn swap(&mut self, swap: &Swap) {
        // A build on trial becomes the one to go back to.
        self.pass();
        let start = Instant::now();
        let result = self.exchange(swap);
        let took = start.elapsed().as_nanos().try_into().unwrap_or(Nanos::MAX);
        match result {
            Ok(carried) => {
                let now = self.engine.clock.now();
                let awake = matches!(self.life, Life::Awake { .. });
                let takeover = Takeover {
                    build: swap.build.name.clone(),
                    carried,
                    gap: awake.then(|| now.saturating_sub(self.last_turn)),
                    took,
                    probation: if self.trial.is_some() {
                        swap.how.probation
                    } else {
                        0
                    },
                    notes: swap.notes.clone(),
                };
                self.tell_swap(Turn::TOOK_OVER);
                self.engine.reloaded(self.number, &takeover);
                self.engine.builds.announce(self.number, takeover);
                self.announced = true;
            }
            Err(reason) => {
                self.engine.not_reloaded(self.number, &swap.build.name, &reason);
                self.engine.builds.settle(self.number, Err(reason));
            }
        }
    }

    /// Goes back to the build before if the present one is on trial. Returns whether that build continues, so
    /// that the level need not be informed.
    pub(super) fn go_back(&mut self, reason: &str) -> bool {
        let Some(trial) = self.trial.take() else {
            return false;
        };
        if std::mem::take(&mut self.announced) {
            self.engine.builds.settle(self.number, Err(reason.to_owned()));
        }
        self.engine.give_up_build(self.number, reason);
        let (mut failed, awake) = match std::mem::replace(&mut self.life, Life::Changing) {
            Life::Slept(instance) => (instance, false),
            Life::Awake { instance, .. } => (instance, true),
            other @ (Life::Absent | Life::Changing) => {
                self.life = other;
                return false;
            }
        };
        if awake {
            self.lay_down(&mut failed);
        }
        drop(failed);
        let before = trial.kept.map_or_else(|| self.instance_of(&trial.before), Ok);
        let mut before = match before {
            Ok(before) => before,
            Err(reason) => {
                self.life = Life::Absent;
                return self.is_lost(&reason);
            }
        };
        let back = resume(&mut before, awake, trial.remembered.as_ref());
        self.seat(before, awake);
        self.tell_swap(Turn::WENT_BACK);
        match back {
            Ok(_) => true,
            Err(reason) => self.is_lost(&reason),
        }
    }

    /// Ends a turn: a takeover in it has succeeded so far, and a trial may be over.
    pub(super) fn end_turn(&mut self, looked: bool) {
        if looked {
            self.last_turn = self.engine.clock.now();
        }
        if std::mem::take(&mut self.announced) {
            self.engine.builds.settle(self.number, Ok(()));
        }
        if std::mem::take(&mut self.at_once)
            && let Life::Awake { due, .. } = &mut self.life
        {
            // In addition to its deadlines, which stay where they are.
            *due = self.engine.clock.now();
        }
        if let Some(trial) = &mut self.trial {
            trial.turns += u32::from(looked);
            if trial.turns >= LEAST_TURNS && self.engine.clock.now() >= trial.until {
                self.pass();
            }
        }
    }

    /// Ends the trial, if there is one: the present build stays.
    pub(super) fn pass(&mut self) {
        if self.trial.take().is_some() {
            self.engine.builds.passed(self.number);
        }
    }

    fn exchange(&mut self, swap: &Swap) -> Result<Option<Carried>, String> {
        let (mut before, due) = match std::mem::replace(&mut self.life, Life::Changing) {
            Life::Slept(before) => (before, None),
            Life::Awake { instance, due } => (instance, Some(due)),
            Life::Absent => {
                self.life = Life::Absent;
                return self.begin_with(swap).map(|()| None);
            }
            Life::Changing => return Err("it is between two states of its life".to_owned()),
        };
        let awake = due.is_some();
        match self.succeed(&mut before, swap, awake) {
            Ok(heir) => {
                let carried = heir.remembered.as_ref().filter(|_| heir.carried);
                let carried = carried.map(|remembered| Carried {
                    version: remembered.version,
                    bytes: remembered.bytes.len(),
                });
                let build = Arc::clone(before.build());
                let on_trial = swap.how.probation > 0;
                self.engine.builds.took_over(
                    self.number,
                    Arc::clone(&swap.build),
                    on_trial.then(|| Arc::clone(&build)),
                );
                self.trial = on_trial.then(|| Trial {
                    before: build,
                    kept: heir.kept.then_some(before),
                    remembered: heir.remembered,
                    until: self.engine.clock.now().saturating_add(swap.how.probation),
                    turns: 0,
                });
                self.seat(heir.instance, awake);
                Ok(carried)
            }
            Err(Refused { reason, fault }) => {
                self.life = match due {
                    Some(due) => Life::Awake {
                        instance: before,
                        due,
                    },
                    None => Life::Slept(before),
                };
                if let Some(fault) = fault {
                    self.told = Turn::of(Turn::CYCLED, self.number);
                    self.fault(fault);
                    self.tell();
                }
                Err(reason)
            }
        }
    }

    /// Creates an instance of the new build with the memory of the one before, which then sleeps. After a
    /// refusal the one before is as it was, unless the refusal has a fault.
    fn succeed(&self, before: &mut Instance, swap: &Swap, awake: bool) -> Result<Heir, Refused> {
        let refused = |reason| Refused { reason, fault: None };
        let remembered = if swap.how.fresh {
            None
        } else {
            let cannot = |reason| {
                refused(format!(
                    "the present build cannot save what it remembers: {reason}"
                ))
            };
            before.save().map_err(cannot)?
        };
        let mut heir = self
            .instance_of(&swap.build)
            .map_err(|reason| refused(format!("it cannot be made: {reason}")))?;
        let kept = !awake || self.lay_down(before);
        match resume(&mut heir, awake, remembered.as_ref()) {
            Ok(carried) => Ok(Heir {
                instance: heir,
                remembered,
                carried,
                kept,
            }),
            Err(reason) => {
                if awake {
                    self.lay_down(&mut heir);
                }
                drop(heir);
                let fault = awake.then(|| resume(before, awake, remembered.as_ref()).err());
                Err(Refused {
                    reason,
                    fault: fault.flatten(),
                })
            }
        }
    }

    /// Starts a build where there was no instance, after a fault or an unloading. There is nothing better to
    /// go back to.
    fn begin_with(&mut self, swap: &Swap) -> Result<(), String> {
        if self.engine.is_unloaded(self.number) {
            self.engine
                .builds
                .took_over(self.number, Arc::clone(&swap.build), None);
            return Ok(());
        }
        let instance = self
            .instance_of(&swap.build)
            .map_err(|reason| format!("it cannot be made: {reason}"))?;
        self.engine
            .builds
            .took_over(self.number, Arc::clone(&swap.build), None);
        self.seat(instance, false);
        self.engine.restored(self.number);
        Ok(())
    }

    /// Installs an instance as the schema's, with a turn at once if it is awake.
    fn seat(&mut self, instance: Instance, awake: bool) {
        self.engine.declare_panel(self.number, instance.panel());
        self.engine.panels.came(self.number);
        self.late = [false; 2];
        self.at_once = awake;
        self.life = if awake {
            let due = self.engine.clock.now();
            Life::Awake { instance, due }
        } else {
            Life::Slept(instance)
        };
    }

    /// Puts an instance to sleep for another. Returns whether it can wake up again.
    fn lay_down(&self, instance: &mut Instance) -> bool {
        let slept = instance.recline();
        if let Err(reason) = &slept {
            tracing::error!(
                schema = self.engine.name(self.number),
                "failed while another build took its place: {reason}"
            );
        }
        slept.is_ok()
    }

    /// Logs that the build before cannot continue either.
    fn is_lost(&self, reason: &str) -> bool {
        tracing::error!(
            schema = self.engine.name(self.number),
            "the build before cannot go on either: {reason}"
        );
        false
    }

    /// Records for replays that another build takes the turns from here on.
    fn tell_swap(&self, way: u8) {
        if let Some(journal) = &self.journal {
            let now = self.engine.clock.now();
            journal.tell(&Turn {
                way,
                looked: Call {
                    after: journal.last(),
                    time: now,
                    clock: now,
                },
                ..Turn::of(Turn::RELOADED, self.number)
            });
        }
    }
}

/// Continues where another instance left off. Returns whether the saved memory was taken over.
fn resume(instance: &mut Instance, awake: bool, remembered: Option<&Remembered>) -> Result<bool, String> {
    if awake {
        instance.rise()?;
    }
    // Last, so that waking up does not erase it.
    match remembered {
        Some(remembered) => instance
            .restore(remembered)
            .map_err(|reason| format!("it refuses what was remembered: {reason}")),
        None => Ok(false),
    }
}
