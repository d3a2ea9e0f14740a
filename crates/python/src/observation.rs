//! What a run keeps for Python: records, the values of traced variables, and whether a condition is true.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_conditions::Expression;
use jde_core::Nanos;
use jde_experiment::drive::EventQueue;
use jde_experiment::drive::values::DriveValues;
use jde_host::Handle;
use jde_records::{RecordBuilder, RunRecord};
use pyo3::prelude::*;

use crate::json;

/// The most records of each kind that a run keeps; the oldest are dropped.
const MAX_RECORDS: usize = 100_000;

/// What is kept of a run.
pub(crate) struct Observation {
    events: EventQueue,
    builder: RecordBuilder,
    records: BTreeMap<&'static str, VecDeque<RunRecord>>,
    values: DriveValues,
    traces: BTreeMap<String, Trace>,
}

/// The values of a variable: the last one of each instant.
pub(crate) struct Trace {
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
            records: BTreeMap::new(),
            values: DriveValues::new(&[], handle),
            traces: BTreeMap::new(),
        }
    }

    /// Evaluates this condition from now on, in place of the one before.
    pub(crate) fn set_condition(&mut self, condition: Option<Expression>, handle: &Handle) {
        self.values.set_expressions(condition.as_slice(), handle);
    }

    /// Keeps what has changed at this instant. Returns whether the condition is true.
    pub(crate) fn observe(&mut self, now: Nanos) -> bool {
        for event in self.events.take() {
            self.values.add_event(&event);
            for record in self.builder.process(&event) {
                let records = self.records.entry(record.kind().topic()).or_default();
                if records.len() == MAX_RECORDS {
                    records.pop_front();
                }
                records.push_back(record);
            }
        }
        self.traces.values_mut().for_each(Trace::observe);
        let condition = self.values.update(now).first().copied().flatten();
        condition.is_some_and(|value| value != 0.0)
    }

    /// Returns the newest records of a topic.
    pub(crate) fn records(&self, topic: &str) -> VecDeque<RunRecord> {
        self.records.get(topic).cloned().unwrap_or_default()
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
        if let Some(latched) = self.reader.latch_newest() {
            self.times.push(latched.stamp.time);
            self.bytes.extend_from_slice(latched.bytes);
        }
    }
}

/// Returns a record as a dictionary.
pub(crate) fn record_to_python<'py>(py: Python<'py>, record: &RunRecord) -> PyResult<Bound<'py, PyAny>> {
    match record {
        RunRecord::Decision(decision) => json(py, decision),
        RunRecord::State(state) => json(py, state),
        RunRecord::Event(event) => json(py, event),
    }
}
