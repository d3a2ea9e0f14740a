//! Signals: facts about a run that expressions name like variables, such as `vff.won` and `collisions`. They
//! are derived from events, or from records of an application in another process, and from the values of
//! variables. They have no clock: their user advances the time.

use std::sync::Arc;

use jde_abi::describe::{FieldKind, Scalar, Type};
use jde_board::Nanos;
use jde_core::{Id, State};
use jde_records::RunRecord;
use jde_records::event::{Event, Occurrence, What};
use jde_types::{Flag, Value};

use super::Names;
use super::compiled::Number;
use super::facts::{self, Fact};

/// The type of the variables from which `clearance` and `collisions` are derived.
const TRUTH: &str = "jde_msgs/msg/Truth";

/// The signals of the whole application. Those of schemas follow: `won` and `ready` of each.
const COMMON: [&str; 9] = [
    "time",
    "takeovers",
    "refused",
    "overruns",
    "faults",
    "late_takeovers",
    "clearance",
    "collisions",
    "seed",
];
pub(crate) const TIME: usize = 0;
const TAKEOVERS: usize = 1;
const REFUSED: usize = 2;
const OVERRUNS: usize = 3;
const FAULTS: usize = 4;
const LATE_TAKEOVERS: usize = 5;
pub(crate) const CLEARANCE: usize = 6;
pub(crate) const COLLISIONS: usize = 7;
const SEED: usize = 8;

/// The signals of an application and their present values.
///
/// At the beginning, all schemas are SLEPT, all counts are 0, and no robot has a clearance.
pub struct Signals {
    names: Arc<Names>,
    list: Vec<Signal>,
    /// The signals that changed since [`Self::take_changes`].
    changed: Vec<usize>,
    schemas: Vec<SchemaSignals>,
    robots: Vec<RobotTruth>,
}

struct Signal {
    name: String,
    /// Whether it is not a name of the application: a variable hides it, no robot is simulated, or the seed is not known.
    is_hidden: bool,
    value: Option<Number>,
    bytes: [u8; 8],
    is_changed: bool,
}

#[derive(Clone, Default)]
struct SchemaSignals {
    overruns: bool,
    is_faulted: bool,
    /// When its state changed last.
    state_since: Nanos,
}

/// A variable with the truth about a simulated robot.
struct RobotTruth {
    variable: String,
    clearance_offset: usize,
    collisions_offset: usize,
    /// Its present clearance and collisions.
    value: Option<(f64, f64)>,
}

/// Returns the signals of an application, and their types. A variable hides a signal of the same name.
pub(crate) fn of(names: &Names) -> Vec<(String, Arc<Type>)> {
    let number = Arc::new(f64::describe());
    let truth = Arc::new(Flag::describe());
    let signals = Signals::new(names).list.into_iter();
    signals
        .filter(|signal| !signal.is_hidden)
        .map(|signal| {
            let is_bool = matches!(signal.value, Some(Number::Bool(_)));
            (signal.name, Arc::clone(if is_bool { &truth } else { &number }))
        })
        .collect()
}

impl Signals {
    /// Creates the signals of an application that begins.
    #[must_use]
    pub fn new(names: &Names) -> Self {
        let robots: Vec<_> = names.variables.iter().filter_map(RobotTruth::of).collect();
        let is_simulated = !robots.is_empty();
        let common = COMMON.into_iter().enumerate().map(|(number, name)| {
            let (value, is_missing) = match number {
                CLEARANCE | COLLISIONS => (None, !is_simulated),
                SEED => (
                    names.seed.map(|seed| Number::Double(seed as f64)),
                    names.seed.is_none(),
                ),
                _ => (Some(Number::Double(0.0)), false),
            };
            (name.to_owned(), value, is_missing)
        });
        let of_schemas = names.schemas.iter().flat_map(|schema| {
            ["won", "ready"].map(|kind| (format!("{schema}.{kind}"), Some(Number::Bool(false)), false))
        });
        let mut signals = Self {
            names: Arc::new(names.clone()),
            list: Vec::new(),
            changed: Vec::new(),
            schemas: vec![SchemaSignals::default(); names.schemas.len()],
            robots,
        };
        for (name, value, is_missing) in common.chain(of_schemas) {
            signals.list.push(Signal {
                is_hidden: is_missing || names.variables.contains_key(&name),
                name,
                value: None,
                bytes: [0; 8],
                is_changed: false,
            });
            signals.set(signals.list.len() - 1, value);
        }
        signals
    }

