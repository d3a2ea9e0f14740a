//! The bench for schemas in Python: that of the Rust SDK, whose ports and children are numbers here.

#![allow(unsafe_code)]

use std::time::Duration;

use jde_schema::State;
use jde_schema::bench::{Bench as RustBench, Failure, Foreign, Remembered};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::functions;

/// A schema on a bench, which `jde.bench.Bench` uses.
#[pyclass(unsendable, module = "jde._jde")]
pub(crate) struct Bench {
    bench: RustBench<Foreign>,
}

#[pymethods]
impl Bench {
    #[new]
    fn new(py: Python<'_>, class: Py<PyType>) -> PyResult<Self> {
        functions::run_on_a_bench();
        let about = ("bench".to_owned(), String::new(), String::new());
        let table = functions::table(py, about, &[class])?;
        jde_loader::LoadedPlugin::linked_in(table)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        // SAFETY: a table that was just written and validated, which is never freed.
        let bench = unsafe { RustBench::foreign(&*table.schemas) };
        Ok(Self {
            bench: bench.map_err(failed)?,
        })
    }

    fn awake(&mut self) -> PyResult<()> {
        self.bench.awake().map_err(failed)
    }

    fn check(&mut self) -> PyResult<(bool, f64)> {
        let precondition = self.bench.check().map_err(failed)?;
        Ok((precondition.ready, precondition.urgency))
    }

    fn iterate(&mut self) -> PyResult<()> {
        match self.bench.iterate() {
            // It ends there, without a fault (R19).
            Err(failure) if failure.lacks_value() => Ok(()),
            result => result.map_err(failed),
        }
    }

    fn sleep(&mut self) -> PyResult<()> {
        self.bench.sleep().map_err(failed)
    }

    /// Returns the chosen child and the reason.
    fn arbitrate(&mut self, group: &str) -> PyResult<(Option<String>, String)> {
        let decision = self.bench.arbitrate(group).map_err(failed)?;
        Ok((decision.child, decision.reason))
    }

    /// Returns the widgets in the form of a recorded panel, as JSON.
    fn draw(&mut self) -> PyResult<String> {
        let drawn = self.bench.draw().map_err(failed)?;
        serde_json::to_string(drawn.list()).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// Performs a gesture, in the form of a recorded one, as JSON.
    fn touch(&mut self, widget: &str, touch: &str) -> PyResult<()> {
        let touch = serde_json::from_str(touch).map_err(|error| PyValueError::new_err(error.to_string()))?;
        self.bench.touch(widget, touch).map_err(failed)
    }

    fn save(&mut self) -> PyResult<(u32, Vec<u8>)> {
        let saved = self.bench.save().map_err(failed)?;
        Ok((saved.version, saved.bytes))
    }

    fn restore(&mut self, version: u32, bytes: Vec<u8>) -> PyResult<()> {
        self.bench.restore(&Remembered { version, bytes }).map_err(failed)
    }

    /// Returns the problems found: the port, and the text.
    fn inspect(&mut self) -> PyResult<Vec<(String, String)>> {
        let found = self.bench.inspect().map_err(failed)?;
        Ok(found
            .into_iter()
            .map(|problem| (problem.modulation, problem.words))
            .collect())
    }

    fn put(&mut self, port: usize, value: &[u8]) -> PyResult<()> {
        self.bench.put_bytes(port, value).map_err(PyValueError::new_err)
    }

    fn remove(&mut self, port: usize) {
        self.bench.remove(port);
    }

    /// Returns the newest value of an output, and its time, ns.
    fn written(&self, port: usize) -> Option<(Vec<u8>, u64)> {
        let (bytes, time) = self.bench.written_bytes(port)?;
        Some((bytes, time.as_nanos() as u64))
    }

    fn unbind(&mut self, name: &str) {
        self.bench.unbind(name);
    }

    fn set_now(&mut self, now_ns: u64) {
        self.bench.set_now(Duration::from_nanos(now_ns));
    }

    fn set_real_time(&mut self, real_time: bool) {
        self.bench.set_real_time(real_time);
    }

    fn set_authority(&mut self, authority: bool) {
        self.bench.set_authority(authority);
    }

    /// Sets the state of a child, as a number of the ABI.
    fn set_child(&mut self, role: &str, state: u32) {
        let states = [State::Slept, State::Checking, State::Ready, State::Winner];
        self.bench.set_child(role, states[(state as usize).min(3)]);
    }

    fn set_faulted(&mut self, role: &str, faulted: bool) {
        self.bench.set_faulted(role, faulted);
    }

    fn name_children(&mut self, named: Vec<(String, String)>) {
        let named: Vec<_> = named.iter().map(|(name, group)| (&**name, &**group)).collect();
        self.bench.name_children(&named);
    }

    fn awake_children(&self) -> Vec<String> {
        self.bench
            .awake_children()
            .into_iter()
            .map(str::to_owned)
            .collect()
    }

    /// Returns the name, the time, ns, and the number of the policy that the schema set through a child, if it did.
    fn policy(&self, role: &str) -> Option<(&'static str, u64, f64)> {
        let policy = self.bench.policy(role)?;
        Some((policy.name(), policy.time(), policy.number()))
    }

    /// Returns the log: of each message the level and the text.
    fn log(&self) -> Vec<(String, String)> {
        let messages = self.bench.log().iter();
        messages
            .map(|(severity, text)| (format!("{severity:?}").to_lowercase(), text.clone()))
            .collect()
    }
}

/// Returns a failure as an error, whose cause is that of the schema.
fn failed(failure: Failure) -> PyErr {
    let error = PyRuntimeError::new_err(failure.reason);
    if let Some(cause) = functions::take_last_error() {
        Python::attach(|py| error.set_cause(py, Some(cause)));
    }
    error
}
