//! Faults and reloads of C libraries that run in separate processes. Each test builds its libraries with
//! `cc`: one follows a null pointer, others replace each other.

use std::path::{Path, PathBuf};
use std::process::Command;

use jde_core::{Health, State};
use jde_host::reload::ReloadOptions;
use jde_loader::{LoadedPlugin, SearchPath};
use jde_records::event::{Event, Outcome};
use jde_records::reload::{CarriedMemory, Replacement};
use tempfile::TempDir;

use crate::common::{Executor, c, in_real_time, on_every_executor, plugins_along};
use crate::crashes::stage;
use crate::stage::Play;

on_every_executor!(
    a_plugin_in_c_that_follows_a_null_pointer_hurts_nobody_else,
    a_build_takes_over_in_a_fresh_process_and_goes_on_where_the_other_was,
    a_build_that_crashes_on_trial_gives_way_to_the_one_before_and_is_no_fault,
    the_one_that_waits_for_the_end_of_a_trial_may_die,
);

mod hanging {
    use super::*;

    in_real_time!(a_build_that_hangs_while_it_takes_over_is_killed_and_the_one_before_goes_on);
}

const APP: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "faller/faller"
    isolate = "process"
    restart = "never"
    hang = "250ms"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// The macros of one build of `faller.c`.
#[derive(Default)]
struct Build {
    speed: f64,
    falls: u32,
    hangs: bool,
    newer: bool,
}

/// An application whose schema `high` runs a library of this test.
struct Site {
    play: Play,
    folder: TempDir,
}

impl Site {
    /// Starts with speed 0.3. The library crashes in turn `falls`, or never if `falls` is 0.
    fn start(executor: Executor, falls: u32) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let build = Build {
            speed: 0.3,
            falls,
            ..Build::default()
        };
        build.make(&folder.path().join("libfaller.so"));
        let mut path = SearchPath::default();
        path.push(folder.path(), "of this test");
        let play = Play::with(executor, &stage(), APP, &plugins_along(path));
        Self { play, folder }
    }

    /// Replaces the library of `high` by another build and waits for the outcome. `probation` is in ms.
    fn reload(&mut self, build: &Build, probation: u64) -> Result<Replacement, String> {
        let file = self.folder.path().join("next.so");
        build.make(&file);
        let build = LoadedPlugin::open(&file).expect("it is right");
        let high = self.play.rig.place("high");
        let how = ReloadOptions {
            probation: probation * 1_000_000,
            fresh: false,
        };
        let reload = self.play.rig.operator().replace(high, &build, how);
        let reload = reload.expect("it fits");
        self.play.rig.until(|_| reload.outcome().is_some());
        reload.outcome().expect("it is there")
    }

    fn steps(&self) -> u32 {
        let steps = self.play.rig.handle.value::<u32>("high.steps");
        steps.expect("it is a number").unwrap_or_default()
    }

    fn until_steps(&mut self, more: u32) {
        let before = self.steps();
        let steps = |rig: &crate::common::Rig| rig.handle.value::<u32>("high.steps").ok().flatten();
        self.play
            .rig
            .until(|rig| steps(rig).is_some_and(|steps| steps >= before + more));
    }

    /// Returns how many faults of `high` were reported as events.
    fn faults(&self) -> usize {
        let high = self.play.rig.place("high");
        self.play.rig.stage.count_events(|event| {
            matches!(event, Event::HealthChanged { schema, health: Health::Faulted(_), .. } if *schema == high)
        })
    }
}

