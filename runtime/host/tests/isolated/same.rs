//! A schema in a process of its own decides and exports exactly what it does in the host's process, bit for
//! bit.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use jde_app::parse;
use jde_board::Stamp;
use jde_board::value::Value;
use jde_host::{Lockstep, Options};
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::{Event, Observer};
use jde_types::LaserScan;
use parking_lot::Mutex;

use crate::common::{Executor, MS, Scenario, on_every_executor};
use crate::faulty::{LACK, LACK_IN_CHECK};
use crate::isolated_app::{IsolatedApp, RUNNING, all_plugins, program};

on_every_executor!(
    large_values_are_shared_in_both_directions,
    an_isolated_schema_reads_the_applications_time,
    the_start_fails_when_the_process_of_a_schema_cannot_start,
);

/// A father that arbitrates, its children, and the modulation that it sets. Either all of them run in
/// processes of their own, or none.
const FAMILY: &str = r#"
    roots = ["high"]
    seed = 7
    [schemas.high]
    type = "faulty/faulty"
    period = "20ms"
    children = { a = "left", b = "right" }
    [schemas.left]
    type = "faulty/faulty"
    period = "15ms"
    imports = { scan = "high.seen" }
    [schemas.right]
    type = "faulty/faulty"
    period = "35ms"
    imports = { scan = "left.seen" }
"#;

/// When `high` is forced although it is not READY.
const FORCED: Range<u64> = 1400 * MS..1600 * MS;
/// When `right` reads nothing, which it notices in its iterations, and then in its checks.
const BLIND: Range<u64> = 2000 * MS..2400 * MS;

