//! A run: an application in lockstep that Python steps, reads and operates. Python is never called while time
//! passes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use jde_abi::describe::{Role, Type};
use jde_app::literal::parse_value;
use jde_board::Variable;
use jde_board::value::{self, Value};
use jde_conditions::{Expression, Names};
use jde_core::Nanos;
use jde_experiment::drive::EventQueue;
use jde_host::{Handle, LiveValue, Lockstep, OperatorHandle, PanelViewGuard};
use jde_panel::{Gesture, MAX_RATE};
use jde_records::event::Outcome;
use jde_sim::{EditQueue, Edits};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::observation::{Observation, record_to_python};
use crate::values::{as_text, dtype, from_python, part_of, plain, to_python};
use crate::{error, json, lock, nanoseconds, split_name};

/// The name of the operator in records.
const OPERATOR: &str = "python";
/// The modulation of a simulated robot that changes its world.
const EDIT: &str = "edit";
/// The machine time after which signals such as Ctrl-C are handled.
const SIGNALS: Duration = Duration::from_millis(20);
/// The time that passes between two looks at the clock of the machine, ns.
const MAX_STRIDE: Nanos = 1_000_000_000;
/// The greatest time that a run reaches, ns.
const FOREVER: Nanos = Nanos::MAX - 1;

/// An application in lockstep.
#[pyclass(frozen, module = "jde", name = "Run")]
pub(crate) struct Run {
    pub(crate) handle: Handle,
    operator: OperatorHandle,
    /// The ports of mocks, by their full names.
    live: BTreeMap<String, LivePort>,
    state: Mutex<State>,
}

/// A port of a mock.
#[derive(Clone)]
pub(crate) struct LivePort {
    pub(crate) value_type: Arc<Type>,
    pub(crate) value: LiveValue,
}

struct State {
    /// `None` once the application was brought to rest.
    lockstep: Option<Lockstep>,
    observation: Option<Observation>,
    /// The changes of each world so far, by the driver that makes them.
    edits: BTreeMap<usize, EditQueue>,
    /// The panels that are drawn, by their schemas.
    panels: BTreeMap<usize, PanelViewGuard>,
}

/// Why time stopped passing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stop {
    /// Signals are to be handled.
    Signals,
    /// The time was reached.
    Time,
    /// The condition became true.
    Condition,
    /// The application has ended.
    End,
}

#[pymethods]
impl Run {
    /// The name of the application.
    #[getter]
    fn name(&self) -> &str {
        &self.handle.application().name
    }

    /// The time since the start, s.
    #[getter]
    fn time(&self) -> f64 {
        self.handle.now() as f64 / 1e9
    }

    /// How the application ended: `done`, `failed`, `time up`, `stopped` or `broken: ` with the reason; `None`
    /// while it runs.
    #[getter]
    fn outcome(&self) -> Option<String> {
        self.handle.outcome().map(|outcome| match outcome {
            Outcome::Done => String::from("done"),
            Outcome::Failed => String::from("failed"),
            Outcome::TimeUp => String::from("time up"),
            Outcome::Stopped => String::from("stopped"),
            Outcome::Broken(reason) => format!("broken: {reason}"),
        })
    }

    /// Runs the next instant, or until a time, s, if that comes first. Returns whether the application goes on: not
    /// if it has ended, and not if nothing is due and no time is given.
    #[pyo3(signature = (time=None))]
    fn step(&self, py: Python<'_>, time: Option<f64>) -> PyResult<bool> {
        let end = time.map(nanoseconds).transpose()?;
        let next = py.detach(|| next_instant(self.state().lockstep.as_mut()?, &self.handle));
        match next.into_iter().chain(end).min() {
            Some(time) => Ok(self.advance(py, time, false)? != Stop::End),
            None => Ok(false),
        }
    }

    /// Whether a time, s, is reached.
    fn has_reached(&self, time: f64) -> PyResult<bool> {
        Ok(self.handle.now() >= nanoseconds(time)?)
    }

    /// Runs until a time, s. Returns whether the application goes on.
    pub(crate) fn until_time(&self, py: Python<'_>, time: f64) -> PyResult<bool> {
        Ok(self.advance(py, nanoseconds(time)?, false)? != Stop::End)
    }

