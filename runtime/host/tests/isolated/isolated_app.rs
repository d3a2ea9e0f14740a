//! Runs an application whose schema `high` is faulty and has a process of its own.

use std::path::Path;
use std::sync::Arc;

use jde_app::parse;
use jde_board::Watch;
use jde_board::value::Value;
use jde_core::Health;
use jde_host::{Options, StartError};
use jde_isolation::Program;
use jde_loader::Plugins;
use jde_records::event::{Event, Occurrence, What};
use parking_lot::{RwLock, RwLockReadGuard};

use crate::common::{Executor, Scenario, TestApp, plugins, text};
use crate::faulty::FAULTY;

/// Held for reading while an application runs, and for writing by tests that count resources of the whole
/// process.
pub(crate) static RUNNING: RwLock<()> = RwLock::new(());

/// Makes the test harness run the one test of this exact name.
pub(crate) const BY_NAME: &str = "--exact";

/// A running application and its read lock of [`RUNNING`].
pub(crate) struct IsolatedApp {
    pub(crate) app: TestApp,
    /// Each write of a variable makes waiting tests check their conditions again.
    _watches: Vec<Watch>,
    _running: Option<RwLockReadGuard<'static, ()>>,
}

/// This program as the executable of one schema's process.
pub(crate) fn program() -> Program {
    program_of("served")
}

fn program_of(entry: &str) -> Program {
    Program {
        path: std::env::current_exe().expect("this program has a file"),
        arguments: [BY_NAME, entry, "--nocapture", "--quiet"]
            .map(Into::into)
            .to_vec(),
    }
}

pub(crate) fn all_plugins() -> Plugins {
    let mut plugins = plugins();
    plugins.link(&FAULTY).expect("the plugin is valid");
    plugins
}

impl IsolatedApp {
    /// Starts an application and takes a read lock of [`RUNNING`].
    #[track_caller]
    pub(crate) fn start(executor: Executor, scenario: &Arc<Scenario>, body: &str) -> Self {
        let running = RUNNING.read();
        let mut isolated = Self::start_unlocked(executor, scenario, body);
        isolated._running = Some(running);
        isolated
    }

    /// As [`Self::start`], with a child that breaks the protocol.
    #[track_caller]
    pub(crate) fn start_forged(executor: Executor, scenario: &Arc<Scenario>, body: &str) -> Self {
        let running = RUNNING.read();
        let app = Self::try_start(executor, scenario, body, Some(program_of("forged")));
        let mut isolated = Self::watch_variables(scenario, app);
        isolated._running = Some(running);
        isolated
    }

    /// Starts without a lock, for a test that holds [`RUNNING`] for writing.
    #[track_caller]
    pub(crate) fn start_unlocked(executor: Executor, scenario: &Arc<Scenario>, body: &str) -> Self {
        Self::watch_variables(
            scenario,
            Self::try_start(executor, scenario, body, Some(program())),
        )
    }

    /// As [`Self::start`], with the given plugins.
    #[track_caller]
    pub(crate) fn start_with(
        executor: Executor,
        scenario: &Arc<Scenario>,
        body: &str,
        plugins: &Plugins,
    ) -> Self {
        let running = RUNNING.read();
        let app = Self::run(executor, scenario, body, plugins, Some(program()));
        let mut isolated = Self::watch_variables(scenario, app);
        isolated._running = Some(running);
        isolated
    }

    #[track_caller]
    fn watch_variables(scenario: &Arc<Scenario>, app: Result<TestApp, StartError>) -> Self {
        let app = app.unwrap_or_else(|error| panic!("{error}"));
        let watches = app.handle.board().list().map(|variable| {
            let scenario = Arc::clone(scenario);
            variable.watch(move || scenario.notify())
        });
        Self {
            _watches: watches.collect(),
            app,
            _running: None,
        }
    }

    /// Starts without a lock, and returns the error if the start fails.
    pub(crate) fn try_start(
        executor: Executor,
        scenario: &Arc<Scenario>,
        body: &str,
        program_of_schemas: Option<Program>,
    ) -> Result<TestApp, StartError> {
        Self::run(executor, scenario, body, &all_plugins(), program_of_schemas)
    }

    fn run(
        executor: Executor,
        scenario: &Arc<Scenario>,
        body: &str,
        plugins: &Plugins,
        program_of_schemas: Option<Program>,
    ) -> Result<TestApp, StartError> {
        let text = text(executor, scenario, body);
        let application = parse(&text, Path::new("apps/test.toml"), &[], plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let options = Options {
            isolation_program: program_of_schemas,
            ..Options::default()
        };
        TestApp::run(executor, scenario, application, plugins, options)
    }

    /// Selects the misbehaviour of `high`.
    #[track_caller]
    pub(crate) fn trouble(&self, trouble: u32) {
        let high = self.app.index("high");
        let trouble = Value::UInt(u64::from(trouble));
        self.app
            .operator()
            .modulate(high, "trouble", &trouble)
            .expect("the modulation is written");
    }

    /// Returns the process id of `high`.
    #[track_caller]
    pub(crate) fn process(&self) -> u32 {
        self.app.schema("high").process.expect("it has a process")
    }

    /// Returns the newest value of a numeric export of `high`.
    pub(crate) fn number(&self, variable: &str) -> Option<f64> {
        let name = format!("high.{variable}");
        self.app.handle.value::<f64>(&name).expect("it is a number")
    }

    /// Runs until the robot receives this speed.
    #[track_caller]
    pub(crate) fn until_at(&mut self, speed: f64) {
        let expected = format!("robot velocity {speed}");
        self.app.until(|app| {
            let lines = app.scenario.lines();
            let mut speeds = lines
                .iter()
                .rev()
                .filter(|line| line.starts_with("robot velocity"));
            speeds.next() == Some(&expected)
        });
    }

    /// Runs until `high` has failed this many times. Returns the reason of the last of these failures.
    #[track_caller]
    pub(crate) fn until_failed(&mut self, times: usize) -> String {
        let high = self.app.index("high");
        let failures = |app: &TestApp| -> Vec<String> {
            let events = app.scenario.events().into_iter();
            let reasons = events.filter_map(|event| match event {
                Event::Other(Occurrence {
                    what:
                        What::HealthChanged {
                            schema,
                            health: Health::Faulted(reason),
                            ..
                        },
                    ..
                }) if schema == high => Some(reason),
                _ => None,
            });
            reasons.collect()
        };
        self.app.until(|app| failures(app).len() >= times);
        failures(&self.app).swap_remove(times - 1)
    }
}
