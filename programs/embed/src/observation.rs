//! What a run keeps: records, the values of traced variables, and whether conditions have become true.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_conditions::Expression;
use jde_core::Nanos;
use jde_experiment::drive::EventQueue;
use jde_experiment::drive::values::DriveValues;
use jde_host::Handle;
use jde_records::{RecordBuilder, RecordKind, RunRecord};
use jde_timeline::{LogLimits, RecordLog};

/// What a run keeps of each kind of records; the oldest are dropped.
const LIMITS: LogLimits = LogLimits {
    records: 100_000,
    candidates: usize::MAX,
    switches: 0,
};

/// What is kept of a run.
pub(crate) struct Observation {
    events: EventQueue,
    builder: RecordBuilder,
    records: RecordLog,
    /// The events and records that were dropped since the last call of [`Observation::next_record`].
    dropped: u64,
    values: DriveValues,
    conditions: BTreeMap<u64, Condition>,
    traces: BTreeMap<String, Trace>,
}

/// A condition for which somebody waits.
struct Condition {
    expression: Expression,
    was_true: bool,
}

/// The values of a variable: the last one of each instant.
struct Trace {
    variable: Arc<Variable>,
    reader: Reader,
    seen: u64,
    /// When each value was measured or written, ns.
    times: Vec<u64>,
    bytes: Vec<u8>,
}

impl Observation {
    pub(crate) fn new(events: EventQueue, handle: &Handle) -> Self {
        Self {
            events,
            builder: RecordBuilder::new(handle.application()),
            records: RecordLog::new(LIMITS),
            dropped: 0,
            values: DriveValues::new(&[], handle),
            conditions: BTreeMap::new(),
            traces: BTreeMap::new(),
        }
    }

    /// Evaluates a condition from now on. Returns its number.
    pub(crate) fn add_condition(&mut self, expression: Expression, handle: &Handle) -> u64 {
        let number = self.conditions.last_key_value().map_or(0, |(last, _)| last + 1);
        let was_true = false;
        self.conditions.insert(number, Condition { expression, was_true });
        self.watch_conditions(handle);
        number
    }

    /// Evaluates a condition no more.
    pub(crate) fn remove_condition(&mut self, number: u64, handle: &Handle) {
        self.conditions.remove(&number);
        self.watch_conditions(handle);
    }

    /// Whether a condition has been true since it was added.
    pub(crate) fn was_true(&self, number: u64) -> bool {
        self.conditions
            .get(&number)
            .is_some_and(|condition| condition.was_true)
    }

    fn watch_conditions(&mut self, handle: &Handle) {
        let conditions = self.conditions.values();
        let expressions: Vec<_> = conditions.map(|condition| condition.expression.clone()).collect();
        self.values.set_expressions(&expressions, handle);
    }

    /// Keeps what has changed until now.
    pub(crate) fn observe(&mut self, now: Nanos) {
        let (events, dropped) = self.events.take();
        self.dropped += dropped;
        let mut instant = events.first().map_or(now, |event| event.time());
        for event in events {
            // In real time several instants may have passed: what was true at one of them is noticed.
            let before = std::mem::replace(&mut instant, event.time());
            if before != event.time() {
                self.evaluate(before);
            }
            self.values.add_event(&event);
            for record in self.builder.process(&event) {
                self.dropped += self.records.add(record);
            }
        }
        self.traces.values_mut().for_each(Trace::observe);
        self.evaluate(now);
    }

    fn evaluate(&mut self, now: Nanos) {
        let results = self.values.update(now);
        for (condition, result) in self.conditions.values_mut().zip(results) {
            condition.was_true |= result.is_some_and(|value| value != 0.0);
        }
    }

    /// Returns the newest records of a kind.
    pub(crate) fn records(&self, kind: RecordKind) -> Vec<RunRecord> {
        self.records.of(kind).cloned().collect()
    }

    /// Removes the oldest record and returns it, with the number of those that were dropped since the last call.
    pub(crate) fn next_record(&mut self) -> Option<(RunRecord, u64)> {
        Some((self.records.pop()?, std::mem::take(&mut self.dropped)))
    }

    /// Begins to keep the values of a variable.
    pub(crate) fn start_trace(&mut self, name: &str, variable: &Arc<Variable>) {
        let trace = self.traces.entry(name.to_owned());
        trace.or_insert_with(|| Trace::new(variable)).observe();
    }

    /// Returns the times, ns, and the values of a variable that is traced.
    pub(crate) fn trace(&self, name: &str) -> Option<(Vec<u64>, Vec<u8>)> {
        let trace = self.traces.get(name)?;
        Some((trace.times.clone(), trace.bytes.clone()))
    }
}

impl Trace {
    fn new(variable: &Arc<Variable>) -> Self {
        Self {
            reader: variable.reader("trace"),
            variable: Arc::clone(variable),
            seen: 0,
            times: Vec::new(),
            bytes: Vec::new(),
        }
    }

    fn observe(&mut self) {
        let newest = self.variable.newest();
        if std::mem::replace(&mut self.seen, newest) == newest {
            return;
        }
        if let Some(latched) = self.reader.latch_newest(0) {
            self.times.push(latched.stamp.time);
            self.bytes.extend_from_slice(latched.bytes);
        }
    }
}
