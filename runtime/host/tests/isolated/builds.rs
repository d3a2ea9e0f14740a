//! Faults and reloads of C libraries that run in separate processes. Each test builds its libraries with
//! `cc`: one dereferences a null pointer, others replace each other.

use std::path::{Path, PathBuf};
use std::process::Command;

use jde_core::{Health, State};
use jde_host::reload::ReloadOptions;
use jde_loader::{LoadedPlugin, SearchPath};
use jde_records::event::{Event, Outcome, What};
use jde_records::reload::{CarriedMemory, Replacement};
use tempfile::TempDir;

use crate::common::{Executor, c, in_real_time, on_every_executor, plugins_with};
use crate::crashes::scenario;
use crate::isolated_app::IsolatedApp;

on_every_executor!(
    a_segmentation_fault_in_a_c_plugin_affects_no_other_schema,
    a_new_build_continues_with_the_saved_memory_in_a_fresh_process,
    a_crash_on_trial_restores_the_previous_build_without_a_fault,
    the_process_of_the_previous_build_may_die_during_the_trial,
);

mod hanging {
    use super::*;

    in_real_time!(a_build_that_hangs_while_it_takes_over_is_killed_and_the_previous_build_continues);
}

const APP: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "crasher/crasher"
    isolate = "process"
    restart = "never"
    hang = "250ms"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// The macros of one build of `crasher.c`.
#[derive(Default)]
struct Build {
    speed: f64,
    crashes_at: u32,
    hangs: bool,
    more_ports: bool,
}

/// An application whose schema `high` runs a library of this test.
struct Fixture {
    isolated: IsolatedApp,
    folder: TempDir,
}

impl Fixture {
    /// Starts with speed 0.3. The library crashes in turn `crashes_at`, or never if that is 0.
    fn start(executor: Executor, crashes_at: u32) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let build = Build {
            speed: 0.3,
            crashes_at,
            ..Build::default()
        };
        build.compile(&folder.path().join("libcrasher.so"));
        let mut path = SearchPath::default();
        path.push(folder.path(), "of this test");
        let isolated = IsolatedApp::start_with(executor, &scenario(), APP, &plugins_with(path));
        Self { isolated, folder }
    }

    /// Replaces the library of `high` by another build and waits for the outcome. `probation` is in ms.
    fn reload(&mut self, build: &Build, probation: u64) -> Result<Replacement, String> {
        let file = self.folder.path().join("next.so");
        build.compile(&file);
        let build = LoadedPlugin::open(&file).expect("the library is valid");
        let high = self.isolated.app.index("high");
        let options = ReloadOptions {
            probation: probation * 1_000_000,
            fresh: false,
        };
        let reload = self.isolated.app.operator().replace(high, &build, options);
        let reload = reload.expect("the build is compatible");
        self.isolated.app.until_reloaded(&reload)
    }

    fn steps(&self) -> u32 {
        let steps = self.isolated.app.handle.value::<u32>("high.steps");
        steps.expect("it is a number").unwrap_or_default()
    }

    fn until_steps(&mut self, more: u32) {
        let before = self.steps();
        let steps = |app: &crate::common::TestApp| app.handle.value::<u32>("high.steps").ok().flatten();
        self.isolated
            .app
            .until(|app| steps(app).is_some_and(|steps| steps >= before + more));
    }

    /// Returns how many faults of `high` were reported as events.
    fn faults(&self) -> usize {
        let high = self.isolated.app.index("high");
        self.isolated.app.scenario.count_events(|event| {
            matches!(event.what(), Some(What::HealthChanged { schema, health: Health::Faulted(_), .. }) if *schema == high)
        })
    }
}

impl Build {
    fn compile(&self, to: &Path) {
        let macros = [
            format!("-DSPEED={}", self.speed),
            format!("-DCRASHES_AT={}", self.crashes_at),
            format!("-DHANGS={}", u8::from(self.hangs)),
            format!("-DMORE_PORTS={}", u8::from(self.more_ports)),
        ];
        c::build("crasher.c", &macros, to);
    }
}

/// A build that drives at 0.4.
fn next() -> Build {
    Build {
        speed: 0.4,
        ..Build::default()
    }
}

fn proc(process: u32) -> PathBuf {
    PathBuf::from(format!("/proc/{process}"))
}

