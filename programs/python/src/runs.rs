//! A run: an application in lockstep that Python steps, reads and operates. Python is never called while time
//! passes.

use jde_embed::Stop;
use jde_panel::Gesture;
use jde_records::RecordKind;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::values::{as_text, dtype, from_python, part_of, plain, to_python};
use crate::{error, json, nanoseconds, record_to_python, run_error};

/// An application in lockstep.
#[pyclass(frozen, module = "jde", name = "Run")]
pub(crate) struct PythonRun(pub(crate) jde_embed::Run);

#[pymethods]
impl PythonRun {
    /// The time since the start, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.handle().now() as f64 / 1e9
    }

    /// The name of the application.
    #[getter]
    fn name(&self) -> &str {
        &self.0.handle().application().name
    }

    /// How the application ended: `done`, `failed`, `time up`, `stopped` or `broken: ` with the reason; `None`
    /// while it runs.
    #[getter]
    fn outcome(&self) -> Option<String> {
        self.0.outcome()
    }

    /// Runs the next instant, or until a time, s, if that comes first. Returns whether the application goes on: not
    /// if it has ended, and not if nothing is due and no time is given.
    #[pyo3(signature = (time=None))]
    fn step(&self, py: Python<'_>, time: Option<f64>) -> PyResult<bool> {
        let end = time.map(nanoseconds).transpose()?;
        py.detach(|| self.0.step(end)).map_err(run_error)
    }

    /// Whether a time, s, is reached.
    fn has_reached(&self, time: f64) -> PyResult<bool> {
        Ok(self.0.handle().now() >= nanoseconds(time)?)
    }

    /// Runs until a time, s. Returns whether the application goes on.
    pub(crate) fn until_time(&self, py: Python<'_>, time: f64) -> PyResult<bool> {
        Ok(self.until(py, Some(time), None)? != Stop::End)
    }

    /// Runs until a condition is true, or a time, s, is reached. Returns whether it is true.
    #[pyo3(signature = (condition, time=None))]
    fn until_condition(&self, py: Python<'_>, condition: &str, time: Option<f64>) -> PyResult<bool> {
        Ok(self.until(py, time, Some(condition))? == Stop::Condition)
    }

    /// Brings the application to rest. Afterwards its variables can still be read.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.0.end());
    }

    /// Returns the newest value of a variable, or of a part of it: `run["pioneer.truth.pose.x"]`. `None` without
    /// a value.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let read = self.0.with_value(name, |value_type, bytes, path| {
            if !path.is_empty() {
                let part = jde_board::value::get_path(value_type, bytes, path).map_err(error)?;
                if let Some(scalar) = plain(py, &part)? {
                    return Ok(scalar);
                }
            }
            part_of(to_python(py, value_type, bytes)?, path)
        });
        read.map_err(run_error)?.transpose()
    }

    /// Writes a modulation or a period as an operator (R14), or what a mock writes. A text may have a unit.
    fn __setitem__(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = from_python(value)?;
        py.detach(|| self.0.write(name, value)).map_err(run_error)
    }

    /// Wakes a schema as its father would.
    fn play(&self, py: Python<'_>, schema: &str) -> PyResult<()> {
        py.detach(|| self.0.play(schema)).map_err(run_error)
    }

    /// Puts a schema to sleep until it is released.
    fn stop(&self, py: Python<'_>, schema: &str) -> PyResult<()> {
        py.detach(|| self.0.stop(schema)).map_err(run_error)
    }

    /// Makes a schema the winner of its group while it is awake.
    fn force(&self, py: Python<'_>, schema: &str) -> PyResult<()> {
        py.detach(|| self.0.force(schema)).map_err(run_error)
    }

    /// Undoes what operators did to a schema.
    fn release(&self, py: Python<'_>, schema: &str) -> PyResult<()> {
        py.detach(|| self.0.release(schema)).map_err(run_error)
    }

    /// Changes the world of a simulated robot: `run.edit("pioneer", remove="door")`. Several edits are several
    /// calls.
    #[pyo3(signature = (driver, **edits))]
    fn edit(&self, py: Python<'_>, driver: &str, edits: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let text = edits.map_or(Ok(String::new()), |edits| {
            Ok::<_, PyErr>(as_text(&from_python(edits)?))
        })?;
        py.detach(|| self.0.edit(driver, &text)).map_err(run_error)
    }

    /// Returns the state of every schema and group.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.0.snapshot())
    }

    /// Returns the winner of a group, such as `roots` or `example/base`; `None` if nobody wins.
    fn winner(&self, group: &str) -> PyResult<Option<String>> {
        self.0.winner(group).map_err(run_error)
    }

    /// Whether a schema has authority at present (R7).
    fn has_authority(&self, schema: &str) -> PyResult<bool> {
        self.0.has_authority(schema).map_err(run_error)
    }

    /// Returns the newest records of a kind: `decisions`, `states` or `events`.
    fn records<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let records = py.detach(|| self.0.records(record_kind(kind)?).map_err(run_error))?;
        records
            .iter()
            .map(|record| record_to_python(py, record))
            .collect()
    }

    /// Begins to keep the values of a variable.
    fn start_trace(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        py.detach(|| self.0.start_trace(name)).map_err(run_error)
    }

    /// Returns the times, ns, the values and the `dtype` of a variable that is traced.
    fn trace<'py>(
        &self,
        py: Python<'py>,
        name: &str,
    ) -> PyResult<(Vec<u64>, Bound<'py, PyBytes>, Bound<'py, PyAny>)> {
        let value_type = self.0.value_type(name).map_err(run_error)?;
        let (times, bytes) = py.detach(|| self.0.trace(name)).map_err(run_error)?;
        let described = dtype(py, &value_type)?;
        Ok((times, PyBytes::new(py, &bytes), described.into_any()))
    }

    /// Returns the newest drawing of the panel of a schema, which is drawn from the first call on; `None` before its
    /// first drawing.
    fn panel<'py>(&self, py: Python<'py>, schema: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        match py.detach(|| self.0.panel(schema)).map_err(run_error)? {
            None => Ok(None),
            Some(drawn) => match &drawn.list {
                Ok(list) => json(py, list).map(Some),
                Err(reason) => Err(error(reason)),
            },
        }
    }

    /// Applies a gesture, as JSON, to the panel of a schema.
    fn touch(&self, schema: &str, gesture: &str) -> PyResult<()> {
        let gesture: Gesture = serde_json::from_str(gesture).map_err(error)?;
        self.0.touch(schema, gesture).map_err(run_error)
    }
}

impl PythonRun {
    /// Lets time pass without the interpreter. An interruption, such as Ctrl-C, brings the application to rest.
    fn until(&self, py: Python<'_>, time: Option<f64>, condition: Option<&str>) -> PyResult<Stop> {
        let end = time.map(nanoseconds).transpose()?;
        let mut interrupted = Ok(());
        let stop = py.detach(|| {
            self.0.until(end, condition, || {
                interrupted = Python::attach(|py| py.check_signals());
                interrupted.is_ok()
            })
        });
        interrupted.and_then(|()| stop.map_err(run_error))
    }
}

/// Returns the kind of records of a name, such as `decisions`.
pub(crate) fn record_kind(name: &str) -> PyResult<RecordKind> {
    let topic = format!("/jde/{name}");
    let known = RecordKind::ALL.into_iter().find(|kind| kind.topic() == topic);
    known.ok_or_else(|| {
        PyValueError::new_err(format!("there are decisions, states and events, and no {name}"))
    })
}
