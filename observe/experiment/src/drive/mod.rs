//! One drive: the application in lockstep, from instant to instant; at each one the properties, measures and
//! steps see the values. It writes no file.

mod event_queue;
pub mod measure;
pub mod motion;
pub mod property;
mod situation;
pub mod step;
pub mod values;

use std::sync::Arc;

use jde_app::{Application, Faults};
use jde_core::{Health, Id, Nanos, SchemaId};
use jde_host::{Handle, Lockstep, Options, StartError};
use jde_loader::Plugins;
use jde_records::event::{Event, Outcome as RunOutcome, What};
use jde_sim::World;

use crate::applications::Applications;
use crate::experiment::{DriveSettings, Experiment, Mission};
use crate::result::{DriveResult, Outcome};
pub use event_queue::EventQueue;
use measure::{Measure, Meter};
use property::Monitor;
use situation::Situation;
use step::{Operator, StepTime};
use values::DriveValues;

/// The end of a drive's application.
struct Ending {
    outcome: RunOutcome,
    /// Whether the experiment's `end` became true.
    by_condition: bool,
}

/// A drive that is ready to start.
pub struct PreparedDrive {
    /// Its number.
    pub drive: usize,
    /// The application with its values.
    pub application: Application,
    /// The plugins against which it was checked.
    pub plugins: Arc<Plugins>,
    settings: DriveSettings,
}

impl PreparedDrive {
    /// Loads the application of a drive. A seed here takes the place of the drive's own.
    ///
    /// # Errors
    /// The faults of the application with the values of the drive.
    pub fn new(
        experiment: &Experiment,
        drive: usize,
        seed: Option<u64>,
        applications: &mut Applications,
    ) -> Result<Self, Faults> {
        let settings = experiment.settings(drive);
        let variant = &experiment.variants[settings.variant];
        let mut application = applications.load(&settings.overrides, variant)?;
        application.seed = seed.or(settings.seed).unwrap_or(application.seed);
        Ok(Self {
            drive,
            application,
            plugins: applications.plugins(variant),
            settings,
        })
    }

    /// Runs the drive, and returns its result. `options` may have observers and hooks of the caller's.
    ///
    /// # Errors
    /// Its application did not start.
    pub fn run(self, experiment: &Experiment, mut options: Options) -> Result<DriveResult, StartError> {
        let events = EventQueue::default();
        options.limit = Some(experiment.limit);
        options.mocks = experiment.mocks.clone();
        options.observers.push(Box::new(events.clone()));
        let lockstep = Lockstep::start(self.application, &self.plugins, options)?;
        Ok(
            DriveUnderWay::new(experiment, &self.settings, lockstep, events)
                .finish(self.drive, self.settings),
        )
    }
}

/// The result of a drive that could not begin, or whose process died.
#[must_use]
pub fn unjudged(experiment: &Experiment, drive: usize, outcome: Outcome, why: String) -> DriveResult {
    DriveResult {
        drive,
        axes: experiment.settings(drive).labels,
        outcome,
        end: String::new(),
        seconds: 0.0,
        properties: vec![None; experiment.columns.properties.len()],
        measures: vec![None; experiment.columns.measures.len()],
        why,
        failure: None,
    }
}

/// A drive under way.
struct DriveUnderWay<'e> {
    experiment: &'e Experiment,
    lockstep: Lockstep,
    events: EventQueue,
    values: DriveValues,
    monitors: Vec<Monitor>,
    meters: Vec<Meter>,
    /// The places of the steps that have not happened.
    steps: Vec<usize>,
    operator: Operator,
    situation: Situation,
    /// Why a step was refused.
    refused: Option<String>,
    /// The first takeover that took longer than its contract permits, in words.
    late: Option<String>,
    /// The first fault of a schema, in words.
    fault: Option<String>,
}

impl<'e> DriveUnderWay<'e> {
    fn new(
        experiment: &'e Experiment,
        settings: &DriveSettings,
        lockstep: Lockstep,
        events: EventQueue,
    ) -> Self {
        let handle = lockstep.handle();
        let case = experiment.case_of(settings);
        let is_of_case = |step: &usize| {
            let of = experiment.steps[*step].case.as_deref();
            of.is_none() || of == case
        };
        Self {
            values: DriveValues::new(&experiment.expressions, &handle),
            monitors: experiment.properties.iter().map(Monitor::new).collect(),
            meters: experiment.measures.iter().map(Meter::new).collect(),
            steps: (0..experiment.steps.len()).filter(is_of_case).collect(),
            operator: Operator::new(&handle),
            situation: Situation::new(handle.application()),
            refused: None,
            late: None,
            fault: None,
            experiment,
            lockstep,
            events,
        }
    }

