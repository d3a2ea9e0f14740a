//! Tests of what a program may do while time passes, and of what it waits for.

use jde_board::value::Value;
use jde_conditions::{Expression, Names};
use jde_core::State as SchemaState;
use jde_records::event::{Event, Observer, StateChange};
use jde_watchdog::{DEFAULT_LIMIT, Watchdog};

use crate::observation::Observation;
use crate::{LoadedApplication, Run, StartOptions, Stop};
use jde_experiment::drive::EventQueue;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const SECOND: u64 = 1_000_000_000;

/// Starts the application of safe navigation, with the plugins of this build.
fn start(options: &StartOptions) -> Run {
    let plugins = jde_test_plugins::folder(&["sim", "example", "goon", "vff", "stop", "teleop"]);
    let text = std::fs::read_to_string(format!("{ROOT}/apps/safe-navigation.toml")).unwrap();
    let text = text.replace("../worlds", &format!("{ROOT}/worlds"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("application.toml");
    std::fs::write(&file, format!("plugins = [{plugins:?}]\n{text}")).unwrap();
    let application = LoadedApplication::load(file, Vec::new(), Vec::new(), None).unwrap();
    application.start(options).unwrap()
}

fn lockstep() -> StartOptions {
    StartOptions {
        lockstep: true,
        ..StartOptions::default()
    }
}

fn watch() -> Watchdog {
    Watchdog::new(DEFAULT_LIMIT, || String::from("a call waits for another"))
}

#[test]
fn r14_who_operates_waits_for_nobody_who_lets_time_pass() {
    let _watchdog = watch();
    let run = start(&lockstep());
    run.step(None).unwrap();
    // As a thread does that lets time pass.
    let state = run.state();
    run.renew_lease(Some(SECOND));
    run.write("vff.ahead", Value::Float(0.9)).unwrap();
    run.stop("goon").unwrap();
    run.release("goon").unwrap();
    run.edit("pioneer", "{ remove = 'lab door' }").unwrap();
    drop(state);
}

#[test]
fn a_condition_that_becomes_true_in_the_last_instant_has_become_true() {
    let _watchdog = watch();
    for lockstep in [true, false] {
        let run = start(&StartOptions {
            lockstep,
            limit: Some(SECOND),
            ..StartOptions::default()
        });
        let stop = run.until(None, Some("time >= 1"), || true);
        assert_eq!(stop, Ok(Stop::Condition), "lockstep: {lockstep}");
        assert_eq!(run.until(None, None, || true), Ok(Stop::End));
    }
}

#[test]
fn a_condition_is_evaluated_though_its_time_is_over() {
    let _watchdog = watch();
    for lockstep in [true, false] {
        let run = start(&StartOptions {
            lockstep,
            ..StartOptions::default()
        });
        run.until(Some(SECOND / 2), None, || true).unwrap();
        let until = |condition| run.until(Some(SECOND / 4), Some(condition), || true);
        assert_eq!(until("time > 0.1"), Ok(Stop::Condition), "lockstep: {lockstep}");
        assert_eq!(until("time < 0.1"), Ok(Stop::Time), "lockstep: {lockstep}");
    }
}

#[test]
fn what_was_true_at_one_instant_is_not_taken_with_the_time_of_the_next() {
    let run = start(&lockstep());
    let handle = run.handle();
    let goon = handle.application().instance("goon").unwrap();
    let mut events = EventQueue::default();
    let mut observation = Observation::new(events.clone(), handle);
    let names = Names::of(handle.application());
    let mut add = |condition| {
        let expression = Expression::condition(condition, &names).unwrap();
        observation.add_condition(expression, handle)
    };
    let (at_next, at_own) = (
        add("goon.won and time >= 2"),
        add("goon.won and time >= 1 and time < 2"),
    );
    let (ready, winner) = (SchemaState::Ready, SchemaState::Winner);
    for (time, from, to) in [(SECOND, ready, winner), (2 * SECOND, winner, ready)] {
        let schema = goon;
        events.on_event(&Event::State(StateChange {
            time,
            schema,
            from,
            to,
        }));
    }
    observation.observe(3 * SECOND);
    assert!(!observation.was_true(at_next));
    assert!(observation.was_true(at_own));
}
