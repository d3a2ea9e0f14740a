//! Schemas that operators unload and load again (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use jde_board::value::Value;
use jde_core::{SchemaId, State};
use jde_records::event::{Event, Occurrence, OperatorAction, What};
use jde_records::snapshot::HoldKind;

use crate::common::{Call, Executor, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r14_an_unloaded_schema_ends_and_a_load_creates_a_fresh_instance,
    r14_an_unloaded_schema_returns_when_its_operator_releases_it,
    r10_an_instance_ends_after_the_iteration_in_which_it_was_unloaded,
    r14_a_schema_that_an_awake_schema_needs_is_unloaded_and_its_readers_are_named,
    r14_a_schema_that_sleeps_is_unloaded_at_once,
    an_application_with_unloaded_schemas_ends_in_order,
);

const APP: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.high]
    type = "test/motor"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
    children = { a = "left" }
    [schemas.left]
    type = "test/motor"
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// Starts the application. Returns also the number of calls of the live instance of `high`.
fn start(executor: Executor) -> (TestApp, Arc<AtomicU64>) {
    let scenario = Scenario::new();
    let calls = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&calls);
    scenario.on_call("high", move |call, io| {
        counted.store(io.memory, SeqCst);
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
            }
            _ => {}
        }
        Ok(())
    });
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    app.until(|app| app.scenario.count("high iterate") > 10);
    (app, calls)
}

fn r14_an_unloaded_schema_ends_and_a_load_creates_a_fresh_instance(executor: Executor) {
    let (mut app, calls) = start(executor);
    let high = app.index("high");
    let operator = app.operator();
    let before = calls.load(SeqCst);
    operator
        .modulate(high, "gain", &Value::Float(0.5))
        .expect("a modulation");
    assert!(
        operator
            .load(high)
            .expect_err("it is loaded")
            .contains("not unloaded")
    );
    operator.unload(high).expect("a motor schema");
    app.until_line("high drop");
    app.until_line("robot velocity 0.1");
    let view = app.schema("high");
    assert_eq!(view.state, State::Slept);
    let hold = view.operator.expect("it is held");
    assert_eq!((hold.kind, hold.by.as_str()), (HoldKind::Unloaded, "ana@laptop"));
    assert_eq!(app.winner("roots").as_deref(), Some("low"));
    let message = operator.play(high).expect_err("there is nothing to play");
    assert_eq!(message, "`high` is unloaded; load it first");
    assert_eq!(
        app.handle.value::<f64>("high.gain"),
        Ok(Some(0.5)),
        "variables stay"
    );

    let awakenings = app.scenario.count("high awake");
    operator.load(high).expect("it is unloaded");
    app.until(|app| app.winner("roots").as_deref() == Some("high"));
    app.until(|app| app.scenario.count("high awake") > awakenings);
    app.until(|_| (1..before).contains(&calls.load(SeqCst)));
    assert_eq!(app.scenario.count("high drop"), 1);
    for expected in [
        OperatorAction::Unload { schema: high },
        OperatorAction::Load { schema: high },
    ] {
        let performed = |event: &Event| matches!(event.what(), Some(What::Operator { action, .. }) if *action == expected);
        assert_eq!(app.scenario.count_events(performed), 1, "{expected:?}");
    }
    app.stop();
}

fn r14_an_unloaded_schema_returns_when_its_operator_releases_it(executor: Executor) {
    let (mut app, _) = start(executor);
    let high = app.index("high");
    app.operator().unload(high).expect("a motor schema");
    app.until_line("high drop");
    app.handle
        .operator("bob@base")
        .release_own(high)
        .expect("a release without holds is accepted");
    assert_eq!(app.schema("high").state, State::Slept);
    app.operator().release_own(high).expect("it has holds");
    app.until(|app| app.winner("roots").as_deref() == Some("high"));
    app.operator().unload(high).expect("a motor schema");
    app.until(|app| app.scenario.count("high drop") == 2);
    app.operator().release(high).expect("any operator may release it");
    app.until(|app| app.winner("roots").as_deref() == Some("high"));
    app.stop();
}

