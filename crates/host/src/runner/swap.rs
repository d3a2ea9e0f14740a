//! Replaces the running instance by one of another build, and restores it if the new one fails on trial.
//!
//! The previous build is put to sleep and not ended until the trial is over. Unless it fails to go to sleep,
//! a rollback only wakes it up, which needs no resources. Both builds share one access to the ports and are
//! called in turn on one thread, so they never write the same variable at the same time.

use std::sync::Arc;
use std::time::Instant;

use jde_core::Nanos;
use jde_loader::build;
use jde_loader::instance::SavedMemory;
use jde_records::reload::{CarriedMemory, Replacement};
use jde_records::turn::{Call, Turn};

use super::{InstanceState, Runner};
use crate::instance::Instance;
use crate::reload::{MIN_TRIAL_TURNS, Swap};

/// A build on trial, with the data for a rollback.
pub(super) struct Trial {
    previous_build: build::SharedBuild,
    /// The instance that ran before, asleep; `None` if it failed while going to sleep.
    previous_instance: Option<Instance>,
    saved_memory: Option<SavedMemory>,
    until: Nanos,
    turns: u32,
}

/// Why a build could not take over.
struct SwapError {
    reason: String,
    /// Why the previous build cannot continue either, if it cannot.
    fault: Option<String>,
}

/// A build that took over from another.
struct Successor {
    instance: Instance,
    saved_memory: Option<SavedMemory>,
    is_restored: bool,
    /// Whether the previous instance can be used for a rollback.
    can_roll_back: bool,
}

impl Runner {
    /// Replaces the current build by another one.
    pub(super) fn swap(&mut self, swap: &Swap) {
        // A build on trial becomes the one for a rollback.
        self.end_trial();
        let start = Instant::now();
        let result = self.try_swap(swap);
        let took = start.elapsed().as_nanos().try_into().unwrap_or(Nanos::MAX);
        match result {
            Ok(carried) => {
                let now = self.engine.clock.now();
                let awake = matches!(self.state, InstanceState::Awake { .. });
                let takeover = Replacement {
                    build: swap.build.name.clone(),
                    carried,
                    gap: awake.then(|| now.saturating_sub(self.last_turn)),
                    took,
                    probation: if self.trial.is_some() {
                        swap.options.probation
                    } else {
                        0
                    },
                    notes: swap.notes.clone(),
                };
                self.record_swap(Turn::TOOK_OVER);
                self.engine.report_reload(self.number, &takeover);
                self.engine.builds.mark_done(self.number, takeover);
                self.takeover_pending = true;
            }
            Err(reason) => {
                self.engine
                    .report_reload_failure(self.number, &swap.build.name, &reason);
                self.engine.builds.finish_swap(self.number, Err(reason));
            }
        }
    }

    /// Goes back to the previous build if the current one is on trial. Returns whether that build continues;
    /// then the level need not be informed.
    pub(super) fn roll_back(&mut self, reason: &str) -> bool {
        let Some(trial) = self.trial.take() else {
            return false;
        };
        if std::mem::take(&mut self.takeover_pending) {
            self.engine
                .builds
                .finish_swap(self.number, Err(reason.to_owned()));
        }
        self.engine.roll_back_build(self.number, reason);
        let (mut failed, awake) = match std::mem::replace(&mut self.state, InstanceState::Changing) {
            InstanceState::Slept(instance) => (instance, false),
            InstanceState::Awake { instance, .. } => (instance, true),
            other @ (InstanceState::Absent | InstanceState::Changing) => {
                self.state = other;
                return false;
            }
        };
        if awake {
            self.sleep_for_swap(&mut failed);
        }
        drop(failed);
        let previous = trial
            .previous_instance
            .map_or_else(|| self.create_instance(&trial.previous_build), Ok);
        let mut previous = match previous {
            Ok(previous) => previous,
            Err(reason) => {
                self.state = InstanceState::Absent;
                return self.log_rollback_failure(&reason);
            }
        };
        let result = resume(&mut previous, awake, trial.saved_memory.as_ref());
        self.install(previous, awake);
        self.record_swap(Turn::ROLLED_BACK);
        match result {
            Ok(_) => true,
            Err(reason) => self.log_rollback_failure(&reason),
        }
    }

    /// Ends a turn: a takeover in it has succeeded so far, and a trial may be over.
    pub(super) fn end_turn(&mut self, has_run: bool) {
        if has_run {
            self.last_turn = self.engine.clock.now();
        }
        if std::mem::take(&mut self.takeover_pending) {
            self.engine.builds.finish_swap(self.number, Ok(()));
        }
        if std::mem::take(&mut self.is_due_at_once)
            && let InstanceState::Awake { due, .. } = &mut self.state
        {
            // In addition to its deadlines, which stay where they are.
            *due = self.engine.clock.now();
        }
        if let Some(trial) = &mut self.trial {
            trial.turns += u32::from(has_run);
            if trial.turns >= MIN_TRIAL_TURNS && self.engine.clock.now() >= trial.until {
                self.end_trial();
            }
        }
    }

    /// Ends the trial, if there is one: the current build stays.
    pub(super) fn end_trial(&mut self) {
        if self.trial.take().is_some() {
            self.engine.builds.end_trial(self.number);
        }
    }

