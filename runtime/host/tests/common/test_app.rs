//! Runs an application of the tests on any executor.

use std::path::Path;
use std::sync::Arc;

use jde_app::{Application, parse};
use jde_core::{Id, SchemaId};
use jde_host::reload::PendingReload;
use jde_host::{Handle, Lockstep, OperatorHandle, Options, Running, StartError};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::{Event, Observer, Outcome};
use jde_records::reload::Replacement;
use jde_records::snapshot::{GroupView, SchemaView};
use jde_watchdog::{DEFAULT_LIMIT, Watchdog};

use super::MS;
use super::language::Language;
use super::python;
use super::scenario::Scenario;

/// The time within which a condition must become true in lockstep, ns: far beyond every period of the tests.
const MAX_WAIT: u64 = 10_000 * MS;

/// The executor of the schemas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Executor {
    Threads,
    Pool,
    Lockstep,
}

/// A running application.
pub(crate) struct TestApp {
    pub(crate) scenario: Arc<Scenario>,
    pub(crate) handle: Handle,
    run: Run,
    _watchdog: Watchdog,
}

enum Run {
    Real(Running),
    Lockstep(Box<Lockstep>),
}

/// The plugins of the tests.
pub(crate) fn plugins() -> Plugins {
    plugins_with(SearchPath::default())
}

/// The plugins of the tests, and those in these folders.
pub(crate) fn plugins_with(path: SearchPath) -> Plugins {
    let language = Language::of_test();
    let mut plugins = match language {
        Language::Python => python::plugins(path),
        _ => Plugins::new(path),
    };
    plugins
        .link(language.plugin())
        .expect("the plugin of the tests is valid");
    plugins
}

/// The text of an application for an executor and a scenario.
pub(crate) fn text(executor: Executor, scenario: &Scenario, body: &str) -> String {
    let head = match executor {
        Executor::Threads | Executor::Lockstep => "",
        Executor::Pool => "executor = \"pool\"\n",
    };
    let mut text = String::from(head);
    for line in body.lines() {
        text += &Language::of_test().type_line(line);
        text += "\n";
        if line.trim_start().starts_with("type") && line.contains("\"test/") {
            text += &format!("scenario = {}\n", scenario.number());
        }
    }
    text
}

impl TestApp {
    /// Starts an application of the test plugin.
    #[track_caller]
    pub(crate) fn start(executor: Executor, scenario: &Arc<Scenario>, body: &str) -> Self {
        Self::start_with(executor, scenario, body, Options::default())
    }

    /// Like [`Self::start`], with options.
    #[track_caller]
    pub(crate) fn start_with(
        executor: Executor,
        scenario: &Arc<Scenario>,
        body: &str,
        options: Options,
    ) -> Self {
        match Self::try_start(executor, scenario, body, options) {
            Ok(app) => app,
            Err(error) => panic!("{error}"),
        }
    }

    /// Like [`Self::start_with`], for applications that may fail to start.
    #[track_caller]
    pub(crate) fn try_start(
        executor: Executor,
        scenario: &Arc<Scenario>,
        body: &str,
        options: Options,
    ) -> Result<Self, StartError> {
        let plugins = plugins();
        let application = parse(
            &text(executor, scenario, body),
            Path::new("apps/test.toml"),
            &[],
            &plugins,
        )
        .unwrap_or_else(|faults| panic!("{faults}"));
        Self::run(executor, scenario, application, &plugins, options)
    }

    /// Starts a parsed application.
    #[track_caller]
    pub(crate) fn run(
        executor: Executor,
        scenario: &Arc<Scenario>,
        application: Application,
        plugins: &Plugins,
        mut options: Options,
    ) -> Result<Self, StartError> {
        let watched = Arc::clone(scenario);
        let watchdog = Watchdog::new(DEFAULT_LIMIT, move || watched.report());
        let recorder = Arc::clone(scenario);
        let observer: Box<dyn Observer> = Box::new(move |event: &Event| recorder.record_event(event));
        options.observers.push(observer);
        let (run, handle) = match executor {
            Executor::Threads | Executor::Pool => {
                let running = Running::start(application, plugins, options)?;
                let handle = running.handle();
                (Run::Real(running), handle)
            }
            Executor::Lockstep => {
                let lockstep = Lockstep::start(application, plugins, options)?;
                let handle = lockstep.handle();
                (Run::Lockstep(Box::new(lockstep)), handle)
            }
        };
        scenario.set_handle(handle.clone());
        Ok(Self {
            scenario: Arc::clone(scenario),
            handle,
            run,
            _watchdog: watchdog,
        })
    }