fn a_segmentation_fault_in_a_c_plugin_affects_no_other_schema(executor: Executor) {
    let mut fixture = Fixture::start(executor, 5);
    let process = fixture.isolated.process();
    assert_ne!(process, std::process::id());
    let reason = fixture.isolated.until_failed(1);
    assert_eq!(
        reason,
        "its process was killed by SIGSEGV (memory that is not its own)"
    );
    fixture.isolated.until_at(0.1);
    fixture
        .isolated
        .app
        .until(|app| app.schema("high").process.is_none());
    assert_eq!(fixture.steps(), 0, "the exports of the process are retracted");
    let view = fixture.isolated.app.schema("high");
    assert_eq!((view.state, view.faults, view.left), (State::Slept, 1, 0));
    assert!(!proc(process).exists());
    assert_eq!(fixture.isolated.app.stop(), Outcome::Stopped);
}

fn a_new_build_continues_with_the_saved_memory_in_a_fresh_process(executor: Executor) {
    let mut fixture = Fixture::start(executor, 0);
    fixture.until_steps(5);
    let (first, before) = (fixture.isolated.process(), fixture.steps());
    let takeover = fixture
        .reload(
            &Build {
                more_ports: true,
                ..next()
            },
            50,
        )
        .expect("it takes over");
    assert_eq!(takeover.carried, Some(CarriedMemory { version: 1, bytes: 4 }));
    fixture.isolated.until_at(0.4);
    fixture.until_steps(2);
    assert!(fixture.steps() > before, "the count continues");
    assert_ne!(fixture.isolated.process(), first);
    // The previous process ends when the trial ends.
    fixture.until_steps(20);
    fixture.isolated.app.until(|_| !proc(first).exists());
    assert_eq!(fixture.faults(), 0);
    assert_eq!(fixture.isolated.app.stop(), Outcome::Stopped);
}

fn a_crash_on_trial_restores_the_previous_build_without_a_fault(executor: Executor) {
    let mut fixture = Fixture::start(executor, 0);
    fixture.until_steps(5);
    let (first, before) = (fixture.isolated.process(), fixture.steps());
    fixture
        .reload(
            &Build {
                crashes_at: 3,
                ..next()
            },
            3000,
        )
        .expect("the crash follows in the third turn");
    let rolled_back = |event: &Event| matches!(event.what(), Some(What::ReloadRolledBack { reason, .. }) if reason.starts_with("its process was killed by SIGSEGV"));
    fixture
        .isolated
        .app
        .until(|app| app.scenario.has_event(rolled_back));
    fixture.isolated.until_at(0.3);
    fixture.until_steps(3);
    assert!(fixture.steps() > before, "the count continues");
    assert_eq!(fixture.isolated.process(), first);
    assert_eq!(
        (fixture.faults(), fixture.isolated.app.schema("high").faults),
        (0, 0)
    );
    assert_eq!(fixture.isolated.app.stop(), Outcome::Stopped);
}

fn the_process_of_the_previous_build_may_die_during_the_trial(executor: Executor) {
    let mut fixture = Fixture::start(executor, 0);
    fixture.until_steps(5);
    let first = fixture.isolated.process();
    fixture.reload(&next(), 200).expect("it takes over");
    fixture.isolated.until_at(0.4);
    let killed = Command::new("kill").args(["-9", &first.to_string()]).status();
    assert!(killed.expect("kill runs").success());
    // The killed process is reaped at once, while the trial continues.
    fixture.isolated.app.until_unbounded(|_| !proc(first).exists());
    let on_trial =
        |app: &crate::common::TestApp| app.schema("high").reload.is_some_and(|reload| reload.on_trial);
    fixture.isolated.app.until(|app| !on_trial(app));
    fixture.until_steps(3);
    assert_eq!(
        (fixture.faults(), fixture.isolated.app.schema("high").faults),
        (0, 0)
    );
    assert_eq!(fixture.isolated.app.stop(), Outcome::Stopped);
}

fn a_build_that_hangs_while_it_takes_over_is_killed_and_the_previous_build_continues(executor: Executor) {
    let mut fixture = Fixture::start(executor, 0);
    fixture.until_steps(5);
    let first = fixture.isolated.process();
    let refused = fixture
        .reload(
            &Build {
                hangs: true,
                ..next()
            },
            3000,
        )
        .expect_err("it never returns");
    assert!(refused.contains("has not returned from a call for "), "{refused}");
    fixture.until_steps(3);
    let view = fixture.isolated.app.schema("high");
    assert_eq!((view.process, view.left, view.faults), (Some(first), 0, 0));
    assert_eq!(fixture.faults(), 0);
    assert_eq!(fixture.isolated.app.stop(), Outcome::Stopped);
}
