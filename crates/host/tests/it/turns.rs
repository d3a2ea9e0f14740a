//! Turns that a schema requests from threads of its own, and those that a command causes (R12).

use std::path::Path;
use std::sync::Mutex;

use jde_abi::raw;
use jde_app::{Application, Executor};
use jde_board::value::Value;
use jde_core::Health;
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::Plugins;
use jde_schema::TurnRequester;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;

const HOUR: u64 = 3_600_000_000_000;

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

impl Schema for Wheel {
    fn iterate(&mut self, cx: &Context) -> Result {
        *SPEED.lock().unwrap() = *self.speed.get(cx);
        Ok(())
    }
}

impl Schema for Once {
    fn awake(&mut self, cx: &Context) -> Result {
        *REQUESTER.lock().unwrap() = cx.turn_requester();
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.ready.get(cx) > 0.0).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let begin = cx.now();
        self.speed.command(cx, iterations() as f64 + 1.0);
        ITERATIONS.lock().unwrap().push([begin, cx.now()]);
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("turns", "Requests turns.", [Once, Wheel]);

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
    REQUESTER
        .lock()
        .unwrap()
        .as_ref()
        .expect("time is real")
        .request();
}

fn iterations() -> usize {
    ITERATIONS.lock().unwrap().len()
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
    for executor in [Executor::Threads, Executor::Pool] {
        ITERATIONS.lock().unwrap().clear();
        let (application, plugins) = application(executor);
        let running = Running::start(application, &plugins, Options::default()).unwrap();
        let handle = running.handle();
        let has_speed = |speed| *SPEED.lock().unwrap() == speed;
        until(|| has_speed(1.0));
        request();
        until(|| has_speed(2.0));
        until(|| {
            request();
            iterations() >= 20
        });
        let times = ITERATIONS.lock().unwrap().clone();
        for pair in times.windows(2) {
            let gap = pair[1][0] - pair[0][1];
            assert!(gap >= Duration::from_millis(1), "{executor:?}: {times:?}");
        }
        // It checks, and does not iterate because it is not READY.
        let operator = handle.operator("ana");
        operator.modulate(0, "ready", &Value::Float(0.0)).unwrap();
        let winner = || handle.snapshot().groups[0].winner.is_some();
        until(|| {
            request();
            !winner()
        });
        let done = iterations();
        operator.modulate(0, "ready", &Value::Float(1.0)).unwrap();
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
    let (application, plugins) = application(Executor::Threads);
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).unwrap();
    lockstep.run_until(HOUR / 2);
    assert_eq!(*SPEED.lock().unwrap(), iterations() as f64, "a command triggers");
    assert!(
        REQUESTER.lock().unwrap().is_none(),
        "virtual time has only periods"
    );
}