    /// Runs to the end, and returns the result.
    fn finish(mut self, drive: usize, settings: DriveSettings) -> DriveResult {
        let ending = self.run();
        let handle = self.lockstep.handle();
        let now = handle.now();
        for monitor in &mut self.monitors {
            monitor.finish(now);
        }
        self.record_violations();
        let refused = self
            .refused
            .take()
            .or_else(|| self.operator.refused_edit(&handle));
        let slow = slow(&handle);
        drop(self.lockstep);
        // A schema may also fault when it falls asleep at the end.
        for event in self.events.take().0 {
            self.fault = self.fault.or_else(|| fault(handle.application(), &event));
        }
        let mut properties: Vec<_> = self
            .monitors
            .iter()
            .map(|monitor| Some(monitor.violation().is_none()))
            .collect();
        let mut reasons = Vec::new();
        for (name, monitor) in self.experiment.columns.properties.iter().zip(&self.monitors) {
            if let Some((at, why)) = monitor.violation() {
                reasons.push(format!("{name}: {why} at {:.3} s", at as f64 / 1e9));
            }
        }
        reasons.extend(self.late.take());
        reasons.extend(slow.filter(|_| self.experiment.judges_budgets));
        reasons.extend(self.fault.filter(|_| !self.experiment.ignores_faults));
        let is_done = matches!(ending.outcome, RunOutcome::Done);
        if self.experiment.mission == Mission::Required {
            properties.push(Some(is_done));
            if !is_done {
                reasons.push(format!(
                    "{} at {:.3} s",
                    mission_reason(&ending),
                    now as f64 / 1e9
                ));
            }
        }
        let mut outcome = match reasons.is_empty() {
            true => Outcome::Passed,
            false => Outcome::Failed,
        };
        if let Some(broken) = refused.or_else(|| broken(&ending.outcome)) {
            outcome = Outcome::Broken;
            reasons.insert(0, broken);
        }
        let is_success = outcome == Outcome::Passed;
        let mut motions = self.values.motions();
        if self
            .experiment
            .measures
            .iter()
            .any(Measure::needs_reference_length)
        {
            // The world was read when its robot's driver started.
            let world = self
                .experiment
                .world_of(drive)
                .and_then(|path| World::load(path, 0).ok());
            let length = world.and_then(|world| world.reference_length());
            motions
                .iter_mut()
                .for_each(|motion| motion.set_reference_length(length));
        }
        let measures = self.meters.into_iter();
        let measures = measures
            .map(|meter| meter.finish(now, is_success, &motions))
            .collect();
        DriveResult {
            drive,
            axes: settings.labels,
            outcome,
            end: end_word(&ending).to_owned(),
            seconds: now as f64 / 1e9,
            properties,
            measures,
            why: reasons.join("; "),
            failure: (!is_success).then(|| self.situation.into_failure(now)),
        }
    }

    fn run(&mut self) -> Ending {
        loop {
            let next = self.lockstep.next_instant().unwrap_or(Nanos::MAX);
            let next = self
                .timed_steps()
                .fold(next, Nanos::min)
                .min(self.experiment.limit);
            let outcome = self.lockstep.run_until(next);
            let by_condition = self.look(next);
            if let Some(outcome) = outcome {
                return Ending {
                    outcome,
                    by_condition: false,
                };
            }
            if by_condition || self.refused.is_some() {
                return Ending {
                    outcome: RunOutcome::Stopped,
                    by_condition,
                };
            }
        }
    }

    /// Returns the times of the steps that have not happened, ns.
    fn timed_steps(&self) -> impl Iterator<Item = Nanos> {
        self.steps
            .iter()
            .filter_map(|step| match self.experiment.steps[*step].when {
                StepTime::At(time) => Some(time),
                StepTime::When(_) => None,
            })
    }

