//! Files of plugins that change while an application runs. The libraries are real and built by `cc`; the
//! builds differ in the speed that they command.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use jde_app::parse;
use jde_core::State;
use jde_host::reload::{ReloadError, ReloadOptions, Reloader};
use jde_host::{Options, Running};
use jde_loader::{MAX_BUILDS, PluginError, Plugins};
use jde_records::event::Event;
use jde_records::reload::ReloadOutcome;
use jde_types::Twist;
use jde_watchdog::Watchdog;
use parking_lot::{Mutex, MutexGuard};
use tempfile::TempDir;

use common::{Executor, Scenario};

/// The speed in the library as `cc` built it; [`build`] replaces these bytes.
const SPEED: f64 = 0.123_456_789_012_345_67;

const APP: &str = r#"
    roots = ["counter"]
    [schemas.robot]
    type = "test/robot"
    [schemas.counter]
    type = "counter/counter"
    restart = "never"
    actuators = { base = "robot.velocity" }
"#;

/// The bytes of the library as `cc` built it.
fn library(plugin: &str, schema: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let to = folder.path().join("library.so");
    let macros = [format!("-DPLUGIN=\"{plugin}\""), format!("-DTYPE=\"{schema}\"")];
    common::c::build("counter.c", &macros, &to);
    fs::read(&to).expect("it was built")
}

/// Returns the library with this speed.
fn build(speed: f64) -> Vec<u8> {
    static LIBRARY: OnceLock<Vec<u8>> = OnceLock::new();
    let mut bytes = LIBRARY.get_or_init(|| library("counter", "counter")).clone();
    let positions: Vec<_> = (0..bytes.len() - 8)
        .filter(|&position| bytes[position..position + 8] == SPEED.to_ne_bytes())
        .collect();
    assert_eq!(positions.len(), 1, "the speed occurs once");
    bytes[positions[0]..positions[0] + 8].copy_from_slice(&speed.to_ne_bytes());
    bytes
}

/// Serializes the tests, which measure the whole process.
fn run_alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock()
}

/// A running application whose schema `counter` uses a library of this test.
struct Fixture {
    _alone: MutexGuard<'static, ()>,
    folder: TempDir,
    scenario: Arc<Scenario>,
    plugins: Arc<Plugins>,
    running: Running,
    _watchdog: Watchdog,
}