    /// Runs until a condition is true, or a time, s, is reached. Returns whether it is true.
    #[pyo3(signature = (condition, time=None))]
    fn until_condition(&self, py: Python<'_>, condition: &str, time: Option<f64>) -> PyResult<bool> {
        let end = time.map(nanoseconds).transpose()?.unwrap_or(FOREVER);
        let names = Names::of(self.handle.application());
        let expression = Expression::condition(condition, &names).map_err(error)?;
        py.detach(|| {
            self.observation(|observation| {
                observation.set_condition(Some(expression), &self.handle);
            })
        })?;
        let stop = self.advance(py, end, true);
        // Later instants do not evaluate it.
        py.detach(|| self.observation(|observation| observation.set_condition(None, &self.handle)))?;
        Ok(stop? == Stop::Condition)
    }

    /// Brings the application to rest. Afterwards its variables can still be read.
    fn close(&self, py: Python<'_>) {
        py.detach(|| {
            let mut state = self.state();
            drop(state.lockstep.take());
            state.observe(&self.handle);
        });
    }

    /// Returns the newest value of a variable, or of a part of it: `run["pioneer.truth.pose.x"]`. `None` without
    /// a value.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (variable, path) = self.find(name)?;
        let mut reader = variable.reader(OPERATOR);
        let Some(latched) = reader.latch() else {
            return Ok(None);
        };
        let value_type = &variable.describe().value_type;
        if !path.is_empty() {
            let part = value::get_path(value_type, latched.bytes, path).map_err(error)?;
            if let Some(scalar) = plain(py, &part)? {
                return Ok(Some(scalar));
            }
        }
        part_of(to_python(py, value_type, latched.bytes)?, path).map(Some)
    }

    /// Writes a modulation or a period as an operator (R14), or what a mock writes. A text may have a unit.
    fn __setitem__(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = from_python(value)?;
        if let Some(live) = self.live.get(name) {
            let mut bytes = vec![0; live.value_type.bytes];
            let value = self.parse(name, value, &live.value_type, "")?;
            value::encode(&live.value_type, &value, &mut bytes).map_err(error)?;
            return live.value.set(&bytes).map_err(error);
        }
        let (owner, own) = name.split_once('.').unwrap_or((name, ""));
        let schema = self.schema(owner)?;
        if own == "period" {
            let (variable, _) = self.find(name)?;
            let period = self.parse(name, value, &variable.describe().value_type, "s")?;
            let Some(period) = period.into_only_field().as_number() else {
                return Err(error(format!("`{name}` is a number of seconds")));
            };
            return self
                .operator
                .set_period(schema, nanoseconds(period)?)
                .map_err(error);
        }
        let ports = &self.handle.application().instances[schema].schema.ports;
        let is_modulation = |role: &Role| matches!(role, Role::Modulation { .. });
        let modulations = ports.iter().filter(|port| is_modulation(&port.role));
        let Some(port) = modulations.clone().find(|port| port.name == own) else {
            let known: Vec<_> = modulations.map(|port| port.name.as_str()).collect();
            return Err(PyKeyError::new_err(format!(
                "schema `{owner}` has no modulation `{own}`, but {}",
                known.join(", ")
            )));
        };
        let value = self.parse(name, value, &port.value_type, &port.unit)?;
        self.operator.modulate(schema, own, &value).map_err(error)
    }

    /// Wakes a schema as its father would.
    fn play(&self, schema: &str) -> PyResult<()> {
        self.operator.play(self.schema(schema)?).map_err(error)
    }

    /// Puts a schema to sleep until it is released.
    fn stop(&self, schema: &str) -> PyResult<()> {
        self.operator.hold_asleep(self.schema(schema)?).map_err(error)
    }

    /// Makes a schema the winner of its group while it is awake.
    fn force(&self, schema: &str) -> PyResult<()> {
        self.operator.force(self.schema(schema)?).map_err(error)
    }

    /// Undoes what operators did to a schema.
    fn release(&self, schema: &str) -> PyResult<()> {
        self.operator.release(self.schema(schema)?).map_err(error)
    }

    /// Changes the world of a simulated robot: `run.edit("pioneer", remove="door")`. Several edits are several
    /// calls.
    #[pyo3(signature = (driver, **edits))]
    fn edit(&self, py: Python<'_>, driver: &str, edits: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let text = edits.map_or(Ok(String::new()), |edits| {
            Ok::<_, PyErr>(as_text(&from_python(edits)?))
        })?;
        let schema = self.schema(driver)?;
        let text = py.detach(|| {
            let mut state = self.state();
            let queue = state.edits.entry(schema).or_default();
            Edits::parse(&text).and_then(|edits| queue.push(&edits))
        });
        let text = Value::Text(text.map_err(error)?);
        self.operator.modulate(schema, EDIT, &text).map_err(error)
    }

    /// Returns the state of every schema and group.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.handle.snapshot())
    }

    /// Returns the winner of a group, such as `roots` or `example/base`; `None` if nobody wins.
    fn winner(&self, group: &str) -> PyResult<Option<String>> {
        let snapshot = self.handle.snapshot();
        let found = snapshot.groups.iter().find(|view| view.name == group);
        let Some(found) = found else {
            let known: Vec<_> = snapshot.groups.iter().map(|view| view.name.as_str()).collect();
            return Err(PyKeyError::new_err(format!(
                "there is no group `{group}`, but {}",
                known.join(", ")
            )));
        };
        Ok(found.winner.map(|winner| snapshot.schemas[winner].name.clone()))
    }

    /// Returns the newest records of a kind: `decisions`, `states` or `events`.
    fn records<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let topic = format!("/jde/{kind}");
        let records = py.detach(|| self.observation(|observation| observation.records(&topic)))?;
        records
            .iter()
            .map(|record| record_to_python(py, record))
            .collect()
    }

    /// Begins to keep the values of a variable.
    fn start_trace(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        let variable = self.handle.board().get(name).map_err(error)?;
        py.detach(|| self.observation(|observation| observation.start_trace(name, &variable)))
    }

    /// Returns the times, ns, the values and the `dtype` of a variable that is traced.
    fn trace<'py>(
        &self,
        py: Python<'py>,
        name: &str,
    ) -> PyResult<(Vec<u64>, Bound<'py, PyBytes>, Bound<'py, PyAny>)> {
        let variable = self.handle.board().get(name).map_err(error)?;
        let kept = py.detach(|| self.observation(|observation| observation.trace(name)))?;
        let (times, bytes) = kept.ok_or_else(|| error(format!("`{name}` is not traced")))?;
        let described = dtype(py, &variable.describe().value_type)?;
        Ok((times, PyBytes::new(py, &bytes), described.into_any()))
    }

    /// Returns the newest drawing of the panel of a schema, which is drawn from the first call on; `None` before its
    /// first drawing.
    fn panel<'py>(&self, py: Python<'py>, schema: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let schema = self.schema(schema)?;
        py.detach(|| {
            let mut state = self.state();
            if let Entry::Vacant(free) = state.panels.entry(schema) {
                free.insert(self.handle.view_panel(schema, MAX_RATE, || {}).map_err(error)?);
            }
            Ok::<_, PyErr>(())
        })?;
        match self.handle.panel(schema) {
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
        let schema = self.schema(schema)?;
        self.handle.touch(OPERATOR, schema, gesture).map_err(error)
    }
}