    /// Runs until `done`.
    #[track_caller]
    pub(crate) fn until(&mut self, mut done: impl FnMut(&Self) -> bool) {
        if let Run::Real(_) = self.run {
            let scenario = Arc::clone(&self.scenario);
            return scenario.wait_until(|| done(self));
        }
        let start = self.handle.now();
        while !done(self) {
            let now = self.handle.now();
            assert!(
                now < start + MAX_WAIT,
                "the condition never became true: {:#?}",
                self.scenario.lines()
            );
            self.advance(now + MS);
        }
    }

    /// Runs until the outcome of a reload is known. The scenario has no entry for it.
    pub(crate) fn until_reloaded(&mut self, reload: &PendingReload) -> Result<Replacement, String> {
        if let Run::Lockstep(_) = self.run {
            self.until(|_| reload.outcome().is_some());
        }
        // The watchdog ends the test before.
        let outcome = reload.wait(2 * DEFAULT_LIMIT);
        outcome.expect("the reload ends")
    }

    /// Runs until `done`, without a limit in virtual time. For conditions that depend on the machine's time
    /// even in lockstep, such as the rate of a panel.
    pub(crate) fn until_unbounded(&mut self, mut done: impl FnMut(&Self) -> bool) {
        if let Run::Real(_) = self.run {
            return self.until(done);
        }
        while !done(self) {
            self.advance(self.handle.now() + MS);
        }
    }

    /// Runs until the line has been recorded.
    #[track_caller]
    pub(crate) fn until_line(&mut self, line: &str) {
        self.until(|app| app.scenario.has_line(line));
    }

    /// Runs until virtual time is `then`. Lockstep only.
    pub(crate) fn advance(&mut self, then: u64) -> Option<Outcome> {
        match &mut self.run {
            Run::Lockstep(lockstep) => lockstep.run_until(then),
            Run::Real(_) => panic!("only virtual time can be advanced"),
        }
    }

    /// Requests the end, and waits until the application has ended.
    pub(crate) fn stop(self) -> Outcome {
        self.handle.stop();
        self.wait()
    }

    /// Runs until the application ends by itself.
    pub(crate) fn wait(self) -> Outcome {
        let Self { run, _watchdog, .. } = self;
        match run {
            Run::Real(running) => running.wait(),
            Run::Lockstep(lockstep) => lockstep.run(),
        }
    }

    /// The instance of that name.
    #[track_caller]
    pub(crate) fn index(&self, name: &str) -> SchemaId {
        let index = self.handle.application().instance(name);
        index.unwrap_or_else(|| panic!("there is no {name}"))
    }

    /// An instance as tools see it.
    #[track_caller]
    pub(crate) fn schema(&self, name: &str) -> SchemaView {
        self.handle
            .snapshot()
            .schemas
            .swap_remove(self.index(name).index())
    }

    /// An operator of the application.
    pub(crate) fn operator(&self) -> OperatorHandle {
        self.handle.operator("ana@laptop")
    }

    /// A group as tools see it.
    #[track_caller]
    pub(crate) fn group(&self, name: &str) -> GroupView {
        let groups = self.handle.snapshot().groups.into_iter();
        let mut found = groups.filter(|group| group.name == name);
        found.next().unwrap_or_else(|| panic!("there is no {name}"))
    }

    /// The winner of a group.
    #[track_caller]
    pub(crate) fn winner(&self, group: &str) -> Option<String> {
        let winner = self.group(group).winner?;
        Some(
            self.handle.application().instances[SchemaId::new(winner)]
                .name
                .clone(),
        )
    }
}