impl Fixture {
    fn start(speed: f64) -> Self {
        let alone = run_alone();
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(file(&folder), build(speed)).expect("it is written");
        let scenario = Scenario::new();
        let mut path = jde_loader::SearchPath::default();
        path.push(folder.path(), "of this test");
        let plugins = common::plugins_with(path);
        let text = common::text(Executor::Threads, &scenario, APP);
        let application = parse(&text, Path::new("apps/test.toml"), &[], &plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let recorder = Arc::clone(&scenario);
        let mut options = Options::default();
        options
            .observers
            .push(Box::new(move |event: &Event| recorder.record_event(event)));
        let running =
            Running::start(application, &plugins, options).unwrap_or_else(|error| panic!("{error}"));
        Self {
            _alone: alone,
            folder,
            scenario,
            plugins: Arc::new(plugins),
            running,
            _watchdog: Watchdog::for_test(),
        }
    }

    fn reloader(&self) -> Reloader {
        Reloader::new(self.running.handle(), Arc::clone(&self.plugins))
    }

    /// Replaces the file by a new one, as a linker does.
    fn write(&self, bytes: &[u8]) {
        let temporary = self.folder.path().join("new");
        fs::write(&temporary, bytes).expect("it is written");
        fs::rename(temporary, file(&self.folder)).expect("it is renamed");
    }

    fn until_commanded(&self, speed: f64) {
        let line = format!("robot velocity {speed}");
        self.scenario.wait_until(|| self.scenario.has_line(&line));
    }
}

fn file(folder: &TempDir) -> PathBuf {
    folder.path().join("libcounter.so")
}

fn state(fixture: &Fixture) -> State {
    let snapshot = fixture.running.handle().snapshot();
    let counter = snapshot.schemas.iter().find(|schema| schema.name == "counter");
    counter.expect("the counter exists").state
}

/// Returns the resident memory of this process, bytes.
fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("this is Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.expect("a number of kB") << 10
}

#[test]
fn fifty_changed_files_are_reloaded_while_the_robot_drives() {
    let fixture = Fixture::start(1.0);
    let reloader = fixture.reloader();
    fixture.until_commanded(1.0);
    let before = resident();
    let mut carried = Vec::new();
    for round in 1..=50_u32 {
        let speed = 1.0 + f64::from(round) / 64.0;
        fixture.write(&build(speed));
        let reloaded = reloader
            .reload("ana@laptop", "counter", ReloadOptions::default())
            .unwrap_or_else(|refused| panic!("{refused}"));
        let [(name, ReloadOutcome::Reloaded(takeover))] = &reloaded.schemas[..] else {
            panic!("{reloaded:?}");
        };
        assert_eq!((name.as_str(), reloaded.is_done()), ("counter", true));
        assert_eq!(reloaded.memory.builds, round as usize);
        assert!(takeover.gap.is_some());
        carried.push(takeover.carried.expect("the count was carried over").bytes);
        fixture.until_commanded(speed);
    }
    assert_eq!(carried, [4; 50]);
    assert!(
        !fixture.scenario.has_line("robot velocity 0"),
        "the robot never stopped"
    );
    assert_eq!(state(&fixture), State::Winner);
    let handle = fixture.running.handle();
    let steps = handle
        .value::<u32>("counter.steps")
        .expect("a number")
        .expect("it has counted");
    let faults: u64 = handle.snapshot().schemas.iter().map(|schema| schema.faults).sum();
    assert!(steps > 50, "the count continues");
    assert_eq!(faults, 0);
    let commanded = handle.value::<Twist>("robot.velocity").expect("a twist");
    assert_eq!(commanded.expect("it is commanded").linear.x, 1.0 + 50.0 / 64.0);
    // The library of each build remains loaded: some of its pages, and the data of the system's loader.
    let grown = resident().saturating_sub(before);
    let library = build(1.0).len() as u64;
    assert!(
        grown < 50 * (library + (128 << 10)),
        "{} kB for 50 libraries of {} kB",
        grown >> 10,
        library >> 10
    );
}

#[test]
fn a_faulted_schema_restarts_when_the_same_build_is_reloaded() {
    let fixture = Fixture::start(-1.0);
    let faults = || {
        let snapshot = fixture.running.handle().snapshot();
        let counter = snapshot
            .schemas
            .into_iter()
            .find(|schema| schema.name == "counter");
        counter.expect("the counter exists").faults
    };
    for fault in 1..=3 {
        fixture.scenario.wait_until(|| faults() == fault);
        assert_eq!(state(&fixture), State::Slept);
        let reloaded = fixture
            .reloader()
            .reload("ana@laptop", "counter", ReloadOptions::default());
        let reloaded = reloaded.unwrap_or_else(|refused| panic!("{refused}"));
        assert_eq!(
            reloaded.schemas,
            [("counter".to_owned(), ReloadOutcome::Restarted)]
        );
        assert!(reloaded.is_done());
    }
    fixture.scenario.wait_until(|| faults() == 4);
}

#[test]
fn a_file_with_the_content_of_an_earlier_build_takes_no_more_memory() {
    let fixture = Fixture::start(1.0);
    let reloader = fixture.reloader();
    let reload = || {
        let reloaded = reloader.reload("ana", "counter", ReloadOptions::default());
        let reloaded = reloaded.unwrap_or_else(|refused| panic!("{refused}"));
        let outcome = reloaded.schemas.into_iter().map(|(_, outcome)| outcome).next();
        (outcome.expect("one"), reloaded.memory.builds)
    };
    assert_eq!(reload(), (ReloadOutcome::Unchanged, 0));
    for speed in [2.0, 1.0, 2.0, 1.0] {
        fixture.write(&build(speed));
        let (outcome, builds) = reload();
        assert!(matches!(outcome, ReloadOutcome::Reloaded(_)), "{outcome:?}");
        assert_eq!(builds, 1);
        fixture.until_commanded(speed);
    }
    fixture.write(&build(1.0));
    assert_eq!(reload(), (ReloadOutcome::Unchanged, 1));
}

#[test]
fn an_unusable_file_is_refused_and_the_robot_drives_on() {
    let fixture = Fixture::start(1.0);
    let reloader = fixture.reloader();
    fixture.until_commanded(1.0);
    let reload = || {
        reloader
            .reload("ana", "counter", ReloadOptions::default())
            .expect_err("it cannot be used")
    };
    let whole = build(2.0);
    for part in [0, 100, whole.len() / 2, whole.len() - 1] {
        fixture.write(&whole[..part]);
        let refused = reload();
        assert!(refused.may_be_unfinished(), "{refused}");
    }
    fixture.write(&library("counter", "other"));
    let refused = reload();
    assert!(!refused.may_be_unfinished());
    assert_eq!(
        refused.to_string(),
        "`counter` stays as it is: the plugin has no type `counter` any more, only other"
    );
    fixture.write(&library("other", "counter"));
    assert!(
        reload()
            .to_string()
            .contains("it comes from the plugin `counter`, and this is `other`")
    );
    fs::remove_file(file(&fixture.folder)).expect("it was there");
    assert!(matches!(
        reload(),
        ReloadError::Plugin(PluginError::Unusable { .. })
    ));
    let unknown = reloader
        .reload("ana", "countre", ReloadOptions::default())
        .expect_err("there is none");
    assert_eq!(unknown.nearest(), Some("counter"));
    let linked_in = reloader
        .reload("ana", "robot", ReloadOptions::default())
        .expect_err("it has no file");
    assert!(
        linked_in.to_string().contains("linked into the program"),
        "{linked_in}"
    );
    assert_eq!(state(&fixture), State::Winner);
    assert!(
        !fixture.scenario.has_line("robot velocity 0"),
        "the robot never stopped"
    );
}

#[test]
fn a_process_refuses_more_builds_than_its_limit() {
    let _alone = run_alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = file(&folder);
    let plugins = Plugins::default();
    fs::write(&file, build(0.0)).expect("it is written");
    plugins.open(&file).expect("the first");
    let bytes = build(0.0).len() as u64;
    for number in 1..=MAX_BUILDS {
        fs::write(&file, build(number as f64)).expect("it is written");
        assert!(plugins.refresh(&file).expect("there is room").is_new);
    }
    assert_eq!(plugins.builds().builds, MAX_BUILDS);
    assert_eq!(plugins.builds().bytes, bytes * MAX_BUILDS as u64);
    fs::write(&file, build(-1.0)).expect("it is written");
    let refused = plugins.refresh(&file).expect_err("the limit is reached");
    assert!(
        refused.to_string().contains("restart the application"),
        "{refused}"
    );
    fs::write(&file, build(3.0)).expect("it is written");
    assert!(!plugins.refresh(&file).expect("it is already loaded").is_new);
}
