//! Applications that run for a long time, or start and stop often, leak no memory and no threads.
//!
//! These tests measure the whole process. Therefore they have a process of their own and run one after
//! another.

mod common;

use std::fs::File;
use std::sync::{Arc, mpsc};

use jde_core::Health;
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_records::ResourceUsage;
use jde_records::event::{Event, Occurrence, Outcome, What};
use parking_lot::{Mutex, MutexGuard};

use common::{Call, Executor, LIVE, MS, Scenario, TestApp, in_real_time};

static SEQUENTIAL: Mutex<()> = Mutex::new(());

fn run_alone() -> MutexGuard<'static, ()> {
    SEQUENTIAL.lock()
}

/// Returns the resident memory of this process, bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("/proc is readable");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.expect("a number of kB") << 10
}

fn threads() -> usize {
    std::fs::read_dir("/proc/self/task")
        .expect("/proc is readable")
        .count()
}

/// A father with two children that take turns, a perceptive schema, a robot and a mission.
const APP: &str = r#"
    roots = ["father"]
    mission = "father.mission"
    [schemas.robot]
    type = "test/robot"
    period = "50ms"
    [schemas.eye]
    type = "test/eye"
    period = "50ms"
    [schemas.father]
    type = "test/motor"
    period = "100ms"
    gain = 100
    children = { a = "left", b = "right" }
    [schemas.left]
    type = "test/motor"
    period = "100ms"
    imports = { input = "eye.out" }
    triggers = ["input"]
    actuators = { base = "robot.velocity" }
    [schemas.right]
    type = "test/motor"
    period = "100ms"
    actuators = { base = "robot.velocity" }
"#;

fn scenario() -> Arc<Scenario> {
    let scenario = Scenario::quiet();
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Arbitrate => io.choose("a"),
            _ => {}
        }
        Ok(())
    });
    let mut count = 0.0;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1.0;
            io.publish(count);
        }
        Ok(())
    });
    scenario.on_call("left", |call, io| {
        match call {
            Call::Check => io.ready(io.input().is_some_and(|(value, _)| value % 3.0 == 0.0)),
            Call::Iterate => {
                io.command(0.1);
            }
            _ => {}
        }
        Ok(())
    });
    scenario.drives("right", &Arc::new(true.into()), 0.2);
    scenario
}

#[test]
fn two_hours_of_virtual_time_take_no_more_memory_than_ten_minutes() {
    let _guard = run_alone();
    let scenario = scenario();
    let mut app = TestApp::start(Executor::Lockstep, &scenario, APP);
    assert_eq!(app.advance(600_000 * MS), None);
    let warm = resident();
    assert_eq!(app.advance(7_200_000 * MS), None);
    let grown = resident().saturating_sub(warm);
    assert!(
        app.group("father/base").switches > 10_000,
        "the winners alternate"
    );
    assert_eq!(app.schema("father").faults + app.schema("left").faults, 0);
    // If each selection leaked 100 bytes, 100 000 selections would leak ten times this limit.
    assert!(grown < 1 << 20, "the memory grew by {} kB", grown >> 10);
    app.stop();
    scenario.close();
}

#[test]
fn a_thousand_reloads_of_the_same_build_take_no_more_memory() {
    let _guard = run_alone();
    let scenario = scenario();
    let mut app = TestApp::start(Executor::Lockstep, &scenario, APP);
    let plugins = common::plugins();
    let build = plugins.load("test", &[]).expect("the test plugin is linked in");
    let (father, operator) = (app.index("father"), app.operator());
    let reload_once = |app: &mut TestApp| {
        let reload = operator
            .replace(father, &build, ReloadOptions::default())
            .unwrap_or_else(|reasons| panic!("{reasons:?}"));
        app.advance(app.handle.now() + 200 * MS);
        assert!(matches!(reload.outcome(), Some(Ok(_))));
    };
    (0..100).for_each(|_| reload_once(&mut app));
    let (live, warm) = (LIVE.get(), resident());
    (0..1000).for_each(|_| reload_once(&mut app));
    let grown = resident().saturating_sub(warm);
    assert_eq!(app.schema("father").faults, 0);
    assert_eq!(LIVE.get(), live, "every replaced instance has ended");
    // Any other leak of a reload would add up to some hundred kilobytes.
    assert!(grown < 1 << 20, "the memory grew by {} kB", grown >> 10);
    app.stop();
    scenario.close();
}

#[test]
fn a_lockstep_application_that_starts_and_stops_leaks_nothing() {
    leaks_nothing(Executor::Lockstep);
}

