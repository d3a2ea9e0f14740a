//! One way to run an application with the schema of these tests in a process of its own.

use std::path::Path;
use std::sync::{Arc, RwLock, RwLockReadGuard};

use jde_board::Watch;
use jde_board::value::Value;
use jde_core::Health;
use jde_host::apart::Program;
use jde_host::app::parse;
use jde_host::event::Event;
use jde_host::plugin::Plugins;
use jde_host::{Options, StartError};

use crate::common::{Executor, Rig, Stage, plugins, text};
use crate::odd::ODD;

/// Held while an application runs; alone by who counts what the whole process has.
pub(crate) static RUNNING: RwLock<()> = RwLock::new(());

/// Has the harness of tests run one by its whole name.
pub(crate) const BY_NAME: &str = "--exact";

/// An application that runs, with its place among the others.
pub(crate) struct Play {
    pub(crate) rig: Rig,
    /// Whoever waits looks again when anybody writes anything.
    _watches: Vec<Watch>,
    _among: Option<RwLockReadGuard<'static, ()>>,
}

/// This program as the process of one schema.
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
    /// Starts it.
    #[track_caller]
    pub(crate) fn start(executor: Executor, stage: &Arc<Stage>, body: &str) -> Self {
        let among = RUNNING.read().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut play = Self::alone(executor, stage, body);
        play._among = Some(among);
        play
    }

    /// The same, for who holds the place alone.
    #[track_caller]
    pub(crate) fn alone(executor: Executor, stage: &Arc<Stage>, body: &str) -> Self {
        Self::watched(stage, Self::try_start(executor, stage, body, Some(program())))
    }

    /// As [`Self::start`], with these plugins.
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

    /// The same, where it may not start.
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
            apart,
            ..Options::default()
        };
        Rig::run(executor, stage, application, plugins, options)
    }

    /// Tells `high` what trouble to make.
    #[track_caller]
    pub(crate) fn trouble(&self, trouble: u32) {
        let high = self.rig.place("high");
        let trouble = Value::UInt(u64::from(trouble));
        self.rig
            .operator()
            .modulate(high, "trouble", &trouble)
            .expect("it is written");
    }

    /// The number of the process of `high`.
    #[track_caller]
    pub(crate) fn process(&self) -> u32 {
        self.rig.see("high").process.expect("it has one")
    }

    /// The newest of the numbers that `high` exports.
    pub(crate) fn number(&self, variable: &str) -> Option<f64> {
        let name = format!("high.{variable}");
        self.rig.handle.value::<f64>(&name).expect("it is a number")
    }

    /// Goes on until the robot drives at that speed.
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

    /// Goes on until `high` has failed so often, and answers why it did then.
    #[track_caller]
    pub(crate) fn until_failed(&mut self, times: usize) -> String {
        let high = self.rig.place("high");
        let failures = |rig: &Rig| -> Vec<String> {
            let events = rig.stage.events().into_iter();
            let reasons = events.filter_map(|event| match event {
                Event::Health {
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