    /// Returns the number of the signal with that name; `None` if there is none, or if a variable hides it.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.list
            .iter()
            .position(|signal| signal.name == name && !signal.is_hidden)
    }

    /// Returns the variables whose values a signal needs.
    pub fn variables(&self, signal: usize) -> impl Iterator<Item = &str> {
        let needed = matches!(signal, CLEARANCE | COLLISIONS);
        let robots = self.robots.iter().filter(move |_| needed);
        robots.map(|robot| robot.variable.as_str())
    }

    /// Returns the present value of a signal: the bytes of its type.
    #[must_use]
    pub fn value(&self, signal: usize) -> Option<&[u8]> {
        let signal = self.list.get(signal)?;
        let length = match signal.value? {
            Number::Bool(_) => 1,
            Number::Int(_) | Number::UInt(_) | Number::Double(_) => 8,
        };
        Some(&signal.bytes[..length])
    }

    /// Processes an event of the application that has these names.
    pub fn process_event(&mut self, event: &Event) {
        match event {
            Event::State(change) => self.set_state(change.time, change.schema.index(), change.to),
            Event::Decision(record) => {
                for candidate in record.candidates.iter() {
                    self.set_candidate(record.time, candidate.id.index(), candidate.ready);
                }
            }
            Event::Other(Occurrence { what, .. }) => {
                if matches!(what, What::TookOver { .. }) {
                    self.count(TAKEOVERS);
                }
                let names = Arc::clone(&self.names);
                self.process_occurrence(what.is_late(), facts::of_event(event, &names));
            }
        }
    }

    /// Processes a record of an application in another process.
    pub fn process_record(&mut self, record: &RunRecord) {
        match record {
            RunRecord::State(change) => {
                if let Some(schema) = self.schema(&change.schema) {
                    self.set_state(change.time, schema, change.to);
                }
            }
            RunRecord::Decision(decision) => {
                for candidate in &decision.candidates {
                    if let Some(schema) = self.schema(&candidate.name) {
                        self.set_candidate(record.time(), schema, candidate.ready);
                    }
                }
                // Of takeovers, only late ones have records of their own.
                if decision.takeover_us.is_some() {
                    self.count(TAKEOVERS);
                }
            }
            RunRecord::Other(Occurrence { what, .. }) => {
                self.process_occurrence(what.is_late(), facts::of_record(record));
            }
        }
    }

    fn process_occurrence(&mut self, is_late: bool, fact: Option<Fact<'_>>) {
        if is_late {
            self.count(LATE_TAKEOVERS);
        }
        if let Some(fact) = fact {
            self.process_fact(&fact);
        }
    }

    /// Processes a new value of a variable, or its retraction. Other variables than those of
    /// [`Self::variables`] have no effect.
    pub fn process_value(&mut self, variable: &str, value: Option<&[u8]>) {
        let Some(robot) = self.robots.iter_mut().find(|robot| robot.variable == variable) else {
            return;
        };
        robot.value = value.and_then(|bytes| robot.decode(bytes));
        let known = || self.robots.iter().filter_map(|robot| robot.value);
        let least = known().map(|(clearance, _)| clearance).reduce(f64::min);
        let sum = known()
            .map(|(_, collisions)| collisions)
            .reduce(|one, other| one + other);
        self.set(CLEARANCE, least.map(Number::Double));
        self.set(COLLISIONS, sum.map(Number::Double));
    }

    /// Sets the time, ns since the application's start.
    pub fn advance(&mut self, time: Nanos) {
        self.set(TIME, Some(Number::Double(time as f64 / 1e9)));
    }

    /// Calls `apply` with each signal that changed since the last call, and its value. The first call passes
    /// all signals.
    pub fn take_changes(&mut self, mut apply: impl FnMut(usize, Option<&[u8]>)) {
        let mut changed = std::mem::take(&mut self.changed);
        for signal in changed.drain(..) {
            self.list[signal].is_changed = false;
            apply(signal, self.value(signal));
        }
        // Its memory is used again.
        self.changed = changed;
    }

    fn process_fact(&mut self, fact: &Fact<'_>) {
        match fact {
            Fact::Refused { .. } => self.count(REFUSED),
            Fact::Health {
                schema,
                overrun,
                fault,
            } => {
                let Some(schema) = self.schema(schema) else {
                    return;
                };
                let state = &mut self.schemas[schema];
                let overran = std::mem::replace(&mut state.overruns, *overrun);
                let faulted = std::mem::replace(&mut state.is_faulted, fault.is_some());
                if *overrun && !overran {
                    self.count(OVERRUNS);
                }
                if fault.is_some() && !faulted {
                    self.count(FAULTS);
                }
            }
            Fact::Selected { .. } | Fact::Operator(_) => {}
        }
    }

    fn set_state(&mut self, time: Nanos, schema: usize, state: State) {
        self.schemas[schema].state_since = time;
        self.set(won(schema), Some(Number::Bool(state == State::Winner)));
        match state {
            State::Slept | State::Checking => self.set_ready(schema, false),
            State::Ready => self.set_ready(schema, true),
            // A winner need not be ready: its father may choose it at an absence.
            State::Winner => {}
        }
    }

    /// Processes whether a candidate of a selection was ready. The record of a selection may arrive after
    /// later changes of state, because it contains the time of the takeover.
    fn set_candidate(&mut self, time: Nanos, schema: usize, is_ready: bool) {
        if time > self.schemas[schema].state_since {
            self.set_ready(schema, is_ready);
        }
    }

    fn set_ready(&mut self, schema: usize, is_ready: bool) {
        self.set(won(schema) + 1, Some(Number::Bool(is_ready)));
    }

    fn count(&mut self, signal: usize) {
        let before = self.list[signal].value.map_or(0.0, Number::as_f64);
        self.set(signal, Some(Number::Double(before + 1.0)));
    }

    fn set(&mut self, number: usize, value: Option<Number>) {
        let Some(signal) = self.list.get_mut(number).filter(|signal| signal.value != value) else {
            return;
        };
        signal.value = value;
        match value {
            Some(Number::Bool(value)) => signal.bytes[0] = value.into(),
            Some(number) => signal.bytes = number.as_f64().to_ne_bytes(),
            None => {}
        }
        if !std::mem::replace(&mut signal.is_changed, true) && !signal.is_hidden {
            self.changed.push(number);
        }
    }

    fn schema(&self, name: &str) -> Option<usize> {
        self.names.schemas.iter().position(|schema| schema == name)
    }
}

