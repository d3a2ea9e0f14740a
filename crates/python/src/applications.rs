//! Applications that Python runs: loaded and checked once, started many times.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

use jde_abi::describe::Role;
use jde_app::{Application, Override};
use jde_conditions::Names;
use jde_core::Nanos;
use jde_experiment::Variant;
use jde_experiment::applications::Applications;
use jde_experiment::drive::EventQueue;
use jde_host::{Lockstep, Mock, Options};
use jde_isolation::Program;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::runs::{LivePort, Run};
use crate::values::{as_text, from_python};
use crate::{error, lock, nanoseconds};

/// An application that was loaded and checked.
#[pyclass(frozen, module = "jde", name = "Application")]
pub(crate) struct LoadedApplication {
    applications: Mutex<Applications>,
    overrides: Vec<Override>,
    /// The executable `jde`, which runs schemas in processes of their own.
    executable: Option<PathBuf>,
    mocks: Vec<String>,
}

#[pymethods]
impl LoadedApplication {
    /// Loads the application of a file, with values in place of those in the file. The schemas in `mocks` are not
    /// called: the run writes what they export and command.
    #[new]
    #[pyo3(signature = (file, set=None, mocks=Vec::new(), executable=None))]
    fn new(
        py: Python<'_>,
        file: PathBuf,
        set: Option<&Bound<'_, PyDict>>,
        mocks: Vec<String>,
        executable: Option<PathBuf>,
    ) -> PyResult<Self> {
        let overrides = set.map_or(Ok(Vec::new()), overrides)?;
        let inspector = executable.clone().map(Program::inspections);
        let applications = Applications::new(file, inspector)
            .with_executable(executable.clone())
            .with_mocks(mocks.clone());
        let loaded = Self {
            applications: Mutex::new(applications),
            overrides,
            executable,
            mocks,
        };
        py.detach(|| loaded.load())?;
        Ok(loaded)
    }

    /// The name of the application.
    #[getter]
    fn name(&self) -> PyResult<String> {
        Ok(self.load()?.name)
    }

    /// The names of the schemas, in the order of the file.
    #[getter]
    fn schemas(&self) -> PyResult<Vec<String>> {
        let instances = self.load()?.instances.into_iter();
        Ok(instances.map(|instance| instance.name).collect())
    }

    /// The full names of the variables, and the names of their types.
    #[getter]
    fn variables(&self) -> PyResult<BTreeMap<String, String>> {
        let variables = Names::of(&self.load()?).variables.into_iter();
        Ok(variables
            .map(|(name, value_type)| (name, value_type.name.clone()))
            .collect())
    }

    /// Starts the application in lockstep, at time 0. Without `records`, decisions, events and traces are not
    /// kept, and conditions are not available.
    #[pyo3(signature = (seed=None, limit=None, records=true))]
    fn run(&self, py: Python<'_>, seed: Option<u64>, limit: Option<f64>, records: bool) -> PyResult<Run> {
        let limit = limit.map(nanoseconds).transpose()?;
        py.detach(|| self.start(seed, limit, records))
    }
}

impl LoadedApplication {
    fn load(&self) -> PyResult<Application> {
        let mut applications = lock(&self.applications);
        applications
            .load(&self.overrides, &Variant::default())
            .map_err(error)
    }

    fn start(&self, seed: Option<u64>, limit: Option<Nanos>, records: bool) -> PyResult<Run> {
        let mut application = self.load()?;
        application.seed = seed.unwrap_or(application.seed);
        let mut applications = lock(&self.applications);
        let plugins = applications.plugins(&Variant::default());
        drop(applications);
        let (mocks, live) = self.mocks(&application);
        let events = records.then(EventQueue::default);
        let mut options = Options {
            limit,
            isolation_program: self.executable.clone().map(Program::schema),
            mocks,
            ..Options::default()
        };
        if let Some(events) = &events {
            options.observers.push(Box::new(events.clone()));
        }
        let lockstep = Lockstep::start(application, &plugins, options).map_err(error)?;
        Ok(Run::new(lockstep, live, events))
    }

    /// Returns the mocks, and the ports that the run writes for them.
    fn mocks(&self, application: &Application) -> (Vec<(String, Mock)>, BTreeMap<String, LivePort>) {
        let (mut mocks, mut live) = (Vec::new(), BTreeMap::new());
        for schema in &self.mocks {
            let mut mock = Mock::default();
            // The start reports a schema that does not exist.
            let instance = application.instance(schema);
            let ports = instance.map_or(&[][..], |instance| &application.instances[instance].schema.ports);
            let written =
                |role: &Role| matches!(role, Role::Export | Role::Actuator | Role::ChildModulation { .. });
            for port in ports.iter().filter(|port| written(&port.role)) {
                let value = mock.live(&port.name);
                let value_type = port.value_type.clone();
                live.insert(format!("{schema}.{}", port.name), LivePort { value_type, value });
            }
            mocks.push((schema.clone(), mock));
        }
        (mocks, live)
    }
}

/// Reads values by the full names of their variables.
fn overrides(set: &Bound<'_, PyDict>) -> PyResult<Vec<Override>> {
    let read = set.iter().map(|(name, value)| {
        let text = format!("{}={}", name.extract::<String>()?, as_text(&from_python(&value)?));
        text.parse().map_err(error)
    });
    read.collect()
}