impl Run {
    pub(crate) fn new(
        lockstep: Lockstep,
        live: BTreeMap<String, LivePort>,
        events: Option<EventQueue>,
    ) -> Self {
        let handle = lockstep.handle();
        let observation = events.map(|events| Observation::new(events, &handle));
        Self {
            operator: handle.operator(OPERATOR),
            live,
            state: Mutex::new(State {
                lockstep: Some(lockstep),
                observation,
                edits: BTreeMap::new(),
                panels: BTreeMap::new(),
            }),
            handle,
        }
    }

    /// Returns the port of a mock at the front of a name, its full name, and the path after it.
    pub(crate) fn find_live<'n>(&self, name: &'n str) -> PyResult<(&'n str, &'n str, &LivePort)> {
        let found = split_name(name, |port| Some((port, self.live.get(port)?)));
        let found = found.map(|((port, live), path)| (port, path, live));
        found.ok_or_else(|| {
            let known: Vec<_> = self.live.keys().map(String::as_str).collect();
            PyKeyError::new_err(format!(
                "no mock writes `{name}`; mocks write {}",
                known.join(", ")
            ))
        })
    }

    /// Returns the variable at the front of a name, and the path after it.
    pub(crate) fn find<'n>(&self, name: &'n str) -> PyResult<(Arc<Variable>, &'n str)> {
        let board = self.handle.board();
        split_name(name, |front| board.find(front)).map_or_else(
            // The error names the most similar variable.
            || match board.get(name) {
                Ok(variable) => Ok((variable, "")),
                Err(unknown) => Err(PyKeyError::new_err(unknown.to_string())),
            },
            Ok,
        )
    }

    fn schema(&self, name: &str) -> PyResult<usize> {
        let application = self.handle.application();
        application.instance(name).ok_or_else(|| {
            let known: Vec<_> = application
                .instances
                .iter()
                .map(|instance| instance.name.as_str())
                .collect();
            PyKeyError::new_err(format!(
                "no schema is called `{name}`; there are {}",
                known.join(", ")
            ))
        })
    }

    /// Reads a text as the application file would; other values stay as they are.
    fn parse(&self, name: &str, value: Value, value_type: &Type, unit: &str) -> PyResult<Value> {
        let Value::Text(text) = &value else {
            return Ok(value);
        };
        let owner = name.split_once('.').unwrap_or((name, ""));
        let file = &self.handle.application().path;
        let folder = file.parent().unwrap_or(file);
        parse_value(text, owner, value_type, unit, folder, name).map_err(error)
    }

    /// Runs until a time, or until the condition is true. An interruption brings the application to rest.
    fn advance(&self, py: Python<'_>, end: Nanos, on_condition: bool) -> PyResult<Stop> {
        loop {
            let stop = py.detach(|| self.state().advance(&self.handle, end, on_condition));
            if let Err(interrupted) = py.check_signals() {
                self.close(py);
                return Err(interrupted);
            }
            if stop != Stop::Signals {
                return Ok(stop);
            }
        }
    }

    /// Locks the state. The caller does not hold the interpreter, for which another thread with the lock waits.
    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    fn observation<T>(&self, using: impl FnOnce(&mut Observation) -> T) -> PyResult<T> {
        match &mut self.state().observation {
            Some(observation) => Ok(using(observation)),
            None => Err(error("the run keeps no records; start it with records=True")),
        }
    }
}