/// Whether a signal counts what happened since the application's start.
pub(crate) fn is_count(signal: usize) -> bool {
    matches!(signal, TAKEOVERS..=LATE_TAKEOVERS)
}

/// Returns the signal whether a schema is WINNER. The next one is whether it is ready.
fn won(schema: usize) -> usize {
    COMMON.len() + 2 * schema
}

impl RobotTruth {
    fn of((name, value_type): (&String, &Arc<Type>)) -> Option<Self> {
        let offset = |field: &str, scalar| {
            let found = value_type.fields.iter().find(|known| known.name == field)?;
            (found.kind == FieldKind::Scalar(scalar)).then_some(found.offset)
        };
        (value_type.name == TRUTH).then_some(())?;
        Some(Self {
            variable: name.clone(),
            clearance_offset: offset("clearance", Scalar::F64)?,
            collisions_offset: offset("collisions", Scalar::U64)?,
            value: None,
        })
    }

    fn decode(&self, bytes: &[u8]) -> Option<(f64, f64)> {
        let number = |offset: usize, scalar| Number::decode(scalar, bytes.get(offset..)?);
        Some((
            number(self.clearance_offset, Scalar::F64)?.as_f64(),
            number(self.collisions_offset, Scalar::U64)?.as_f64(),
        ))
    }
}