#[test]
fn threads_that_start_and_stop_leak_nothing() {
    leaks_nothing(Executor::Threads);
}

#[test]
fn a_pool_that_starts_and_stops_leaks_nothing() {
    leaks_nothing(Executor::Pool);
}

fn leaks_nothing(executor: Executor) {
    let _guard = run_alone();
    let run = || {
        let scenario = scenario();
        let options = Options {
            limit: Some(5 * MS),
            ..Options::default()
        };
        assert_eq!(
            TestApp::start_with(executor, &scenario, APP, options).wait(),
            Outcome::TimeUp
        );
        scenario.close();
        Arc::downgrade(&scenario)
    };
    // These runs make the allocations that a process makes once, and fill the allocator's reserve.
    for _ in 0..20 {
        run();
    }
    let (before, warm) = (threads(), resident());
    for _ in 0..200 {
        assert!(run().upgrade().is_none(), "the application leaks its scenario");
    }
    // The threads of the tests before this one may still be ending.
    assert!(
        threads() < before + 10,
        "{before} threads have become {}",
        threads()
    );
    let grown = resident().saturating_sub(warm);
    // An application and its board take some hundred kilobytes: a leak of a tenth of that would fail.
    assert!(grown < 4 << 20, "the memory grew by {} kB", grown >> 10);
}

#[test]
fn an_open_file_is_counted_while_it_is_open() {
    let _guard = run_alone();
    let before = ResourceUsage::now();
    let files: Vec<_> = (0..200).map(|_| File::open("/proc/self/stat").unwrap()).collect();
    let during = ResourceUsage::now();
    assert_eq!(during.files, before.files + files.len() as u64);
    assert!(during.memory > 100_000, "{during}");
    drop(files);
    assert_eq!(ResourceUsage::now().files, before.files);
}

in_real_time!(at_most_four_hung_instances_of_a_schema_are_abandoned);

/// Two schemas, one of which hangs.
const HANGS: &str = r#"
    roots = ["low", "high"]
    [schemas.robot]
    type = "test/robot"
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    restart = { back-off = "5ms", limit = 5 }
    hang = "100ms"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn at_most_four_hung_instances_of_a_schema_are_abandoned(executor: Executor) {
    /// Files that each hung call opens: many more than all other code opens in the meantime.
    const FILES: usize = 120;
    let _guard = run_alone();
    let scenario = Scenario::new();
    let (release, released) = mpsc::channel::<()>();
    let released = Arc::new(Mutex::new(released));
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                let released = Arc::clone(&released);
                io.then(move |_| {
                    let files: Vec<_> = (0..FILES).map(|_| File::open("/dev/null").unwrap()).collect();
                    // An error means that the sender was dropped.
                    let _ = released.lock().recv();
                    drop(files);
                });
            }
            _ => {}
        }
        Ok(())
    });
    let ready = Arc::new(true.into());
    scenario.drives("high", &ready, 0.3);
    let mut app = TestApp::start(executor, &scenario, HANGS);
    let low = app.index("low");
    let reason_text =
        "4 calls of it were given up and never returned; it gets no other instance until one does";
    app.until(|app| matches!(app.schema("low").health, Health::Faulted(reason) if reason == reason_text));
    // Four hangs, and two restarts that created no instance.
    app.until(|app| app.schema("low").faults == 6);
    assert_eq!(app.schema("low").left, 4);
    assert_eq!(scenario.count("low iterate"), 4);
    let reported = scenario.events().into_iter().filter_map(|event| match event {
        Event::Other(Occurrence {
            what:
                What::CallAbandoned {
                    schema,
                    abandoned,
                    process,
                    ..
                },
            ..
        }) if schema == low => Some((abandoned, process.files)),
        _ => None,
    });
    let (abandoned, files): (Vec<_>, Vec<_>) = reported.unzip();
    assert_eq!(abandoned, [1, 2, 3, 4]);
    assert!(
        files[3] >= files[0] + 2 * FILES as u64,
        "the report counts their files: {files:?}"
    );
    assert!(
        ResourceUsage::now().files < files[3] + FILES as u64,
        "no fifth instance opened files"
    );
    let before = scenario.count("high iterate");
    app.until(|app| app.scenario.count("high iterate") > before + 3);
    drop(release);
    app.until(|app| app.schema("low").left == 0);
    assert_eq!(scenario.count("low drop"), 4);
    app.until(|_| ResourceUsage::now().files + 2 * (FILES as u64) < files[3]);
    app.stop();
}
