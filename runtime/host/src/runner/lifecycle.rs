//! Transitions of an instance between its turns: awakening, falling asleep, unloading, failing and being
//! given up.

use jde_core::Nanos;
use jde_loader::build;
use jde_records::turn::TurnKind;

use super::Runner;
use super::deadlines::{Deadlines, Lateness};
use super::phase::{Installed, Phase};
use crate::instance::Instance;

impl Runner {
    /// Wakes the instance, which the rules woke at `woken`.
    pub(super) fn wake_up(&mut self, woken: Nanos) {
        // The rules woke it before it was unloaded, and it has slept since then; or it slept and woke while
        // the application was closing, and the signal to sleep was withheld.
        if self.engine.operators.is_unloaded(self.number) || self.phase.is_awake() {
            return;
        }
        // Its process died since, and the rules know it: its restart wakes it again.
        if self.engine.rules.is_faulted(self.number) {
            return;
        }
        let installed = match self.phase.take() {
            Some((installed, _)) => installed,
            None => match self.create() {
                Ok(installed) => installed,
                Err(reason) => return self.fault(reason),
            },
        };
        let now = self.engine.clock.now();
        let early = self.engine.stagger(self.number);
        let deadlines = Deadlines::of_awakening(woken, early, self.period, now);
        self.record.begin(TurnKind::Awoke);
        // One of before its sleep.
        self.engine.end_turn_request(self.number);
        self.engine.variables.open_exports(self.number);
        let result;
        (self.phase, result) = installed.wake_up(deadlines, now);
        self.record_look();
        if let Err(reason) = result {
            self.fault(reason);
        }
        self.record.finish();
    }

    /// Puts the instance to sleep, if it is awake.
    pub(crate) fn fall_asleep(&mut self) {
        let Some((installed, awake)) = self.phase.take_awake() else {
            return;
        };
        self.record.begin(TurnKind::Slept);
        let result = self.put_to_sleep(installed);
        self.record_look();
        if let Err(reason) = result
            && !self.roll_back(&reason)
        {
            self.report_fault(reason);
            self.end_instance();
        }
        self.record.finish();
        if awake.unloading {
            self.finish_unload();
        }
    }

    /// Ends the instance, now or when it sleeps. The next awakening creates a new one.
    pub(crate) fn unload(&mut self) {
        match self.phase.awake() {
            Some(awake) => awake.unloading = true,
            None => self.finish_unload(),
        }
    }

    fn finish_unload(&mut self) {
        // Otherwise it was loaded again before it slept.
        if self.engine.operators.is_unloaded(self.number) {
            self.end_instance();
            // Its exports are no longer valid.
            self.engine.variables.retract_exports(self.number);
        }
    }

    fn put_to_sleep(&mut self, installed: Installed) -> Result<(), String> {
        let result;
        (self.phase, result) = installed.sleep();
        self.engine.metrics[self.number].pause();
        self.engine.end_values(self.number);
        result
    }

    /// Handles a failed call. The instance is not trusted any more, and the next awakening creates a new one.
    /// A build on trial is replaced by the previous one instead, which continues without a fault.
    pub(crate) fn fault(&mut self, reason: String) {
        if self.roll_back(&reason) {
            return;
        }
        // The level selects again before the broken instance is called for its sleep.
        self.report_fault(reason);
        self.give_up();
    }

    /// Ends an instance that faulted.
    pub(crate) fn give_up(&mut self) {
        if let Some((installed, _)) = self.phase.take_awake()
            && let Err(reason) = self.put_to_sleep(installed)
        {
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
        self.lateness = Lateness::default();
        self.lacks_value = false;
        self.end_trial();
        let now = self.engine.clock.now();
        let undelivered = self.engine.panels.remove_instance(self.number, now);
        self.engine.report_undelivered(self.number, undelivered);
        // Dropping the instance ends it.
        self.phase = Phase::Absent;
    }

    /// Handles a failed call whose failure is no fault by itself. Its process may have died in it, which is
    /// reported to the rules once, like any failure.
    pub(super) fn handle_failed_call(&mut self, reason: &str) {
        let is_dead = self.phase.instance().is_some_and(|instance| instance.is_dead());
        if is_dead && !self.roll_back(reason) && self.claim_failure_report() {
            self.engine.report_death(self.number, reason.to_owned());
        }
    }

    fn report_fault(&mut self, reason: String) {
        if self.claim_failure_report() {
            self.record.turn.failed = self.engine.report_fault(self.number, reason);
        }
    }

    /// Whether the rules must still be informed of a failure. False after they were informed of the death of
    /// the process.
    fn claim_failure_report(&mut self) -> bool {
        let instance = self.phase.instance();
        instance.is_none_or(|instance| instance.claim_failure_report())
    }

    /// Creates an instance of the build in force, asleep.
    pub(super) fn create(&self) -> Result<Installed, String> {
        let instance = self.create_instance(&self.engine.builds.current(self.number))?;
        self.engine.declare_panel(self.number, instance.panel());
        self.engine.panels.add_instance(self.number);
        Ok(Installed {
            instance,
            trial: None,
        })
    }

    /// Creates an instance of that build with this runner's ports.
    pub(super) fn create_instance(&self, build: &build::SharedBuild) -> Result<Instance, String> {
        self.engine.check_can_create(self.number)?;
        Instance::create(&self.engine, self.number, build, &self.port_access)
    }
}
