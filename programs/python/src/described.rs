//! A policy of a text file in training: what its schema would see, and what it would command. The numbers are computed by
//! the code of the schema.

use jde_abi::describe::Type;
use jde_app::{Binding, ImportSource};
use jde_board::value::Value;
use jde_board::{Latched, Reader};
use jde_embed::LivePort;
use jde_policy::{Observer, Values};
use jde_types::{Pose2D, Target, Twist, Value as _};
use parking_lot::Mutex;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::error;
use crate::runs::PythonRun;

/// The modulation of the text file.
const FILE_MODULATION: &str = "file";
/// The modulation of the target.
const TARGET_MODULATION: &str = "target";
/// The actuator.
const BASE_ACTUATOR: &str = "base";

/// A policy of a text file in one run, in the place of the schema that would drive with it.
#[pyclass(frozen, module = "jde", name = "PolicyFile")]
pub(crate) struct DescribedPolicy {
    run: Py<PythonRun>,
    policy: jde_policy::Policy,
    base: LivePort,
    state: Mutex<State>,
}

struct State {
    observer: Observer,
    /// The variables of the roles.
    readers: Vec<Reader>,
    target: Option<Reader>,
    /// What the last step lacked.
    lacks: Option<String>,
}

/// The values of one step.
struct Sensed<'a> {
    roles: Vec<Option<Latched<'a>>>,
    target: Option<Pose2D>,
}

impl Values for Sensed<'_> {
    fn role(&self, role: usize) -> Option<&[u8]> {
        self.roles[role].as_ref().map(|latched| latched.bytes)
    }

    fn target(&self) -> Option<Pose2D> {
        self.target
    }
}

#[pymethods]
impl DescribedPolicy {
    /// Reads the text file of a schema, a mock of type `policy/onnx`, and finds what the application gives it.
    #[new]
    fn new(run: Py<PythonRun>, schema: &str) -> PyResult<Self> {
        let running = &run.get().0;
        let application = running.handle().application();
        let instance = application.instance(schema).map(|id| &application.instances[id]);
        let instance = instance.ok_or_else(|| error(format!("no schema is called `{schema}`")))?;
        let file = running
            .value(&format!("{schema}.{FILE_MODULATION}.data"))
            .map_err(crate::run_error)?;
        let Some(Value::Text(file)) = file else {
            return Err(error(format!("`{schema}` names no text file of a policy")));
        };
        let policy = jde_policy::Policy::load_text(std::path::Path::new(&file))
            .map_err(|faults| error(format!("{faults:#}")))?;
        let first = instance.bindings.len() - instance.listed.len();
        let source = |role: &str| {
            let index = instance.listed.iter().position(|listed| listed.label == role);
            match index.map(|index| &instance.bindings[first + index]) {
                Some(Binding::Import {
                    source: Some(ImportSource::Local(port)),
                    ..
                }) => Ok(application.variable_name(*port)),
                _ => Err(error(format!(
                    "`{schema}` binds no variable of this application to `{role}`"
                ))),
            }
        };
        let mut variables = Vec::new();
        for role in policy.roles() {
            variables.push(running.find(&source(role)?).map_err(crate::run_error)?.0);
        }
        let types: Vec<&Type> = variables
            .iter()
            .map(|variable| &*variable.describe().value_type)
            .collect();
        let observer = policy.observer(&types).map_err(|wrong| {
            let words = wrong.iter().map(|(role, words)| format!("`{role}`: {words}"));
            error(words.collect::<Vec<_>>().join("; "))
        })?;
        let reader = |name: &str| running.find(name).map(|(variable, _)| variable.reader("policy"));
        let target = policy
            .sees_target()
            .then(|| reader(&format!("{schema}.{TARGET_MODULATION}")))
            .transpose();
        let (_, _, base) = running
            .find_live(&format!("{schema}.{BASE_ACTUATOR}"))
            .map_err(crate::run_error)?;
        let state = State {
            observer,
            readers: variables
                .iter()
                .map(|variable| variable.reader("policy"))
                .collect(),
            target: target.map_err(crate::run_error)?,
            lacks: None,
        };
        Ok(Self {
            base: base.clone(),
            policy,
            state: Mutex::new(state),
            run,
        })
    }

    /// The time of a step, s.
    #[getter]
    fn period(&self) -> f64 {
        self.policy.period()
    }

    /// The least and the greatest number of each number of an observation.
    fn observation_bounds(&self) -> Vec<(f32, f32)> {
        self.state.lock().observer.bounds()
    }

    /// Among how many commands the network chooses; `None` if it gives numbers of a command.
    #[getter]
    fn choices(&self) -> Option<usize> {
        self.policy.choices()
    }

    /// The least and the greatest number of the network for each number that it commands.
    fn action_bounds(&self) -> Vec<(f32, f32)> {
        self.policy.action_bounds()
    }

    /// Forgets what was before.
    fn reset(&self) {
        self.state.lock().observer.reset();
    }

    /// Returns the numbers of this step as 32-bit floats. Without a value of something they are those of the step before,
    /// and `lacks` says what is missing.
    fn observe<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let mut state = self.state.lock();
        state.observe(self.run.get().0.handle().now());
        let bytes: Vec<u8> = state
            .observer
            .numbers()
            .iter()
            .flat_map(|number| number.to_ne_bytes())
            .collect();
        PyByteArray::new(py, &bytes)
    }

    /// What the last step lacked; `None` if nothing.
    #[getter]
    fn lacks(&self) -> Option<String> {
        self.state.lock().lacks.clone()
    }

    /// Commands what numbers of a network are, and runs until a time, s. Returns whether the application goes on. A step
    /// that lacks something commands nothing, as the schema would.
    fn act(&self, py: Python<'_>, action: Vec<f64>, until: f64) -> PyResult<bool> {
        let mut state = self.state.lock();
        let command = match &state.lacks {
            Some(_) => [0.0; 3],
            None => self.policy.command(&action),
        };
        let [x, y, turn] = command;
        let mut twist = Twist::planar(x, turn);
        twist.linear.y = y;
        self.base.value.set(twist.as_bytes()).map_err(error)?;
        state.observer.commanded(command);
        drop(state);
        self.run.get().until_time(py, until)
    }

    /// Returns the numbers of a network that would have given a velocity: ahead and to the left, m/s, and the turn rate, rad/s;
    /// or the number of the choice that is nearest to it.
    fn action_of(&self, command: [f64; 3]) -> Vec<f64> {
        self.policy.action(command)
    }
}

impl State {
    fn observe(&mut self, now: jde_core::Nanos) {
        let roles = self.readers.iter_mut().map(|reader| {
            reader.release();
            reader.latch(now)
        });
        let roles = roles.collect();
        let target = self.target.as_mut().and_then(|reader| {
            let latched = reader.latch_newest(now)?;
            Target::from_bytes(latched.bytes)?.get()
        });
        self.lacks = self.observer.observe(&Sensed { roles, target }).err();
        if self.lacks.is_some() {
            self.observer.reset();
        }
    }
}