impl Build {
    fn make(&self, to: &Path) {
        let macros = [
            format!("-DSPEED={}", self.speed),
            format!("-DFALLS={}", self.falls),
            format!("-DHANGS={}", u8::from(self.hangs)),
            format!("-DNEWER={}", u8::from(self.newer)),
        ];
        c::make("faller.c", &macros, to);
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

fn a_plugin_in_c_that_follows_a_null_pointer_hurts_nobody_else(executor: Executor) {
    let mut site = Site::start(executor, 5);
    let process = site.play.process();
    assert_ne!(process, std::process::id());
    let reason = site.play.until_failed(1);
    assert_eq!(
        reason,
        "its process was killed by SIGSEGV (memory that is not its own)"
    );
    site.play.until_at(0.1);
    site.play.rig.until(|rig| rig.see("high").process.is_none());
    assert_eq!(site.steps(), 0, "nobody vouches for what it exported");
    let view = site.play.rig.see("high");
    assert_eq!((view.state, view.faults, view.left), (State::Slept, 1, 0));
    assert!(!proc(process).exists());
    assert_eq!(site.play.rig.stop(), Outcome::Stopped);
}

fn a_build_takes_over_in_a_fresh_process_and_goes_on_where_the_other_was(executor: Executor) {
    let mut site = Site::start(executor, 0);
    site.until_steps(5);
    let (first, before) = (site.play.process(), site.steps());
    let takeover = site
        .reload(
            &Build {
                newer: true,
                ..next()
            },
            50,
        )
        .expect("it takes over");
    assert_eq!(takeover.carried, Some(CarriedMemory { version: 1, bytes: 4 }));
    site.play.until_at(0.4);
    site.until_steps(2);
    assert!(site.steps() > before, "it counts on");
    assert_ne!(site.play.process(), first);
    // The previous process ends when the trial ends.
    site.until_steps(20);
    site.play.rig.until(|_| !proc(first).exists());
    assert_eq!(site.faults(), 0);
    assert_eq!(site.play.rig.stop(), Outcome::Stopped);
}

fn a_build_that_crashes_on_trial_gives_way_to_the_one_before_and_is_no_fault(executor: Executor) {
    let mut site = Site::start(executor, 0);
    site.until_steps(5);
    let (first, before) = (site.play.process(), site.steps());
    site.reload(&Build { falls: 3, ..next() }, 3000)
        .expect("it lives for two turns");
    let undone = |event: &Event| matches!(event, Event::ReloadRolledBack { reason, .. } if reason.starts_with("its process was killed by SIGSEGV"));
    site.play.rig.until(|rig| rig.stage.told(undone));
    site.play.until_at(0.3);
    site.until_steps(3);
    assert!(site.steps() > before, "it counts on");
    assert_eq!(site.play.process(), first);
    assert_eq!((site.faults(), site.play.rig.see("high").faults), (0, 0));
    assert_eq!(site.play.rig.stop(), Outcome::Stopped);
}

fn the_one_that_waits_for_the_end_of_a_trial_may_die(executor: Executor) {
    let mut site = Site::start(executor, 0);
    site.until_steps(5);
    let first = site.play.process();
    site.reload(&next(), 200).expect("it takes over");
    site.play.until_at(0.4);
    let killed = Command::new("kill").args(["-9", &first.to_string()]).status();
    assert!(killed.expect("kill runs").success());
    // The killed process is reaped at once, while the trial continues.
    site.play.rig.patiently(|_| !proc(first).exists());
    let on_trial = |rig: &crate::common::Rig| rig.see("high").reload.is_some_and(|reload| reload.on_trial);
    site.play.rig.until(|rig| !on_trial(rig));
    site.until_steps(3);
    assert_eq!((site.faults(), site.play.rig.see("high").faults), (0, 0));
    assert_eq!(site.play.rig.stop(), Outcome::Stopped);
}

fn a_build_that_hangs_while_it_takes_over_is_killed_and_the_one_before_goes_on(executor: Executor) {
    let mut site = Site::start(executor, 0);
    site.until_steps(5);
    let first = site.play.process();
    let refused = site
        .reload(
            &Build {
                hangs: true,
                ..next()
            },
            3000,
        )
        .expect_err("it never returns");
    assert!(refused.contains("has not returned from a call for "), "{refused}");
    site.until_steps(3);
    let view = site.play.rig.see("high");
    assert_eq!((view.process, view.left, view.faults), (Some(first), 0, 0));
    assert_eq!(site.faults(), 0);
    assert_eq!(site.play.rig.stop(), Outcome::Stopped);
}