impl State {
    fn advance(&mut self, handle: &Handle, end: Nanos, on_condition: bool) -> Stop {
        let started = Instant::now();
        loop {
            let Some(lockstep) = &mut self.lockstep else {
                return Stop::End;
            };
            let next = next_instant(lockstep, handle);
            if next.is_none() && end == FOREVER {
                return Stop::Time;
            }
            // Without records nothing looks at the instants in between.
            let stride = if self.observation.is_some() { 0 } else { MAX_STRIDE };
            let next = next.unwrap_or(end).saturating_add(stride).min(end);
            let outcome = lockstep.run_until(next);
            let is_true = self.observe(handle);
            if outcome.is_some() {
                return Stop::End;
            }
            if on_condition && is_true {
                return Stop::Condition;
            }
            if next >= end {
                return Stop::Time;
            }
            if started.elapsed() > SIGNALS {
                return Stop::Signals;
            }
        }
    }

    /// Keeps what has changed at this instant. Returns whether the condition is true.
    fn observe(&mut self, handle: &Handle) -> bool {
        let observation = self.observation.as_mut();
        observation.is_some_and(|observation| observation.observe(handle.now()))
    }
}

/// Returns the time of the next instant at which anything is due.
fn next_instant(lockstep: &mut Lockstep, handle: &Handle) -> Option<Nanos> {
    lockstep.next_instant().or_else(|| {
        // What an operator has done since is processed at the present time, and may make a schema due.
        lockstep.run_until(handle.now());
        lockstep.next_instant()
    })
}