    /// Judges and measures an instant, and takes the steps that are due. Returns whether `end` is true.
    fn look(&mut self, now: Nanos) -> bool {
        let (events, dropped) = self.events.take();
        if dropped > 0 {
            let lost = || format!("{dropped} events came too fast to be judged");
            self.refused.get_or_insert_with(lost);
        }
        for event in events {
            self.values.add_event(&event);
            let handle = self.lockstep.handle();
            if self.late.is_none() {
                self.late = late(handle.application(), &event);
            }
            self.situation.add_event(&event);
            if self.fault.is_none() {
                self.fault = fault(handle.application(), &event);
                if self.fault.is_some() && !self.experiment.ignores_faults {
                    self.situation.keep(event.time());
                }
            }
        }
        let values = self.values.update(now);
        for monitor in &mut self.monitors {
            monitor.observe(now, values);
        }
        for meter in &mut self.meters {
            meter.observe(now, values);
        }
        let is_true = |expression: usize| values[expression].is_some_and(|value| value != 0.0);
        let due = |step: &usize| match self.experiment.steps[*step].when {
            StepTime::At(time) => time <= now,
            StepTime::When(expression) => is_true(expression),
        };
        let by_condition = self.experiment.end.is_some_and(is_true);
        let (due, waiting) = std::mem::take(&mut self.steps)
            .into_iter()
            .partition::<Vec<_>, _>(due);
        self.steps = waiting;
        self.situation.add_pose(now, self.values.pose());
        self.record_violations();
        let mut acted = self.operator.repair(now);
        for step in due {
            acted = acted.and_then(|()| self.operator.perform(&self.experiment.steps[step], now));
        }
        if let Err(refused) = acted {
            self.refused.get_or_insert(refused);
        }
        by_condition
    }

    /// Keeps the situation of the first violation.
    fn record_violations(&mut self) {
        let first = self
            .monitors
            .iter()
            .filter_map(Monitor::violation)
            .map(|(at, _)| at)
            .min();
        if let Some(at) = first {
            self.situation.keep(at);
        }
    }
}

fn mission_reason(ending: &Ending) -> &'static str {
    match ending.outcome {
        RunOutcome::Failed => "the mission failed",
        _ if ending.by_condition => "the mission was not done before `end`",
        _ => "the mission was not done in time",
    }
}

/// A takeover beyond its contract, in words. It is a fault whatever the properties are (R17).
fn late(application: &Application, event: &Event) -> Option<String> {
    let what = event.what().filter(|what| what.is_late())?;
    let What::TookOver {
        group,
        schema,
        latency,
        allowed,
        ..
    } = what
    else {
        return None;
    };
    Some(format!(
        "{} took over in {} after {:.3} ms at {:.3} s, and its contract allows {:.3} ms",
        application.instances[*schema].name,
        application.groups[*group].name,
        *latency as f64 / 1e6,
        event.time() as f64 / 1e9,
        *allowed as f64 / 1e6
    ))
}

/// The first schema whose turns would overrun in real time, in words.
fn slow(handle: &Handle) -> Option<String> {
    let schemas = handle.snapshot().schemas;
    let (place, slow) = schemas
        .iter()
        .enumerate()
        .find(|(_, schema)| schema.slow_turns > 0)?;
    Some(format!(
        "{} of the turns of {} took longer than its budget of {:.1} ms by this machine's clock, {:.1} ms at most",
        slow.slow_turns,
        slow.name,
        handle.application().instances[SchemaId::new(place)].budget_ns as f64 / 1e6,
        slow.slowest_turn as f64 / 1e6
    ))
}

/// A fault of a schema, with its reason in one line.
fn fault(application: &Application, event: &Event) -> Option<String> {
    let Some(What::HealthChanged {
        schema,
        health: Health::Faulted(reason),
    }) = event.what()
    else {
        return None;
    };
    let lines: Vec<_> = reason.lines().map(str::trim).collect();
    Some(format!(
        "{} faulted at {:.3} s: {}",
        application.instances[*schema].name,
        event.time() as f64 / 1e9,
        lines.join("; ")
    ))
}

fn broken(outcome: &RunOutcome) -> Option<String> {
    match outcome {
        RunOutcome::Broken(reason) => Some(reason.clone()),
        RunOutcome::Done | RunOutcome::Failed | RunOutcome::TimeUp | RunOutcome::Stopped => None,
    }
}

fn end_word(ending: &Ending) -> &'static str {
    match &ending.outcome {
        _ if ending.by_condition => "end",
        RunOutcome::Done => "done",
        RunOutcome::Failed => "failed",
        RunOutcome::TimeUp => "time up",
        RunOutcome::Stopped => "stopped",
        RunOutcome::Broken(_) => "broken",
    }
}
