//! Replaces the running instance by one of another build, and restores it if the new one fails on trial.
//!
//! Both builds share one access to the ports and are called in turn on one thread, so they never write the
//! same variable at the same time.

use std::sync::Arc;
use std::time::Instant;

use jde_core::Nanos;
use jde_loader::instance::SavedMemory;
use jde_records::reload::{CarriedMemory, Replacement};
use jde_records::turn::{Exchange, TurnKind};

use super::Runner;
use super::deadlines::Lateness;
use super::phase::{Awake, Installed, Phase};
use super::trial::{Trial, resume};
use crate::instance::Instance;
use crate::reload::Swap;

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
                let takeover = Replacement {
                    build: swap.build.name.clone(),
                    carried,
                    gap: self.phase.is_awake().then(|| now.saturating_sub(self.last_turn)),
                    took,
                    probation: match self.phase.trial() {
                        Some(_) => swap.options.probation,
                        None => 0,
                    },
                    notes: swap.notes.clone(),
                };
                self.record.forward_swap(Exchange::New, now);
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
        let Some(trial) = self.phase.take_trial() else {
            return false;
        };
        if std::mem::take(&mut self.takeover_pending) {
            let failed = Err(reason.to_owned());
            self.engine.builds.finish_swap(self.number, failed);
        }
        self.engine.roll_back_build(self.number, reason);
        let Some((failed, awake)) = self.phase.take() else {
            return false;
        };
        let mut failed = failed.instance;
        if awake.is_some() {
            self.sleep_for_swap(&mut failed);
        }
        drop(failed);
        let resumed = trial.roll_back(awake.is_some(), |build| self.create_instance(build));
        let result = resumed.and_then(|(previous, result)| {
            self.install(previous, None, awake);
            let now = self.engine.clock.now();
            self.record.forward_swap(Exchange::Before, now);
            result
        });
        if let Err(reason) = &result {
            tracing::error!(
                schema = self.engine.name(self.number),
                "the build before cannot go on either: {reason}"
            );
        }
        result.is_ok()
    }

    /// Ends the trial, if there is one: the current build stays.
    pub(super) fn end_trial(&mut self) {
        if self.phase.take_trial().is_some() {
            self.engine.builds.end_trial(self.number);
        }
    }

    fn try_swap(&mut self, swap: &Swap) -> Result<Option<CarriedMemory>, String> {
        let Some((previous, awake)) = self.phase.take() else {
            return self.start_build(swap).map(|()| None);
        };
        let mut previous = previous.instance;
        match self.create_successor(&mut previous, swap, awake.is_some()) {
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
                let trial = on_trial.then(|| {
                    let previous = successor.can_roll_back.then_some(previous);
                    let until = self.engine.clock.now().saturating_add(swap.options.probation);
                    Trial::start(build, previous, successor.saved_memory, until)
                });
                self.install(successor.instance, trial, awake);
                Ok(carried)
            }
            Err(SwapError { reason, fault }) => {
                let installed = Installed {
                    instance: previous,
                    trial: None,
                };
                self.phase = Phase::new(installed, awake);
                if let Some(fault) = fault {
                    self.record.begin(TurnKind::Cycled(None));
                    self.fault(fault);
                    self.record.finish();
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
            .map_err(|reason| refused(cannot_create(&reason)))?;
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

    /// Starts a build where there was no instance, after a fault or an unloading. A rollback is not possible.
    fn start_build(&mut self, swap: &Swap) -> Result<(), String> {
        let instance = if self.engine.operators.is_unloaded(self.number) {
            None
        } else {
            let created = self.create_instance(&swap.build);
            Some(created.map_err(|reason| cannot_create(&reason))?)
        };
        let build = Arc::clone(&swap.build);
        self.engine.builds.record_replacement(self.number, build, None);
        if let Some(instance) = instance {
            self.install(instance, None, None);
            self.engine.rules.report_restored(self.number);
        }
        Ok(())
    }

    /// Installs an instance as the schema's, with a turn at once if it is awake.
    fn install(&mut self, instance: Instance, trial: Option<Trial>, mut awake: Option<Awake>) {
        self.engine.declare_panel(self.number, instance.panel());
        self.engine.panels.add_instance(self.number);
        self.lateness = Lateness::default();
        self.lacks_value = false;
        if let Some(awake) = &mut awake {
            awake.is_due_at_once = true;
            awake.deadlines.add(self.engine.clock.now());
        }
        self.phase = Phase::new(Installed { instance, trial }, awake);
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
}

fn cannot_create(reason: &str) -> String {
    format!("it cannot be made: {reason}")
}
