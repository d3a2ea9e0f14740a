//! Applications: loaded and checked once, started many times.

use std::collections::BTreeMap;
use std::path::PathBuf;

use jde_abi::describe::Role;
use jde_app::{Application, Override};
use jde_conditions::Names;
use jde_core::Nanos;
use jde_experiment::Variant;
use jde_experiment::applications::Applications;
use jde_host::{Lockstep, Mock, Options, Running};
use jde_isolation::Program;
use parking_lot::{Mutex, MutexGuard};

use crate::Error;
use crate::names::LivePort;
use crate::run::Run;
use crate::state::Executor;
use jde_experiment::drive::EventQueue;

/// An application that was loaded and checked.
pub struct LoadedApplication {
    applications: Mutex<Applications>,
    overrides: Vec<Override>,
    /// The executable `jde`, which runs schemas in processes of their own.
    executable: Option<PathBuf>,
    mocks: Vec<String>,
}

/// How to start an application.
#[derive(Clone, Debug)]
pub struct StartOptions {
    /// Whether time passes only in [`Run::step`] and [`Run::until`].
    pub lockstep: bool,
    /// The seed in place of that of the file.
    pub seed: Option<u64>,
    /// The time at which the application ends, ns.
    pub limit: Option<Nanos>,
    /// Seconds of application time per second of machine time; real time only.
    pub speed: f64,
    /// Whether records, traces and conditions are available.
    pub records: bool,
    /// The name of the operator in records.
    pub operator: String,
}

impl Default for StartOptions {
    fn default() -> Self {
        Self {
            lockstep: false,
            seed: None,
            limit: None,
            speed: 1.0,
            records: true,
            operator: String::from("program"),
        }
    }
}

impl LoadedApplication {
    /// Loads the application of a file, with values in place of those in the file. The schemas in `mocks` are not
    /// called: the run writes what they export and command. The executable `jde` inspects plugins and runs isolated
    /// schemas; plugins are searched for beside it too.
    ///
    /// # Errors
    /// All faults of the file, each with its line.
    pub fn load(
        file: PathBuf,
        overrides: Vec<Override>,
        mocks: Vec<String>,
        executable: Option<PathBuf>,
    ) -> Result<Self, Error> {
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
        loaded.application()?;
        Ok(loaded)
    }

    /// Returns the application. It is not read again.
    ///
    /// # Errors
    /// None after [`Self::load`].
    pub fn application(&self) -> Result<Application, Error> {
        self.applications()
            .load(&self.overrides, &Variant::default())
            .map_err(Error::failed)
    }

    /// Returns the full names of the variables, and the names of their types.
    ///
    /// # Errors
    /// None after [`Self::load`].
    pub fn variables(&self) -> Result<BTreeMap<String, String>, Error> {
        let variables = Names::of(&self.application()?).variables.into_iter();
        Ok(variables
            .map(|(name, value_type)| (name, value_type.name.clone()))
            .collect())
    }

    /// Starts the application at time 0.
    ///
    /// # Errors
    /// Why it did not start.
    pub fn start(&self, options: &StartOptions) -> Result<Run, Error> {
        let mut application = self.application()?;
        application.seed = options.seed.unwrap_or(application.seed);
        let plugins = self.applications().plugins(&Variant::default());
        let (mocks, live) = self.mocks(&application);
        let events = options.records.then(EventQueue::default);
        let mut host = Options {
            limit: options.limit,
            speed: options.speed,
            isolation_program: self.executable.clone().map(Program::schema),
            mocks,
            ..Options::default()
        };
        if let Some(events) = &events {
            host.observers.push(Box::new(events.clone()));
        }
        if options.lockstep {
            let lockstep = Lockstep::start(application, &plugins, host).map_err(Error::failed)?;
            let handle = lockstep.handle();
            return Ok(Run::new(
                Executor::Lockstep(lockstep),
                &handle,
                live,
                events,
                options,
            ));
        }
        let running = Running::start(application, &plugins, host).map_err(Error::failed)?;
        let run = Run::new(Executor::AtRest, &running.handle(), live, events, options);
        run.attend(running)?;
        Ok(run)
    }

    /// Returns the mocks, and the ports that the run writes for them.
    fn mocks(&self, application: &Application) -> (Vec<(String, Mock)>, BTreeMap<String, LivePort>) {
        let (mut mocks, mut live) = (Vec::new(), BTreeMap::new());
        for schema in &self.mocks {
            let mut mock = Mock::default();
            // The start reports a schema that does not exist.
            let instance = application.instance(schema);
            let ports = instance.map_or(&[][..], |instance| &application.instances[instance].schema.ports);
            let written = |role: &Role| {
                matches!(
                    role,
                    Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. }
                )
            };
            for port in ports.iter().filter(|port| written(&port.role)) {
                let value = mock.live(&port.name);
                let value_type = port.value_type.clone();
                live.insert(format!("{schema}.{}", port.name), LivePort { value_type, value });
            }
            mocks.push((schema.clone(), mock));
        }
        (mocks, live)
    }

    fn applications(&self) -> MutexGuard<'_, Applications> {
        self.applications.lock()
    }
}
