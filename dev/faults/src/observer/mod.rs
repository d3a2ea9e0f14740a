//! Observes an application from outside and reports violated rules. It does not rely on the reports of the
//! observed code: states and authority are rebuilt from effects, commands are read from the board, motion is
//! read from the simulated robot's ground truth, and turns are counted.

mod commands;
mod history;
mod motion;
mod periods;
mod rules;
mod tamper;
mod values;

use std::collections::BTreeSet;
use std::sync::Arc;

use jde_board::Watch;
use jde_core::{Health, Nanos, SchemaId, Table};
use jde_host::{Handle, Options, StartHook};
use jde_records::event::{Event, Occurrence, What};
use jde_records::turn::{Call, OnTurn, Turn, TurnKind};
use parking_lot::Mutex;

use crate::case::RunMode;
use commands::Commands;
use history::History;
use motion::Motion;
use periods::PeriodMonitor;
use rules::Rules;
pub use tamper::Tamper;

/// Most reported violations: later ones follow from the first.
const MAX_REPORTED: usize = 8;

/// Most faults after which a restart follows soon: the back-off of 20 ms doubles with each.
const MAX_QUICK_RESTARTS: u64 = 5;

/// Symptom of a call that the host abandoned because it did not return.
pub const CALL_ABANDONED: &str = "left behind";
/// Symptom of an abandoned call that returned.
pub const CALL_RETURNED: &str = "came back";
/// Symptom of a call that was abandoned when the application ended.
pub const ABANDONED_AT_END: &str = "left at the end";

/// The observer's state, shared by all its callbacks.
pub(crate) struct ObserverState {
    pub(crate) clock: RunMode,
    pub(crate) tamper: Option<Tamper>,
    pub(crate) names: Table<SchemaId, String>,
    pub(crate) history: History,
    pub(crate) rhythm: PeriodMonitor,
    pub(crate) symptoms: Vec<Symptom>,
    /// Schemas that faulted and were not restarted.
    faulted: BTreeSet<SchemaId>,
    violations: Vec<String>,
    /// The application is ending or has ended.
    ended: bool,
}

/// A consequence of a fault.
#[derive(Clone, Debug)]
pub struct Symptom {
    /// Its time.
    pub time: Nanos,
    /// The schema's index.
    pub schema: SchemaId,
    /// The consequence: "faulted", "hung".
    pub what: &'static str,
}

/// The observer of one application.
pub struct Observer {
    state: Arc<Mutex<ObserverState>>,
    commands: Arc<Mutex<Commands>>,
    motion: Motion,
    watches: Arc<Mutex<Vec<Watch>>>,
}

impl Observer {
    /// An observer for an application that has not started.
    #[must_use]
    pub fn new(clock: RunMode, tamper: Option<Tamper>) -> Self {
        let state = ObserverState {
            clock,
            tamper,
            names: Table::default(),
            history: History::default(),
            rhythm: PeriodMonitor::new(clock),
            symptoms: Vec::new(),
            faulted: BTreeSet::new(),
            violations: Vec::new(),
            ended: false,
        };
        Self {
            state: Arc::new(Mutex::new(state)),
            commands: Arc::default(),
            motion: Motion::default(),
            watches: Arc::default(),
        }
    }

    /// Connects the observer to an application that is started with these options.
    pub fn watch(&self, options: &mut Options) {
        options.transaction_observer = Some(Box::new(Rules::new(Arc::clone(&self.state))));
        let state = Arc::clone(&self.state);
        options
            .observers
            .push(Box::new(move |event: &Event| state.lock().on_event(event)));
        let state = Arc::clone(&self.state);
        let turns: OnTurn = Arc::new(move |turn: &Turn| {
            if matches!(turn.kind(), TurnKind::Cycled(_)) {
                // A perceptive schema checks nothing.
                let checked = turn.looked != Call::default();
                let call = if checked { turn.looked } else { turn.acted };
                state.lock().had_turn(SchemaId(turn.schema), call.time);
            }
        });
        options.on_turn = Some(turns);
        let (state, commands, watches) = (
            Arc::clone(&self.state),
            Arc::clone(&self.commands),
            Arc::clone(&self.watches),
        );
        let start_hook: StartHook = Box::new(move |handle: &Handle| {
            let application = handle.application();
            let mut observer = state.lock();
            observer.names = application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect();
            observer.rhythm.begin(application);
            let tamper = observer.tamper;
            drop(observer);
            let mut watches = watches.lock();
            watches.extend(Commands::watch(&commands, handle, tamper));
            watches.extend(periods::watch_drivers(&state, handle));
            Ok(())
        });
        options.start_hook = Some(start_hook);
    }

    /// A schema is about to have a fault: from now on it may miss turns.
    pub fn excuse(&self, schema: SchemaId) {
        self.state.lock().rhythm.excuse(schema);
    }

    /// A fault of the schema has ended: from `resumes_at` on it must have turns.
    pub fn recovers(&self, schema: SchemaId, resumes_at: Nanos) {
        self.state.lock().rhythm.recovers(schema, resumes_at);
    }

