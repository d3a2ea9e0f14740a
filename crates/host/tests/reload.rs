//! Files of plugins that change while an application runs. The libraries are real and built by `cc`; the
//! builds differ in the speed that they command.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use jde_app::parse;
use jde_core::State;
use jde_host::reload::{ReloadError, ReloadOptions, Reloader};
use jde_host::{Options, Running};
use jde_loader::{MAX_BUILDS, PluginError, Plugins};
use jde_records::event::Event;
use jde_records::reload::ReloadOutcome;
use jde_types::Twist;
use jde_watchdog::Watchdog;
use tempfile::TempDir;

use common::{Executor, Stage};

/// The speed in the library as `cc` built it; [`build`] replaces these bytes.
const SPEED: f64 = 0.123_456_789_012_345_67;

const APP: &str = r#"
    roots = ["walker"]
    [schemas.robot]
    type = "test/robot"
    [schemas.walker]
    type = "walker/walker"
    restart = "never"
    actuators = { base = "robot.velocity" }
"#;

/// The bytes of the library as `cc` built it.
fn library(plugin: &str, schema: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let to = folder.path().join("it.so");
    let macros = [format!("-DPLUGIN=\"{plugin}\""), format!("-DTYPE=\"{schema}\"")];
    common::c::make("walker.c", &macros, &to);
    fs::read(&to).expect("it was made")
}

/// A build of the walker with this speed.
fn build(speed: f64) -> Vec<u8> {
    static LIBRARY: OnceLock<Vec<u8>> = OnceLock::new();
    let mut bytes = LIBRARY.get_or_init(|| library("walker", "walker")).clone();
    let places: Vec<_> = (0..bytes.len() - 8)
        .filter(|place| bytes[*place..place + 8] == SPEED.to_ne_bytes())
        .collect();
    assert_eq!(places.len(), 1, "the speed is in one place");
    bytes[places[0]..places[0] + 8].copy_from_slice(&speed.to_ne_bytes());
    bytes
}

/// Serializes the tests, which measure the whole process.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An application whose walker runs a library of this test.
struct Site {
    _alone: MutexGuard<'static, ()>,
    folder: TempDir,
    stage: Arc<Stage>,
    plugins: Arc<Plugins>,
    running: Running,
    _watchdog: Watchdog,
}

