//! Turns that a schema requests from threads of its own, and those that a command causes (R12).

use std::path::Path;

use jde_abi::raw;
use jde_app::{Application, Executor};
use jde_board::value::Value;
use jde_core::{Health, SchemaId, State};
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::{LoadedPlugin, Plugins};
use jde_schema::TurnRequester;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

const HOUR: u64 = 3_600_000_000_000;

/// Held by a test that uses the variables below.
static ALONE: Mutex<()> = Mutex::new(());
/// Gives its requester to the test.
static REQUESTER: Mutex<Option<TurnRequester>> = Mutex::new(None);
/// When each iteration of `once` began and ended.
static ITERATIONS: Mutex<Vec<[Duration; 2]>> = Mutex::new(Vec::new());
/// The speed at the newest iteration of `wheel`.
static SPEED: Mutex<f64> = Mutex::new(0.0);

/// Iterates once in an hour, unless it requests a turn.
#[derive(Describe)]
#[schema(motor, period = "3600s")]
struct Once {
    /// Whether it is READY.
    #[modulation(default = 1.0)]
    ready: Modulation<f64>,
    /// Each iteration commands its number.
    #[actuator]
    speed: Actuator<f64>,
}

/// Iterates once in an hour, and at each command.
#[derive(Describe)]
#[schema(driver, period = "3600s")]
struct Wheel {
    /// The speed.
    #[command(neutral = 0.0, validity = "3600s", trigger)]
    speed: Command<f64>,
}

/// The same without the trigger.
#[derive(Describe)]
#[schema(driver, period = "3600s", name = "wheel")]
struct SlowWheel {
    /// The speed.
    #[command(neutral = 0.0, validity = "3600s")]
    #[expect(dead_code, reason = "only its description is compared")]
    speed: Command<f64>,
}

