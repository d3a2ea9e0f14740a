//! Applications that run for long, or start and stop often, leave no memory and no threads behind.
//!
//! These tests measure the whole process. Therefore they have a process of their own and run one after
//! another.

mod common;

use std::fs::File;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};

use jde_core::Health;
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_records::ResourceUsage;
use jde_records::event::{Event, Outcome};

use common::{Call, Executor, LIVE, MS, Rig, Stage, in_real_time};

static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the resident memory of this process, bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("this is Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.expect("a number of kB") << 10
}

fn threads() -> usize {
    std::fs::read_dir("/proc/self/task")
        .expect("this is Linux")
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

fn stage() -> Arc<Stage> {
    let stage = Stage::quiet();
    stage.play("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Arbitrate => io.choose("a"),
            Call::Awake | Call::Sleep | Call::Drop => {}
        }
        Ok(())
    });
    let mut count = 0.0;
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1.0;
            io.publish(count);
        }
        Ok(())
    });
    stage.play("left", |call, io| {
        match call {
            Call::Check => io.ready(io.input().is_some_and(|(value, _)| value % 3.0 == 0.0)),
            Call::Iterate => {
                io.command(0.1);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    stage.drives("right", &Arc::new(true.into()), 0.2);
    stage
}

#[test]
fn two_hours_of_virtual_time_take_no_more_memory_than_ten_minutes() {
    let _alone = alone();
    let stage = stage();
    let mut rig = Rig::start(Executor::Lockstep, &stage, APP);
    assert_eq!(rig.advance(600_000 * MS), None);
    let warm = resident();
    assert_eq!(rig.advance(7_200_000 * MS), None);
    let grown = resident().saturating_sub(warm);
    assert!(rig.group("father/base").switches > 10_000, "it was not idle");
    assert_eq!(rig.see("father").faults + rig.see("left").faults, 0);
    // If each selection kept a hundred bytes, a hundred thousand selections would keep ten times this.
    assert!(grown < 1 << 20, "{} kB", grown >> 10);
    rig.stop();
    stage.close();
}

#[test]
fn a_thousand_reloads_of_what_is_there_already_take_no_more_memory() {
    let _alone = alone();
    let stage = stage();
    let mut rig = Rig::start(Executor::Lockstep, &stage, APP);
    let plugins = common::plugins();
    let build = plugins.load("test", &[]).expect("it is linked in");
    let (father, operator) = (rig.place("father"), rig.operator());
    let reload = |rig: &mut Rig| {
        let order = operator
            .replace(father, &build, ReloadOptions::default())
            .unwrap_or_else(|reasons| panic!("{reasons:?}"));
        rig.advance(rig.handle.now() + 200 * MS);
        assert!(matches!(order.outcome(), Some(Ok(_))));
    };
    (0..100).for_each(|_| reload(&mut rig));
    let (live, warm) = (LIVE.get(), resident());
    (0..1000).for_each(|_| reload(&mut rig));
    let grown = resident().saturating_sub(warm);
    assert_eq!(rig.see("father").faults, 0);
    assert_eq!(LIVE.get(), live, "each that was replaced has ended");
    // Whatever else a reload left would add up to some hundred kilobytes.
    assert!(grown < 1 << 20, "{} kB", grown >> 10);
    rig.stop();
    stage.close();
}

#[test]
fn a_lockstep_application_that_starts_and_stops_leaves_nothing() {
    leaves_nothing(Executor::Lockstep);
}

#[test]
fn threads_that_start_and_stop_leave_nothing() {
    leaves_nothing(Executor::Threads);
}

#[test]
fn a_pool_that_starts_and_stops_leaves_nothing() {
    leaves_nothing(Executor::Pool);
}

fn leaves_nothing(executor: Executor) {
    let _alone = alone();
    let run = || {
        let stage = stage();
        let options = Options {
            limit: Some(5 * MS),
            ..Options::default()
        };
        assert_eq!(
            Rig::start_with(executor, &stage, APP, options).wait(),
            Outcome::TimeUp
        );
        stage.close();
        Arc::downgrade(&stage)
    };
    // These runs make the allocations of a process's lifetime, and fill the allocator's reserve.
    for _ in 0..20 {
        run();
    }
    let (before, warm) = (threads(), resident());
    for _ in 0..200 {
        assert!(
            run().upgrade().is_none(),
            "the application keeps what it was made of"
        );
    }
    // The threads of the tests before this one may still be ending.
    assert!(
        threads() < before + 10,
        "{before} threads have become {}",
        threads()
    );
    let grown = resident().saturating_sub(warm);
    // An application and its board take some hundred kilobytes: if a tenth of one were left each time, this
    // would fail.
    assert!(grown < 4 << 20, "{} kB", grown >> 10);
}

#[test]
fn an_open_file_is_counted_while_it_is_open() {
    let _alone = alone();
    let before = ResourceUsage::now();
    let files: Vec<_> = (0..200).map(|_| File::open("/proc/self/stat").unwrap()).collect();
    let with = ResourceUsage::now();
    assert_eq!(with.files, before.files + files.len() as u64);
    assert!(with.memory > 100_000, "{with}");
    drop(files);
    assert_eq!(ResourceUsage::now().files, before.files);
}

in_real_time!(who_always_hangs_is_left_behind_four_times_and_costs_no_more_than_that);

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

fn who_always_hangs_is_left_behind_four_times_and_costs_no_more_than_that(executor: Executor) {
    /// Files that each hung call opens: many more than anything else opens and closes meanwhile.
    const FILES: usize = 120;
    let _alone = alone();
    let stage = Stage::new();
    let (release, held) = mpsc::channel::<()>();
    let held = Arc::new(Mutex::new(held));
    stage.play("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                let held = Arc::clone(&held);
                io.then(move |_| {
                    let files: Vec<_> = (0..FILES).map(|_| File::open("/dev/null").unwrap()).collect();
                    // An error means that the sender was dropped.
                    let _ = held.lock().unwrap().recv();
                    drop(files);
                });
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let ready = Arc::new(true.into());
    stage.drives("high", &ready, 0.3);
    let mut rig = Rig::start(executor, &stage, HANGS);
    let low = rig.place("low");
    let down = "4 calls of it were given up and never returned; it gets no other instance until one does";
    rig.until(|rig| matches!(rig.see("low").health, Health::Faulted(reason) if reason == down));
    // Four hangs, and two restarts that made no instance.
    rig.until(|rig| rig.see("low").faults == 6);
    assert_eq!(rig.see("low").left, 4);
    assert_eq!(stage.count("low iterate"), 4);
    let told = stage.events().into_iter().filter_map(|event| match event {
        Event::CallAbandoned {
            schema,
            abandoned: left,
            process,
            ..
        } if schema == low => Some((left, process.files)),
        _ => None,
    });
    let (left, files): (Vec<_>, Vec<_>) = told.unzip();
    assert_eq!(left, [1, 2, 3, 4]);
    assert!(
        files[3] >= files[0] + 2 * FILES as u64,
        "it is told what they hold: {files:?}"
    );
    assert!(
        ResourceUsage::now().files < files[3] + FILES as u64,
        "no fifth opened any"
    );
    let before = stage.count("high iterate");
    rig.until(|rig| rig.stage.count("high iterate") > before + 3);
    drop(release);
    rig.until(|rig| rig.see("low").left == 0);
    assert_eq!(stage.count("low drop"), 4);
    rig.until(|_| ResourceUsage::now().files + 2 * (FILES as u64) < files[3]);
    rig.stop();
}