    /// Reports schemas that were not restarted long after their faults ended.
    pub fn judge_recovery(&self, handle: &Handle) {
        // The snapshot is taken first: the transaction observer waits for the lock of the state, so the holder of
        // that lock must not wait for the rules.
        let schemas = handle.snapshot().schemas;
        let mut state = self.state.lock();
        for (id, schema) in (0..).map(SchemaId).zip(&schemas) {
            let faulted = matches!(schema.health, Health::Faulted(_));
            // After many faults, the back-off is long.
            let restarts_late = schema.faults > MAX_QUICK_RESTARTS || schema.left > 0;
            if faulted && !restarts_late && state.rhythm.must_have_turns(id, handle.now()) {
                state.report(format!(
                    "recovery: `{}` was not restarted after its fault",
                    schema.name
                ));
            }
        }
    }

    /// Judges all that occurred until now; in lockstep, between two instants.
    pub fn judge(&mut self, handle: &Handle) {
        let now = handle.now();
        let mut state = self.state.lock();
        self.commands.lock().judge(&mut state, now);
        self.motion.judge(&mut state, &self.commands.lock(), handle, now);
        state.judge_rhythm(now);
        if state.clock == RunMode::Lockstep {
            state.judge_values(handle, now);
        }
    }

    /// The application is about to end. Later events are not judged.
    pub fn set_ended(&self) {
        self.state.lock().ended = true;
        self.watches.lock().clear();
        self.commands.lock().close();
    }

    /// Judges what can be judged only at the end. `bare` is the share of turns that a thread without an
    /// application lost although it only waited for its turns.
    pub fn conclude(&self, bare: f64) {
        self.state.lock().conclude_rhythm(bare);
    }

    /// The violations found so far.
    #[must_use]
    pub fn violations(&self) -> Vec<String> {
        self.state.lock().violations.clone()
    }

    /// The consequences of faults so far.
    #[must_use]
    pub fn symptoms(&self) -> Vec<Symptom> {
        self.state.lock().symptoms.clone()
    }

    /// The least share of its turns that a bystander had.
    #[must_use]
    pub fn min_turn_share(&self) -> Option<f64> {
        self.state.lock().rhythm.min_turn_share()
    }
}

impl ObserverState {
    pub(crate) fn report(&mut self, violation: String) {
        if self.violations.len() < MAX_REPORTED {
            self.violations.push(violation);
        }
    }

    pub(crate) fn name(&self, schema: SchemaId) -> &str {
        self.names.get(schema).map_or("?", String::as_str)
    }

    pub(crate) fn take_tamper(&mut self, kind: Tamper) -> bool {
        // Only once, because the observer must find a single violation.
        self.tamper.take_if(|tamper| *tamper == kind).is_some()
    }

    fn on_event(&mut self, event: &Event) {
        match event {
            Event::Decision(_) => {}
            Event::State(change) => self.changed(change.time, change.schema, change.from, change.to),
            Event::Other(Occurrence { time, what }) => {
                if let What::HealthChanged { schema, health } = what {
                    if matches!(health, Health::Faulted(_)) {
                        self.faulted.insert(*schema);
                    } else {
                        self.faulted.remove(schema);
                    }
                }
                let symptom = self.symptom(what);
                self.symptoms.extend(symptom.map(|(schema, what)| Symptom {
                    time: *time,
                    schema,
                    what,
                }));
            }
        }
    }

    /// Returns the schema and the name of a consequence of a fault.
    fn symptom(&self, what: &What) -> Option<(SchemaId, &'static str)> {
        match what {
            What::HealthChanged { schema, health } => match health {
                Health::Faulted(_) => Some((*schema, "faulted")),
                Health::ArbitrationFailed(_) => Some((*schema, "arbitration failed")),
                Health::Ok | Health::Overrun => None,
            },
            What::Hung { schema, .. } if self.ended => Some((*schema, ABANDONED_AT_END)),
            What::Hung { schema, .. } => Some((*schema, "hung")),
            What::CallAbandoned { schema, .. } => Some((*schema, CALL_ABANDONED)),
            What::AbandonedCallReturned { schema, .. } => Some((*schema, CALL_RETURNED)),
            What::Refused { schema, .. } => Some((*schema, "refused")),
            What::Limited { schema, .. } => Some((*schema, "limited")),
            What::Overrun { schema, .. } => Some((*schema, "overran")),
            What::Reloaded { schema, .. } => Some((*schema, "reloaded")),
            What::ReloadRolledBack { schema, .. } => Some((*schema, "went back")),
            What::Operator { action, .. } => Some((*action.schema(), "operated")),
            What::TookOver { .. }
            | What::ChatteringStarted { .. }
            | What::ChatteringEnded { .. }
            | What::StoodStill { .. }
            | What::WentOn { .. }
            | What::Stalled { .. }
            | What::Retracted { .. }
            | What::Triggered { .. }
            | What::Ended { .. }
            | What::Unknown { .. } => None,
        }
    }
}