impl Schema for SlowWheel {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Schema for Wheel {
    fn iterate(&mut self, cx: &Context) -> Result {
        *SPEED.lock() = *self.speed.get(cx);
        Ok(())
    }
}

impl Schema for Once {
    fn awake(&mut self, cx: &Context) -> Result {
        *REQUESTER.lock() = cx.turn_requester();
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.ready.get(cx) > 0.0).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let begin = cx.now();
        self.speed.command(cx, iterations() as f64 + 1.0);
        if iterations() >= 10 {
            // Longer than the least time between two.
            until(|| cx.require_real_time().is_err() || cx.now() >= begin + Duration::from_millis(1));
        }
        ITERATIONS.lock().push([begin, cx.now()]);
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("turns", "Requests turns.", [Once, Wheel]);
static SLOW: raw::Plugin = jde_schema::plugin!("turns", "Requests turns.", [Once, SlowWheel]);

fn application(executor: Executor) -> (Application, Plugins) {
    let mut plugins = Plugins::new(Default::default());
    plugins.link(&PLUGIN).unwrap();
    let text = "roots = [\"once\"]\n[schemas.once]\ntype = \"turns/once\"\n\
                actuators = { speed = \"wheel.speed\" }\n[schemas.wheel]\ntype = \"turns/wheel\"\n";
    let parsed = jde_app::parse(text, Path::new("turns.toml"), &[], &plugins);
    let mut application = parsed.unwrap_or_else(|faults| panic!("{faults}"));
    application.executor = executor;
    (application, plugins)
}

fn until(condition: impl Fn() -> bool) {
    while !condition() {
        std::thread::yield_now();
    }
}

fn request() {
    REQUESTER.lock().as_ref().expect("time is real").request();
}

fn iterations() -> usize {
    ITERATIONS.lock().len()
}

fn is_ok(handle: &Handle) -> bool {
    handle
        .snapshot()
        .schemas
        .iter()
        .all(|schema| schema.health == Health::Ok)
}

#[test]
fn r12_a_schema_requests_turns_in_real_time_and_a_flood_of_requests_is_bounded() {
    let _watchdog = Watchdog::for_test();
    let _alone = ALONE.lock();
    for executor in [Executor::Threads, Executor::Pool] {
        ITERATIONS.lock().clear();
        let (application, plugins) = application(executor);
        let running = Running::start(application, &plugins, Options::default()).unwrap();
        let handle = running.handle();
        let has_speed = |speed| *SPEED.lock() == speed;
        until(|| has_speed(1.0));
        request();
        until(|| has_speed(2.0));
        until(|| {
            request();
            iterations() >= 20
        });
        let times = ITERATIONS.lock().clone();
        for pair in times.windows(2) {
            let (took, gap) = (pair[0][1] - pair[0][0], pair[1][0] - pair[0][1]);
            assert!(
                gap >= took.max(Duration::from_micros(200)),
                "{executor:?}: {times:?}"
            );
        }
        // It checks, and does not iterate because it is not READY.
        let operator = handle.operator("ana");
        operator
            .modulate(SchemaId(0), "ready", &Value::Float(0.0))
            .unwrap();
        let winner = || handle.snapshot().groups[0].winner.is_some();
        until(|| {
            request();
            !winner()
        });
        let done = iterations();
        operator
            .modulate(SchemaId(0), "ready", &Value::Float(1.0))
            .unwrap();
        until(|| {
            request();
            iterations() > done
        });
        assert!(is_ok(&handle));
        handle.stop();
        drop(handle);
        running.wait();
        // Nothing is there any more.
        request();
    }
}

#[test]
fn r12_a_request_of_before_an_awakening_hinders_none_after_it() {
    let _watchdog = Watchdog::for_test();
    let _alone = ALONE.lock();
    let before = iterations();
    let (application, plugins) = application(Executor::Threads);
    let running = Running::start(application, &plugins, Options::default()).unwrap();
    let handle = running.handle();
    let operator = handle.operator("ana");
    let asleep = || handle.snapshot().schemas[0].state == State::Slept;
    until(|| iterations() > before);
    for _ in 0..50 {
        // One that is under way as it falls asleep.
        request();
        operator.hold_asleep(SchemaId(0)).unwrap();
        until(asleep);
        request();
        let done = iterations();
        operator.release(SchemaId(0)).unwrap();
        until(|| iterations() > done && !asleep());
        // No request of before hinders this one.
        let done = iterations();
        request();
        until(|| iterations() > done);
    }
    assert!(is_ok(&handle));
}

#[test]
fn r12_only_real_time_has_requested_turns() {
    let _watchdog = Watchdog::for_test();
    let _alone = ALONE.lock();
    let (fast, plugins) = application(Executor::Threads);
    let options = Options {
        speed: 2.0,
        ..Options::default()
    };
    let before = iterations();
    let running = Running::start(fast, &plugins, options).unwrap();
    until(|| iterations() > before);
    running.handle().stop();
    running.wait();
    assert!(REQUESTER.lock().is_none(), "time is twice as fast");
    let (slow, plugins) = application(Executor::Threads);
    let mut lockstep = Lockstep::start(slow, &plugins, Options::default()).unwrap();
    lockstep.run_until(HOUR / 2);
    assert_eq!(*SPEED.lock(), iterations() as f64, "a command triggers");
    assert!(REQUESTER.lock().is_none(), "virtual time has only periods");
}

#[test]
fn a_build_whose_command_triggers_no_longer_keeps_the_setting_and_says_so() {
    let _alone = ALONE.lock();
    let (application, plugins) = application(Executor::Threads);
    let lockstep = Lockstep::start(application, &plugins, Options::default()).unwrap();
    let build = LoadedPlugin::linked_in(&SLOW).unwrap();
    let notes = lockstep
        .handle()
        .operator("ana")
        .check_build(SchemaId(1), &build)
        .unwrap();
    assert_eq!(
        notes,
        ["the command `speed` is no longer a trigger; the application keeps its setting"]
    );
}
