//! Runs an application whose schema `high`, of the type of these tests, has a process of its own.

use std::path::Path;
use std::sync::{Arc, RwLock, RwLockReadGuard};

use jde_app::parse;
use jde_board::Watch;
use jde_board::value::Value;
use jde_core::Health;
use jde_host::{Options, StartError};
use jde_isolation::Program;
use jde_loader::Plugins;
use jde_records::event::Event;

use crate::common::{Executor, Rig, Stage, plugins, text};
use crate::odd::ODD;

/// Held for reading while an application runs, and for writing by tests that count resources of the whole
/// process.
pub(crate) static RUNNING: RwLock<()> = RwLock::new(());

/// Makes the test harness run the one test of this exact name.
pub(crate) const BY_NAME: &str = "--exact";

/// A running application and its read lock of [`RUNNING`].
pub(crate) struct Play {
    pub(crate) rig: Rig,
    /// Each write of any variable makes waiting tests look again.
    _watches: Vec<Watch>,
    _among: Option<RwLockReadGuard<'static, ()>>,
}

/// This program as the executable of one schema's process.
pub(crate) fn program() -> Program {
    Program {
        path: std::env::current_exe().expect("this program has a file"),
        arguments: [BY_NAME, "served", "--nocapture", "--quiet"]
            .map(Into::into)
            .to_vec(),
    }
}

pub(crate) fn all_plugins() -> Plugins {
    let mut plugins = plugins();
    plugins.link(&ODD).expect("the plugin is right");
    plugins
}

impl Play {
    /// Starts an application and takes a read lock of [`RUNNING`].
    #[track_caller]
    pub(crate) fn start(executor: Executor, stage: &Arc<Stage>, body: &str) -> Self {
        let among = RUNNING.read().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut play = Self::alone(executor, stage, body);
        play._among = Some(among);
        play
    }

    /// Starts without a lock, for a test that holds [`RUNNING`] for writing.
    #[track_caller]
    pub(crate) fn alone(executor: Executor, stage: &Arc<Stage>, body: &str) -> Self {
        Self::watched(stage, Self::try_start(executor, stage, body, Some(program())))
    }

    /// As [`Self::start`], with the given plugins.
    #[track_caller]
    pub(crate) fn with(executor: Executor, stage: &Arc<Stage>, body: &str, plugins: &Plugins) -> Self {
        let among = RUNNING.read().unwrap_or_else(std::sync::PoisonError::into_inner);
        let rig = Self::run(executor, stage, body, plugins, Some(program()));
        let mut play = Self::watched(stage, rig);
        play._among = Some(among);
        play
    }

    #[track_caller]
    fn watched(stage: &Arc<Stage>, rig: Result<Rig, StartError>) -> Self {
        let rig = rig.unwrap_or_else(|error| panic!("{error}"));
        let watches = rig.handle.board().list().map(|variable| {
            let stage = Arc::clone(stage);
            variable.watch(move || stage.stir())
        });
        Self {
            _watches: watches.collect(),
            rig,
            _among: None,
        }
    }

    /// Starts without a lock, and returns the error if the start fails.
    pub(crate) fn try_start(
        executor: Executor,
        stage: &Arc<Stage>,
        body: &str,
        apart: Option<Program>,
    ) -> Result<Rig, StartError> {
        Self::run(executor, stage, body, &all_plugins(), apart)
    }

    fn run(
        executor: Executor,
        stage: &Arc<Stage>,
        body: &str,
        plugins: &Plugins,
        apart: Option<Program>,
    ) -> Result<Rig, StartError> {
        let text = text(executor, stage, body);
        let application = parse(&text, Path::new("apps/test.toml"), &[], plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let options = Options {
            isolation_program: apart,
            ..Options::default()
        };
        Rig::run(executor, stage, application, plugins, options)
    }

    /// Selects the misbehaviour of `high`.
    #[track_caller]
    pub(crate) fn trouble(&self, trouble: u32) {
        let high = self.rig.place("high");
        let trouble = Value::UInt(u64::from(trouble));
        self.rig
            .operator()
            .modulate(high, "trouble", &trouble)
            .expect("it is written");
    }

    /// Returns the process id of `high`.
    #[track_caller]
    pub(crate) fn process(&self) -> u32 {
        self.rig.see("high").process.expect("it has one")
    }

    /// Returns the newest value of a numeric export of `high`.
    pub(crate) fn number(&self, variable: &str) -> Option<f64> {
        let name = format!("high.{variable}");
        self.rig.handle.value::<f64>(&name).expect("it is a number")
    }

    /// Runs until the robot receives this speed.
    #[track_caller]
    pub(crate) fn until_at(&mut self, speed: f64) {
        let wanted = format!("robot velocity {speed}");
        self.rig.until(|rig| {
            let lines = rig.stage.lines();
            let mut speeds = lines
                .iter()
                .rev()
                .filter(|line| line.starts_with("robot velocity"));
            speeds.next() == Some(&wanted)
        });
    }

    /// Runs until `high` has failed this many times. Returns the reason of the last of these failures.
    #[track_caller]
    pub(crate) fn until_failed(&mut self, times: usize) -> String {
        let high = self.rig.place("high");
        let failures = |rig: &Rig| -> Vec<String> {
            let events = rig.stage.events().into_iter();
            let reasons = events.filter_map(|event| match event {
                Event::HealthChanged {
                    schema,
                    health: Health::Faulted(reason),
                    ..
                } if schema == high => Some(reason),
                _ => None,
            });
            reasons.collect()
        };
        self.rig.until(|rig| failures(rig).len() >= times);
        failures(&self.rig).swap_remove(times - 1)
    }
}