    fn try_swap(&mut self, swap: &Swap) -> Result<Option<CarriedMemory>, String> {
        let (mut previous, due) = match std::mem::replace(&mut self.state, InstanceState::Changing) {
            InstanceState::Slept(previous) => (previous, None),
            InstanceState::Awake { instance, due } => (instance, Some(due)),
            InstanceState::Absent => {
                self.state = InstanceState::Absent;
                return self.start_build(swap).map(|()| None);
            }
            InstanceState::Changing => return Err("it is between two states of its life".to_owned()),
        };
        let awake = due.is_some();
        match self.create_successor(&mut previous, swap, awake) {
            Ok(successor) => {
                let carried = successor.saved_memory.as_ref().filter(|_| successor.is_restored);
                let carried = carried.map(|memory| CarriedMemory {
                    version: memory.version,
                    bytes: memory.bytes.len(),
                });
                let build = Arc::clone(previous.build());
                let on_trial = swap.options.probation > 0;
                self.engine.builds.record_replacement(
                    self.number,
                    Arc::clone(&swap.build),
                    on_trial.then(|| Arc::clone(&build)),
                );
                self.trial = on_trial.then(|| Trial {
                    previous_build: build,
                    previous_instance: successor.can_roll_back.then_some(previous),
                    saved_memory: successor.saved_memory,
                    until: self.engine.clock.now().saturating_add(swap.options.probation),
                    turns: 0,
                });
                self.install(successor.instance, awake);
                Ok(carried)
            }
            Err(SwapError { reason, fault }) => {
                self.state = match due {
                    Some(due) => InstanceState::Awake {
                        instance: previous,
                        due,
                    },
                    None => InstanceState::Slept(previous),
                };
                if let Some(fault) = fault {
                    self.turn_record = Turn::new(Turn::CYCLED, self.number);
                    self.fault(fault);
                    self.record_turn();
                }
                Err(reason)
            }
        }
    }

    /// Creates an instance of the new build with the memory of the previous one, which then sleeps. After a
    /// refusal the previous one is as before, unless the refusal has a fault.
    fn create_successor(
        &self,
        previous: &mut Instance,
        swap: &Swap,
        awake: bool,
    ) -> Result<Successor, SwapError> {
        let refused = |reason| SwapError { reason, fault: None };
        let memory = if swap.options.fresh {
            None
        } else {
            let cannot_save = |reason| {
                refused(format!(
                    "the present build cannot save what it remembers: {reason}"
                ))
            };
            previous.save().map_err(cannot_save)?
        };
        let mut successor = self
            .create_instance(&swap.build)
            .map_err(|reason| refused(format!("it cannot be made: {reason}")))?;
        let can_roll_back = !awake || self.sleep_for_swap(previous);
        match resume(&mut successor, awake, memory.as_ref()) {
            Ok(is_restored) => Ok(Successor {
                instance: successor,
                saved_memory: memory,
                is_restored,
                can_roll_back,
            }),
            Err(reason) => {
                if awake {
                    self.sleep_for_swap(&mut successor);
                }
                drop(successor);
                let fault = awake.then(|| resume(previous, awake, memory.as_ref()).err());
                Err(SwapError {
                    reason,
                    fault: fault.flatten(),
                })
            }
        }
    }

    /// Starts a build where there was no instance, after a fault or an unloading. A
    /// rollback is not possible.
    fn start_build(&mut self, swap: &Swap) -> Result<(), String> {
        if self.engine.is_unloaded(self.number) {
            self.engine
                .builds
                .record_replacement(self.number, Arc::clone(&swap.build), None);
            return Ok(());
        }
        let instance = self
            .create_instance(&swap.build)
            .map_err(|reason| format!("it cannot be made: {reason}"))?;
        self.engine
            .builds
            .record_replacement(self.number, Arc::clone(&swap.build), None);
        self.install(instance, false);
        self.engine.rules.report_restored(self.number);
        Ok(())
    }

    /// Installs an instance as the schema's, with a turn at once if it is awake.
    fn install(&mut self, instance: Instance, awake: bool) {
        self.engine.declare_panel(self.number, instance.panel());
        self.engine.panels.add_instance(self.number);
        self.late = [false; 2];
        self.is_due_at_once = awake;
        self.state = if awake {
            let due = self.engine.clock.now();
            InstanceState::Awake { instance, due }
        } else {
            InstanceState::Slept(instance)
        };
    }

    /// Puts an instance to sleep for another. Returns whether it can wake up again.
    fn sleep_for_swap(&self, instance: &mut Instance) -> bool {
        let slept = instance.sleep_in_place();
        if let Err(reason) = &slept {
            tracing::error!(
                schema = self.engine.name(self.number),
                "failed while another build took its place: {reason}"
            );
        }
        slept.is_ok()
    }

    /// Logs that the previous build cannot continue either. Returns false.
    fn log_rollback_failure(&self, reason: &str) -> bool {
        tracing::error!(
            schema = self.engine.name(self.number),
            "the build before cannot go on either: {reason}"
        );
        false
    }

    /// Records for replays that another build takes the turns from now on.
    fn record_swap(&self, way: u8) {
        if let Some(journal) = &self.journal {
            let now = self.engine.clock.now();
            journal.forward(&Turn {
                way,
                looked: Call {
                    after: journal.last(),
                    time: now,
                    clock: now,
                },
                ..Turn::new(Turn::RELOADED, self.number)
            });
        }
    }
}

/// Continues where another instance left off. Returns whether the saved memory was taken over.
fn resume(instance: &mut Instance, awake: bool, memory: Option<&SavedMemory>) -> Result<bool, String> {
    if awake {
        instance.awake_in_place()?;
    }
    // Last, so that waking up does not erase it.
    match memory {
        Some(memory) => instance
            .restore(memory)
            .map_err(|reason| format!("it refuses what was remembered: {reason}")),
        None => Ok(false),
    }
}