/// Runs for two and a half seconds, in which preconditions become false, an operator forces schemas, and one lacks a
/// value. Returns the decisions as lines, and every value with its stamp.
fn drive(body: &str) -> (String, Vec<(String, Stamp, Vec<u8>)>) {
    let plugins = all_plugins();
    let application =
        parse(body, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let decisions = Arc::new(Mutex::new(DecisionWriter::new(&application, Vec::new())));
    let recorder = Arc::clone(&decisions);
    let observer: Box<dyn Observer> = Box::new(move |event: &Event| recorder.lock().on_event(event));
    let options = Options {
        observers: vec![observer],
        isolation_program: Some(program()),
        ..Options::default()
    };
    let mut run = Lockstep::start(application, &plugins, options).unwrap_or_else(|error| panic!("{error}"));
    let handle = run.handle();
    let values = Arc::new(Mutex::new(Vec::new()));
    let watches: Vec<_> = handle
        .board()
        .list()
        .map(|variable| {
            let (values, weak) = (Arc::clone(&values), Arc::downgrade(&variable));
            variable.watch(move || {
                let Some(variable) = weak.upgrade() else { return };
                let mut reader = variable.reader("test");
                if let Some(latched) = reader.latch(0) {
                    let name = variable.describe().full_name();
                    values.lock().push((name, latched.stamp, latched.bytes.to_vec()));
                }
            })
        })
        .collect();
    let operator = handle.operator("test");
    let [high, left, right] = ["high", "left", "right"].map(|name| handle.schemas_named(name)[0]);
    let set_speed = |schema, speed| {
        operator
            .modulate(schema, "speed", &Value::Float(speed))
            .expect("it may")
    };
    run.run_until(500 * MS);
    set_speed(left, 0.0);
    run.run_until(700 * MS);
    operator.force(left).expect("it may");
    run.run_until(900 * MS);
    operator.release(left).expect("it may");
    set_speed(high, 0.0);
    run.run_until(1100 * MS);
    set_speed(high, 0.4);
    run.run_until(1300 * MS);
    operator.force(high).expect("it may");
    run.run_until(FORCED.start);
    // Its iteration has begun with its check, and goes on although the precondition is false.
    set_speed(high, 0.0);
    run.run_until(FORCED.end);
    operator.release(high).expect("it may");
    set_speed(high, 0.4);
    run.run_until(BLIND.start);
    let lack = |trouble: u32| {
        operator
            .modulate(right, "trouble", &Value::UInt(u64::from(trouble)))
            .expect("it may")
    };
    lack(LACK);
    operator.hold_asleep(left).expect("it may");
    run.run_until(2200 * MS);
    lack(LACK_IN_CHECK);
    run.run_until(BLIND.end);
    operator.release(left).expect("it may");
    run.run_until(2500 * MS);
    drop(operator);
    drop((watches, handle));
    drop(run);
    let decisions = Arc::into_inner(decisions).expect("the application has ended");
    let lines = decisions
        .into_inner()
        .finish()
        .expect("writing to memory succeeds");
    let values = std::mem::take(&mut *values.lock());
    (String::from_utf8(lines).expect("UTF-8"), values)
}

#[test]
fn r16_isolation_changes_no_decision_and_no_export_in_lockstep() {
    let _running = RUNNING.read();
    let (decided, exported) = drive(FAMILY);
    assert!(decided.lines().count() > 20, "{decided}");
    let isolated = FAMILY.replace(
        "type = \"faulty/faulty\"",
        "type = \"faulty/faulty\"\nisolate = \"process\"",
    );
    let (isolated_decided, isolated_exported) = drive(&isolated);
    assert_eq!(decided, isolated_decided);
    assert_eq!(exported.len(), isolated_exported.len());
    for (value, isolated) in exported.iter().zip(&isolated_exported) {
        assert!(value == isolated, "{} differs at {:?}", value.0, value.1);
    }
    let while_forced = |(name, stamp, _): &&(String, Stamp, Vec<u8>)| {
        name == "high.count" && (FORCED.start + 20 * MS..FORCED.end).contains(&stamp.time)
    };
    assert_eq!(isolated_exported.iter().filter(while_forced).count(), 9);
    let acts = |times: Range<u64>| {
        let mut counted = isolated_exported.iter().filter(|value| value.0 == "right.count");
        counted.any(|value| times.contains(&value.1.time))
    };
    assert!(acts(1600 * MS..BLIND.start) && acts(BLIND.end..2500 * MS));
    assert!(
        !acts(BLIND),
        "without a value it ends its iteration, and then its check"
    );
    assert!(!decided.contains("faulted"), "{decided}");
}

fn large_values_are_shared_in_both_directions(executor: Executor) {
    let scenario = Scenario::new();
    let body = FAMILY.replacen(
        "type = \"faulty/faulty\"",
        "type = \"faulty/faulty\"\nisolate = \"process\"",
        1,
    );
    let mut isolated = IsolatedApp::start(executor, &scenario, &body);
    let shared = isolated
        .app
        .handle
        .board()
        .find("high.seen")
        .expect("it is exported");
    assert!(shared.shared().is_some(), "the value is too large for messages");
    let seen = |app: &crate::common::TestApp, name: &str| {
        let scan = app.handle.value::<LaserScan>(name).expect("it is a scan");
        scan.map_or(0.0, |scan| scan.ranges[0])
    };
    isolated
        .app
        .until(|app| seen(app, "high.seen") > 5.0 && seen(app, "left.seen") > 1.0);
    isolated.app.stop();
}

fn an_isolated_schema_reads_the_applications_time(executor: Executor) {
    let scenario = Scenario::new();
    let body = FAMILY.replacen(
        "type = \"faulty/faulty\"",
        "type = \"faulty/faulty\"\nisolate = \"process\"",
        1,
    );
    let mut isolated = IsolatedApp::start(executor, &scenario, &body);
    isolated.app.until(|app| app.schema("high").iterations > 3);
    let before = isolated.app.handle.now() as f64 / 1e9;
    let iterations = isolated.app.schema("high").iterations;
    isolated
        .app
        .until(|app| app.schema("high").iterations > iterations + 2);
    let seen = isolated.number("clock").expect("it was exported");
    let after = isolated.app.handle.now() as f64 / 1e9;
    assert!(before <= seen && seen <= after, "{before} {seen} {after}");
    isolated.app.stop();
}

fn the_start_fails_when_the_process_of_a_schema_cannot_start(executor: Executor) {
    let scenario = Scenario::new();
    let body = FAMILY.replacen(
        "type = \"faulty/faulty\"",
        "type = \"faulty/faulty\"\nisolate = \"process\"",
        1,
    );
    let start_error = |program| match IsolatedApp::try_start(executor, &scenario, &body, program) {
        Ok(_) => panic!("it started"),
        Err(error) => error.to_string(),
    };
    let error = start_error(None);
    assert!(
        error.contains("schema `high` requires a process of its own"),
        "{error}"
    );
    let missing = jde_isolation::Program {
        path: "/nowhere/jde".into(),
        arguments: Vec::new(),
    };
    let error = start_error(Some(missing));
    assert!(error.contains("its process cannot be started"), "{error}");
    let silent = jde_isolation::Program {
        path: "true".into(),
        arguments: Vec::new(),
    };
    let error = start_error(Some(silent));
    assert!(error.contains("exited by itself, with status 0"), "{error}");
}
