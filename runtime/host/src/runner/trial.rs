//! A build on trial: it survives, or the previous build continues.
//!
//! The previous instance is put to sleep and not ended until the trial is over. Unless it fails to go to
//! sleep, a rollback only wakes it up, which needs no resources.

use jde_core::Nanos;
use jde_loader::build;
use jde_loader::instance::SavedMemory;

use crate::instance::Instance;
use crate::reload::MIN_TRIAL_TURNS;

/// A build on trial, with the data for a rollback.
pub(super) struct Trial {
    previous_build: build::SharedBuild,
    /// The instance that ran before, asleep; `None` if it failed while going to sleep.
    previous_instance: Option<Instance>,
    saved_memory: Option<SavedMemory>,
    probation: Probation,
}

/// How long a trial lasts.
struct Probation {
    until: Nanos,
    turns: u32,
}

impl Trial {
    /// Starts a trial of the build that took over from `previous`.
    pub(super) fn start(
        previous_build: build::SharedBuild,
        previous_instance: Option<Instance>,
        saved_memory: Option<SavedMemory>,
        until: Nanos,
    ) -> Self {
        Self {
            previous_build,
            previous_instance,
            saved_memory,
            probation: Probation { until, turns: 0 },
        }
    }

    /// Counts a turn, if one was taken. Returns whether the build has survived the trial.
    pub(super) fn survive(&mut self, has_run: bool, now: Nanos) -> bool {
        self.probation.survive(has_run, now)
    }

    /// Returns to the previous build: its instance, and whether that instance can continue.
    pub(super) fn roll_back(
        self,
        awake: bool,
        create: impl FnOnce(&build::SharedBuild) -> Result<Instance, String>,
    ) -> Result<(Instance, Result<bool, String>), String> {
        let mut previous = match self.previous_instance {
            Some(previous) => previous,
            None => create(&self.previous_build)?,
        };
        let result = resume(&mut previous, awake, self.saved_memory.as_ref());
        Ok((previous, result))
    }
}

impl Probation {
    fn survive(&mut self, has_run: bool, now: Nanos) -> bool {
        self.turns += u32::from(has_run);
        self.turns >= MIN_TRIAL_TURNS && now >= self.until
    }
}

/// Continues where another instance left off. Returns whether the saved memory was taken over.
pub(super) fn resume(
    instance: &mut Instance,
    awake: bool,
    memory: Option<&SavedMemory>,
) -> Result<bool, String> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_lasts_its_time_and_a_number_of_turns() {
        let mut probation = Probation { until: 100, turns: 0 };
        for _ in 1..MIN_TRIAL_TURNS {
            assert!(!probation.survive(true, 200), "too few turns");
        }
        assert!(!probation.survive(false, 200), "no turn was taken");
        assert!(!probation.survive(true, 99), "too early");
        assert!(probation.survive(false, 100));
    }
}
