//! Chunks of commands (R7): what is left of one is void with the authority, and its commands come due however long its
//! maker takes for the next.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};

use jde_abi::raw;
use jde_app::Executor;
use jde_board::value::Value;
use jde_core::SchemaId;
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::Plugins;
use jde_schema::prelude::*;
use jde_schema::types::Chunk;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

const MS: u64 = 1_000_000;
const RIVAL: SchemaId = SchemaId(0);
const FOLLOWER: SchemaId = SchemaId(1);
const MAKER: SchemaId = SchemaId(2);

/// Held by each test: the makers share what follows.
static ALONE: Mutex<()> = Mutex::new(());
/// Whether the calls of the maker after the first return.
static RETURNS: AtomicBool = AtomicBool::new(true);
/// Whether the iterations of the follower hang.
static HANGS: AtomicBool = AtomicBool::new(false);
/// How many calls of the maker have begun.
static CALLS: AtomicU64 = AtomicU64::new(0);

/// Makes a chunk in each iteration.
#[derive(Describe)]
#[schema(perceptive, period = "1s", budget = "10ms")]
struct Maker {
    /// 128 commands, each the number of the last one and 0.01 m/s.
    #[export(validity = "10s")]
    chunk: Export<Chunk>,
}

/// Gives the commands of chunks.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Follower {
    /// The chunks.
    #[import]
    chunk: Import<Chunk>,
    /// The wheel.
    #[actuator]
    speed: Actuator<f64>,
    /// The number of the chunk that it saw at its last check; 0 for none.
    #[export(lasting)]
    seen: Export<u64>,
    /// How many checks saw none.
    #[export(lasting)]
    missed: Export<u64>,
    count: u64,
}

/// Takes over while it is told to.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Rival {
    /// Whether it is READY.
    #[modulation(default = false)]
    ready: Modulation<bool>,
}

/// A wheel.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Wheel {
    /// Its speed.
    #[command(neutral = 0.0, validity = "1s")]
    speed: Command<f64>,
    /// The speed as it was commanded.
    #[export(lasting)]
    driven: Export<f64>,
}

impl Schema for Maker {
    fn iterate(&mut self, cx: &Context) -> Result {
        let seen = cx.now();
        let is_first = CALLS.fetch_add(1, SeqCst) == 0;
        while !is_first && !RETURNS.load(SeqCst) {
            std::thread::yield_now();
        }
        let mut chunk = Chunk {
            spacing: 0.05,
            certainty: 1.0,
            ..Chunk::default()
        };
        for (place, twist) in chunk.commands.resize(128).iter_mut().enumerate() {
            *twist = Twist::planar(place as f64, 0.0);
        }
        self.chunk.write_at(cx, chunk, seen);
        Ok(())
    }
}

impl Schema for Follower {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let chunk = self.chunk.get(cx);
        self.count += u64::from(chunk.is_none());
        self.missed.write(cx, self.count);
        self.seen.write(cx, chunk.map_or(0, |chunk| chunk.sequence()));
        Ok(chunk.is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let chunk = self.chunk.require(cx)?;
        while HANGS.load(SeqCst) {
            std::thread::yield_now();
        }
        let place = chunk.age(cx).as_nanos() / 50_000_000;
        if let Some(twist) = chunk.commands.get(place as usize) {
            self.speed.command(cx, twist.linear.x);
        }
        Ok(())
    }
}

