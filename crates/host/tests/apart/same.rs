//! A schema in a process of its own decides and exports exactly what it does in the host's process, bit for
//! bit.

use std::path::Path;
use std::sync::{Arc, Mutex};

use jde_app::parse;
use jde_board::Stamp;
use jde_host::{Lockstep, Options};
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::{Event, Observer};
use jde_types::LaserScan;

use crate::common::{Executor, MS, Stage, on_every_executor};
use crate::stage::{Play, RUNNING, all_plugins, program};

on_every_executor!(
    large_values_cross_both_ways,
    a_schema_apart_sees_the_applications_time,
    one_that_cannot_be_loaded_does_not_start,
);

/// A father that arbitrates, its children, and the modulation that it sets. Either all run in processes of
/// their own or none does.
const FAMILY: &str = r#"
    roots = ["high"]
    seed = 7
    [schemas.high]
    type = "odd/odd"
    period = "20ms"
    children = { a = "left", b = "right" }
    [schemas.left]
    type = "odd/odd"
    period = "15ms"
    imports = { scan = "high.seen" }
    [schemas.right]
    type = "odd/odd"
    period = "35ms"
    imports = { scan = "left.seen" }
"#;

/// Runs for two seconds. Returns the decisions as lines, and every value with its stamp.
fn drive(body: &str) -> (String, Vec<(String, Stamp, Vec<u8>)>) {
    let plugins = all_plugins();
    let application =
        parse(body, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let decisions = Arc::new(Mutex::new(DecisionWriter::new(&application, Vec::new())));
    let hears = Arc::clone(&decisions);
    let observer: Box<dyn Observer> = Box::new(move |event: &Event| hears.lock().unwrap().on_event(event));
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
            let (values, of) = (Arc::clone(&values), Arc::downgrade(&variable));
            variable.watch(move || {
                let Some(variable) = of.upgrade() else { return };
                let mut reader = variable.reader("test");
                if let Some(latched) = reader.latch() {
                    let name = variable.describe().full_name();
                    values
                        .lock()
                        .unwrap()
                        .push((name, latched.stamp, latched.bytes.to_vec()));
                }
            })
        })
        .collect();
    run.run_until(2000 * MS);
    drop((watches, handle));
    drop(run);
    let decisions = Arc::into_inner(decisions).expect("nobody else has it");
    let lines = decisions
        .into_inner()
        .unwrap()
        .finish()
        .expect("memory takes all");
    let values = std::mem::take(&mut *values.lock().unwrap());
    (String::from_utf8(lines).expect("lines of text"), values)
}

#[test]
fn r16_lockstep_decides_and_exports_the_same_apart() {
    let _among = RUNNING.read().unwrap_or_else(std::sync::PoisonError::into_inner);
    let (decided, exported) = drive(FAMILY);
    assert!(decided.lines().count() > 20, "{decided}");
    let apart = FAMILY.replace("type = \"odd/odd\"", "type = \"odd/odd\"\nisolate = \"process\"");
    let (decided_apart, exported_apart) = drive(&apart);
    assert_eq!(decided, decided_apart);
    assert_eq!(exported.len(), exported_apart.len());
    for (here, apart) in exported.iter().zip(&exported_apart) {
        assert!(here == apart, "{} differs at {:?}", here.0, here.1);
    }
}

fn large_values_cross_both_ways(executor: Executor) {
    let stage = Stage::new();
    let body = FAMILY.replacen(
        "type = \"odd/odd\"",
        "type = \"odd/odd\"\nisolate = \"process\"",
        1,
    );
    let mut play = Play::start(executor, &stage, &body);
    let shared = play.rig.handle.board().find("high.seen").expect("it is there");
    assert!(shared.shared().is_some(), "it is too large for messages");
    let seen = |rig: &crate::common::Rig, name: &str| {
        let scan = rig.handle.value::<LaserScan>(name).expect("it is one");
        scan.map_or(0.0, |scan| scan.ranges[0])
    };
    play.rig
        .until(|rig| seen(rig, "high.seen") > 5.0 && seen(rig, "left.seen") > 1.0);
    play.rig.stop();
}

fn a_schema_apart_sees_the_applications_time(executor: Executor) {
    let stage = Stage::new();
    let body = FAMILY.replacen(
        "type = \"odd/odd\"",
        "type = \"odd/odd\"\nisolate = \"process\"",
        1,
    );
    let mut play = Play::start(executor, &stage, &body);
    play.rig.until(|rig| rig.see("high").iterations > 3);
    let before = play.rig.handle.now() as f64 / 1e9;
    let iterations = play.rig.see("high").iterations;
    play.rig.until(|rig| rig.see("high").iterations > iterations + 2);
    let seen = play.number("clock").expect("it tells");
    let after = play.rig.handle.now() as f64 / 1e9;
    assert!(before <= seen && seen <= after, "{before} {seen} {after}");
    play.rig.stop();
}

fn one_that_cannot_be_loaded_does_not_start(executor: Executor) {
    let stage = Stage::new();
    let body = FAMILY.replacen(
        "type = \"odd/odd\"",
        "type = \"odd/odd\"\nisolate = \"process\"",
        1,
    );
    let refused = |apart| match Play::try_start(executor, &stage, &body, apart) {
        Ok(_) => panic!("it started"),
        Err(error) => error.to_string(),
    };
    let words = refused(None);
    assert!(
        words.contains("schema `high` wants a process of its own"),
        "{words}"
    );
    let nowhere = jde_isolation::Program {
        path: "/nowhere/jde".into(),
        arguments: Vec::new(),
    };
    let words = refused(Some(nowhere));
    assert!(words.contains("its process cannot be started"), "{words}");
    let silent = jde_isolation::Program {
        path: "true".into(),
        arguments: Vec::new(),
    };
    let words = refused(Some(silent));
    assert!(words.contains("exited by itself, with status 0"), "{words}");
}