fn r10_an_instance_ends_after_the_iteration_in_which_it_was_unloaded(executor: Executor) {
    let (mut app, _) = start(executor);
    let high = app.index("high");
    app.scenario.on_call("high", move |call, io| {
        match (call, io.scenario.handle()) {
            (Call::Check, _) => io.ready(true),
            (Call::Iterate, Some(handle)) => {
                handle.operator("itself").unload(high).expect("a motor schema");
                io.record("continues");
            }
            (Call::Sleep, _) => io.record("sleeps"),
            (Call::Drop, _) => io.record("ends"),
            _ => {}
        }
        Ok(())
    });
    app.until_line("high ends");
    let lines = app.scenario.lines();
    let last = |line: &str| lines.iter().rposition(|recorded| recorded == line);
    assert!(last("high continues") < last("high sleeps"), "{lines:#?}");
    assert!(last("high sleeps") < last("high ends"), "{lines:#?}");
    assert_eq!(app.scenario.count("high continues"), 1);
    app.stop();
}

fn r14_a_schema_that_an_awake_schema_needs_is_unloaded_and_its_readers_are_named(executor: Executor) {
    let (mut app, _) = start(executor);
    let [eye, robot, high, low] = ["eye", "robot", "high", "low"].map(|name| app.index(name));
    let operator = app.operator();
    let losses = operator.stop(eye, true).expect("it is allowed");
    assert_eq!(losses, "high loses its input");
    let lost = |event: &Event| match event {
        Event::Other(Occurrence {
            what: What::Operator { action, losses, .. },
            ..
        }) => {
            let imports = losses.iter().map(|loss| (loss.reader, loss.import.as_str()));
            *action == OperatorAction::Unload { schema: eye } && imports.eq([(high, "input")])
        }
        _ => false,
    };
    assert_eq!(app.scenario.count_events(lost), 1);
    app.until_line("eye drop");
    app.until(|app| app.handle.value::<f64>("eye.out") == Ok(None));
    assert_eq!(
        app.winner("roots").as_deref(),
        Some("high"),
        "it reads no value, and acts on"
    );
    operator.load(eye).expect("it is unloaded");
    app.until(|app| app.handle.value::<f64>("eye.out") == Ok(Some(1.0)));

    // Only what it commands sleeps; what it sees is awake until no operator stops it.
    operator.hold_asleep(high).expect("it can be stopped");
    operator.hold_asleep(low).expect("it can be stopped");
    app.until(|app| app.schema("robot").state == State::Slept);
    assert_eq!(app.schema("eye").state, State::Winner);
    let losses = operator.stop(robot, true);
    assert_eq!(losses, Ok(String::new()), "no awake schema reads from it");
    app.until_line("robot drop");
    operator.unload(high).expect("a motor schema");
    app.until(|app| app.schema("eye").state == State::Slept);
    operator.release(low).expect("it can be released");
    operator.load(robot).expect("it is unloaded");
    app.until(|app| app.schema("robot").state == State::Winner);
    app.stop();
}

fn r14_a_schema_that_sleeps_is_unloaded_at_once(executor: Executor) {
    let (mut app, _) = start(executor);
    let left = app.index("left");
    let operator = app.operator();
    operator.play(left).expect("it can be played");
    app.until_line("left awake");
    operator.release(left).expect("it can be released");
    app.until_line("left sleep");
    operator.unload(left).expect("a motor schema");
    app.until_line("left drop");
    // No operator keeps `left` awake, so it stays asleep.
    operator.load(left).expect("it is unloaded");
    assert_eq!(app.schema("left").state, State::Slept);
    assert_eq!(app.schema("left").operator, None);
    operator.play(left).expect("it can be played");
    app.until(|app| app.schema("left").state != State::Slept);
    app.stop();
}

fn an_application_with_unloaded_schemas_ends_in_order(executor: Executor) {
    let (app, _) = start(executor);
    for name in ["left", "high", "low"] {
        let schema = app.index(name);
        app.operator().unload(schema).expect("a motor schema");
    }
    let handle = app.handle.clone();
    app.stop();
    let states = handle.snapshot().schemas.into_iter().map(|schema| schema.state);
    assert!(states.eq([State::Slept; 5]));
    assert!(handle.operator("ana").load(SchemaId(0)).is_err());
}