impl Schema for Rival {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.ready.get(cx).into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Schema for Wheel {
    fn iterate(&mut self, cx: &Context) -> Result {
        let speed = *self.speed.get(cx);
        self.driven.write(cx, speed);
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("ahead", "Looks ahead.", [Maker, Follower, Rival, Wheel]);

const APP: &str = r#"
roots = ["rival", "follower"]
[schemas.rival]
type = "ahead/rival"
[schemas.follower]
type = "ahead/follower"
imports = { chunk = "maker.chunk" }
actuators = { speed = "wheel.speed" }
[schemas.maker]
type = "ahead/maker"
hang = "1000s"
[schemas.wheel]
type = "ahead/wheel"
"#;

fn application(text: &str) -> (jde_app::Application, Plugins) {
    let mut plugins = Plugins::new(Default::default());
    plugins.link(&PLUGIN).expect("it is valid");
    let parsed = jde_app::parse(text, Path::new("app.toml"), &[], &plugins);
    (parsed.unwrap_or_else(|faults| panic!("{faults}")), plugins)
}

fn lockstep(text: &str) -> Lockstep {
    let (application, plugins) = application(text);
    Lockstep::start(application, &plugins, Options::default()).expect("it starts")
}

fn value<T: jde_types::Value>(handle: &Handle, name: &str) -> Option<T> {
    handle.value(name).expect("it is a variable")
}

fn until(condition: impl Fn() -> bool) {
    while !condition() {
        std::thread::yield_now();
    }
}

fn winner(handle: &Handle) -> String {
    let snapshot = handle.snapshot();
    snapshot.winner_name(&snapshot.groups[0]).to_owned()
}

#[test]
fn r7_what_is_left_of_a_chunk_is_void_when_the_authority_ends() {
    let _alone = ALONE.lock();
    type Way = fn(&Handle, bool);
    let take_over: Way = |handle, ends| {
        let ready = Value::Bool(ends);
        handle
            .operator("ana")
            .modulate(RIVAL, "ready", &ready)
            .expect("a boolean");
    };
    let stop: Way = |handle, ends| {
        let ana = handle.operator("ana");
        match ends {
            true => ana.hold_asleep(FOLLOWER).expect("it can be stopped"),
            false => ana.release(FOLLOWER).expect("it can be released"),
        };
    };
    for way in [take_over, stop] {
        let mut run = lockstep(APP);
        let handle = run.handle();
        run.run_until(300 * MS);
        assert_eq!(value(&handle, "follower.seen"), Some(1_u64));
        assert_eq!(
            value(&handle, "wheel.driven"),
            Some(5.0),
            "the command of 0.25 s to 0.3 s"
        );
        way(&handle, true);
        run.run_until(400 * MS);
        assert_ne!(winner(&handle), "follower");
        way(&handle, false);
        run.run_until(950 * MS);
        assert_eq!(
            value(&handle, "maker.chunk").map(|chunk: Chunk| chunk.commands.len()),
            Some(128)
        );
        assert_eq!(
            value(&handle, "follower.seen"),
            Some(0_u64),
            "the chunk is of before"
        );
        assert_eq!(winner(&handle), "nobody");
        assert_eq!(value(&handle, "wheel.driven"), Some(0.0));
        run.run_until(1100 * MS);
        assert_eq!(
            value(&handle, "follower.seen"),
            Some(2_u64),
            "what is made since counts"
        );
        assert_eq!(winner(&handle), "follower");
    }
}

#[test]
fn r7_the_first_check_after_the_authority_has_no_chunk_whatever_was_made_since() {
    let _alone = ALONE.lock();
    // The follower looks once a second, and its authority ends and begins between two looks.
    let text = APP.replace("\"ahead/maker\"", "\"ahead/maker\"\nperiod = \"10ms\"");
    let mut run = lockstep(&text);
    let handle = run.handle();
    run.run_until(300 * MS);
    assert_eq!(winner(&handle), "follower");
    let missed = value::<u64>(&handle, "follower.missed").expect("it has looked");
    let ana = handle.operator("ana");
    ana.force(RIVAL).expect("it is forced");
    run.run_until(301 * MS);
    ana.release(RIVAL).expect("it is released");
    run.run_until(400 * MS);
    // Its promotion lets it look: without a chunk it is not READY, and its authority ends once more.
    assert_eq!(value(&handle, "follower.missed"), Some(missed + 2));
    assert_eq!(winner(&handle), "follower");
}

#[test]
fn r7_the_chunk_of_a_maker_that_is_stopped_ends() {
    let _alone = ALONE.lock();
    let mut run = lockstep(APP);
    let handle = run.handle();
    run.run_until(300 * MS);
    handle
        .operator("ana")
        .hold_asleep(MAKER)
        .expect("it can be stopped");
    run.run_until(320 * MS);
    assert_eq!(winner(&handle), "nobody");
    assert_eq!(value(&handle, "wheel.driven"), Some(0.0));
}

#[test]
fn r7_the_successor_of_a_call_that_hung_has_no_chunk_of_before() {
    let (_watchdog, _alone) = (Watchdog::for_test(), ALONE.lock());
    let text = APP.replace("\"ahead/maker\"", "\"ahead/maker\"\nperiod = \"3600s\"");
    let text = format!("awake = [\"maker\"]\n{text}");
    let (mut application, plugins) =
        application(&text.replace("\"ahead/follower\"", "\"ahead/follower\"\nhang = \"500ms\""));
    application.executor = Executor::Threads;
    let running = Running::start(application, &plugins, Options::default()).expect("it starts");
    let handle = running.handle();
    until(|| value(&handle, "follower.seen") == Some(1_u64));
    HANGS.store(true, SeqCst);
    until(|| handle.snapshot().schemas[FOLLOWER.0 as usize].faults > 0);
    HANGS.store(false, SeqCst);
    // Its successor looks, and does not find what is still a value for others.
    until(|| value::<u64>(&handle, "follower.seen").is_some());
    assert_eq!(value(&handle, "follower.seen"), Some(0_u64));
    assert!(value::<Chunk>(&handle, "maker.chunk").is_some());
    handle.stop();
    drop(handle);
    running.wait();
}

#[test]
fn r11_commands_come_due_while_their_maker_is_late_and_the_overrun_is_its_own() {
    let (_watchdog, _alone) = (Watchdog::for_test(), ALONE.lock());
    for executor in [Executor::Threads, Executor::Pool] {
        RETURNS.store(false, SeqCst);
        CALLS.store(0, SeqCst);
        let (mut application, plugins) =
            application(&APP.replace("\"ahead/maker\"", "\"ahead/maker\"\nperiod = \"100ms\""));
        application.executor = executor;
        let running = Running::start(application, &plugins, Options::default()).expect("it starts");
        let handle = running.handle();
        let driven = || value::<f64>(&handle, "wheel.driven").unwrap_or_default();
        until(|| CALLS.load(SeqCst) > 1);
        // The second call does not return, and the commands of the first chunk come due one after another.
        until(|| driven() >= 6.0);
        until(|| driven() >= 12.0);
        assert_eq!(CALLS.load(SeqCst), 2);
        RETURNS.store(true, SeqCst);
        let overruns = |schema: SchemaId| handle.snapshot().schemas[schema.0 as usize].overruns;
        until(|| overruns(MAKER) > 0);
        until(|| winner(&handle) == "follower");
        handle.stop();
        drop(handle);
        running.wait();
    }
}