impl Site {
    fn start(speed: f64) -> Self {
        let alone = alone();
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(file(&folder), build(speed)).expect("it is written");
        let stage = Stage::new();
        let mut path = jde_loader::SearchPath::default();
        path.push(folder.path(), "of this test");
        let plugins = common::plugins_along(path);
        let text = common::text(Executor::Threads, &stage, APP);
        let application = parse(&text, Path::new("apps/test.toml"), &[], &plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let hears = Arc::clone(&stage);
        let mut options = Options::default();
        options
            .observers
            .push(Box::new(move |event: &Event| hears.hear(event)));
        let running =
            Running::start(application, &plugins, options).unwrap_or_else(|error| panic!("{error}"));
        Self {
            _alone: alone,
            folder,
            stage,
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
        let beside = self.folder.path().join("new");
        fs::write(&beside, bytes).expect("it is written");
        fs::rename(beside, file(&self.folder)).expect("it takes the place");
    }

    fn until_commanded(&self, speed: f64) {
        let line = format!("robot velocity {speed}");
        self.stage.wait_until(|| self.stage.did(&line));
    }
}

fn file(folder: &TempDir) -> PathBuf {
    folder.path().join("libwalker.so")
}

fn state(site: &Site) -> State {
    let snapshot = site.running.handle().snapshot();
    let walker = snapshot.schemas.iter().find(|schema| schema.name == "walker");
    walker.expect("it is there").state
}

/// Returns the resident memory of this process, bytes.
fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("this is Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.expect("a number of kB") << 10
}

#[test]
fn fifty_files_take_over_while_the_robot_drives_without_a_stop() {
    let site = Site::start(1.0);
    let reloader = site.reloader();
    site.until_commanded(1.0);
    let before = resident();
    let mut carried = Vec::new();
    for round in 1..=50_u32 {
        let speed = 1.0 + f64::from(round) / 64.0;
        site.write(&build(speed));
        let reloaded = reloader
            .reload("ana@laptop", "walker", ReloadOptions::default())
            .unwrap_or_else(|refused| panic!("{refused}"));
        let [(name, ReloadOutcome::Reloaded(takeover))] = &reloaded.schemas[..] else {
            panic!("{reloaded:?}");
        };
        assert_eq!((name.as_str(), reloaded.is_done()), ("walker", true));
        assert_eq!(reloaded.memory.builds, round as usize);
        assert!(takeover.gap.is_some());
        carried.push(takeover.carried.expect("its count").bytes);
        site.until_commanded(speed);
    }
    assert_eq!(carried, [4; 50]);
    assert!(!site.stage.did("robot velocity 0"), "it never stopped");
    assert_eq!(state(&site), State::Winner);
    let handle = site.running.handle();
    let steps = handle
        .value::<u32>("walker.steps")
        .expect("a number")
        .expect("it walks");
    let faults: u64 = handle.snapshot().schemas.iter().map(|schema| schema.faults).sum();
    assert!(steps > 50, "it counted on");
    assert_eq!(faults, 0);
    let commanded = handle.value::<Twist>("robot.velocity").expect("a twist");
    assert_eq!(commanded.expect("it is commanded").linear.x, 1.0 + 50.0 / 64.0);
    // Each build leaves its library: some pages of it, and the bookkeeping of the system's loader.
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
fn a_schema_that_faulted_tries_again_when_the_same_build_is_reloaded() {
    let site = Site::start(-1.0);
    let faults = || {
        let snapshot = site.running.handle().snapshot();
        let walker = snapshot
            .schemas
            .into_iter()
            .find(|schema| schema.name == "walker");
        walker.expect("it is there").faults
    };
    for fault in 1..=3 {
        site.stage.wait_until(|| faults() == fault);
        assert_eq!(state(&site), State::Slept);
        let reloaded = site
            .reloader()
            .reload("ana@laptop", "walker", ReloadOptions::default());
        let reloaded = reloaded.unwrap_or_else(|refused| panic!("{refused}"));
        assert_eq!(
            reloaded.schemas,
            [("walker".to_owned(), ReloadOutcome::Restarted)]
        );
        assert!(reloaded.is_done());
    }
    site.stage.wait_until(|| faults() == 4);
}

#[test]
fn a_file_with_the_content_of_a_build_before_takes_no_more_memory() {
    let site = Site::start(1.0);
    let reloader = site.reloader();
    let reload = || {
        let reloaded = reloader.reload("ana", "walker", ReloadOptions::default());
        let reloaded = reloaded.unwrap_or_else(|refused| panic!("{refused}"));
        let became = reloaded.schemas.into_iter().map(|(_, became)| became).next();
        (became.expect("one"), reloaded.memory.builds)
    };
    assert_eq!(reload(), (ReloadOutcome::Unchanged, 0));
    for speed in [2.0, 1.0, 2.0, 1.0] {
        site.write(&build(speed));
        let (became, builds) = reload();
        assert!(matches!(became, ReloadOutcome::Reloaded(_)), "{became:?}");
        assert_eq!(builds, 1);
        site.until_commanded(speed);
    }
    site.write(&build(1.0));
    assert_eq!(reload(), (ReloadOutcome::Unchanged, 1));
}

#[test]
fn a_file_that_cannot_be_used_is_refused_and_the_robot_drives_on() {
    let site = Site::start(1.0);
    let reloader = site.reloader();
    site.until_commanded(1.0);
    let reload = || {
        reloader
            .reload("ana", "walker", ReloadOptions::default())
            .expect_err("it cannot be used")
    };
    let whole = build(2.0);
    for part in [0, 100, whole.len() / 2, whole.len() - 1] {
        site.write(&whole[..part]);
        let refused = reload();
        assert!(refused.may_be_unfinished(), "{refused}");
    }
    site.write(&library("walker", "runner"));
    let refused = reload();
    assert!(!refused.may_be_unfinished());
    assert_eq!(
        refused.to_string(),
        "`walker` stays as it is: the plugin has no type `walker` any more, only runner"
    );
    site.write(&library("other", "walker"));
    assert!(
        reload()
            .to_string()
            .contains("it comes from the plugin `walker`, and this is `other`")
    );
    fs::remove_file(file(&site.folder)).expect("it was there");
    assert!(matches!(
        reload(),
        ReloadError::Plugin(PluginError::Unusable { .. })
    ));
    let unknown = reloader
        .reload("ana", "walkre", ReloadOptions::default())
        .expect_err("there is none");
    assert_eq!(unknown.nearest(), Some("walker"));
    let linked_in = reloader
        .reload("ana", "robot", ReloadOptions::default())
        .expect_err("it has no file");
    assert!(
        linked_in.to_string().contains("linked into the program"),
        "{linked_in}"
    );
    assert_eq!(state(&site), State::Winner);
    assert!(!site.stage.did("robot velocity 0"), "it never stopped");
}

#[test]
fn a_process_loads_so_many_builds_and_then_says_that_it_is_enough() {
    let _alone = alone();
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
    let refused = plugins.refresh(&file).expect_err("it is enough");
    assert!(
        refused.to_string().contains("restart the application"),
        "{refused}"
    );
    fs::write(&file, build(3.0)).expect("it is written");
    assert!(!plugins.refresh(&file).expect("it is there already").is_new);
}
