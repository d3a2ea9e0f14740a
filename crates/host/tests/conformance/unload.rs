//! Schemas that operators unload and load again (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use jde_board::value::Value;
use jde_core::State;
use jde_records::event::{Event, OperatorAction};
use jde_records::snapshot::HoldKind;

use crate::common::{Call, Executor, Rig, Stage, on_every_executor};

on_every_executor!(
    r14_an_unloaded_schema_is_gone_until_it_is_loaded_and_then_begins_afresh,
    r14_an_unloaded_schema_comes_back_when_whoever_unloaded_it_lets_go,
    r10_an_instance_ends_after_the_iteration_in_which_it_was_unloaded,
    r6_what_somebody_awake_needs_is_not_unloaded,
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

/// Starts the application; `calls` counts those of the live instance of `high`.
fn start(executor: Executor) -> (Rig, Arc<AtomicU64>) {
    let stage = Stage::new();
    let calls = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&calls);
    stage.play("high", move |call, io| {
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
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, APP);
    rig.until(|rig| rig.stage.count("high iterate") > 10);
    (rig, calls)
}

fn r14_an_unloaded_schema_is_gone_until_it_is_loaded_and_then_begins_afresh(executor: Executor) {
    let (mut rig, calls) = start(executor);
    let high = rig.place("high");
    let operator = rig.operator();
    let before = calls.load(SeqCst);
    operator
        .modulate(high, "gain", &Value::Float(0.5))
        .expect("a modulation");
    assert!(
        operator
            .load(high)
            .expect_err("it is there")
            .contains("not unloaded")
    );
    operator.unload(high).expect("a motor schema");
    rig.until_did("high drop");
    rig.until_did("robot velocity 0.1");
    let view = rig.see("high");
    assert_eq!(view.state, State::Slept);
    let hold = view.operator.expect("it is held");
    assert_eq!((hold.kind, hold.by.as_str()), (HoldKind::Unloaded, "ana@laptop"));
    assert_eq!(rig.winner("roots").as_deref(), Some("low"));
    let said = operator.play(high).expect_err("there is nothing to play");
    assert_eq!(said, "`high` is unloaded; load it first");
    assert_eq!(
        rig.handle.value::<f64>("high.gain"),
        Ok(Some(0.5)),
        "variables stay"
    );

    let awoke = rig.stage.count("high awake");
    operator.load(high).expect("it is at rest");
    rig.until(|rig| rig.winner("roots").as_deref() == Some("high"));
    rig.until(|rig| rig.stage.count("high awake") > awoke);
    rig.until(|_| (1..before).contains(&calls.load(SeqCst)));
    assert_eq!(rig.stage.count("high drop"), 1);
    for wanted in [
        OperatorAction::Unload { schema: high },
        OperatorAction::Load { schema: high },
    ] {
        let told = |event: &Event| matches!(event, Event::Operator { action, .. } if *action == wanted);
        assert_eq!(rig.stage.count_events(told), 1, "{wanted:?}");
    }
    rig.stop();
}

fn r14_an_unloaded_schema_comes_back_when_whoever_unloaded_it_lets_go(executor: Executor) {
    let (mut rig, _) = start(executor);
    let high = rig.place("high");
    rig.operator().unload(high).expect("a motor schema");
    rig.until_did("high drop");
    rig.handle
        .operator("bob@base")
        .release_own(high)
        .expect("it is not his");
    assert_eq!(rig.see("high").state, State::Slept);
    rig.operator().release_own(high).expect("it is hers");
    rig.until(|rig| rig.winner("roots").as_deref() == Some("high"));
    rig.operator().unload(high).expect("a motor schema");
    rig.until(|rig| rig.stage.count("high drop") == 2);
    rig.operator().release(high).expect("anybody may");
    rig.until(|rig| rig.winner("roots").as_deref() == Some("high"));
    rig.stop();
}

fn r10_an_instance_ends_after_the_iteration_in_which_it_was_unloaded(executor: Executor) {
    let (mut rig, _) = start(executor);
    let high = rig.place("high");
    rig.stage.play("high", move |call, io| {
        match (call, io.stage.handle()) {
            (Call::Check, _) => io.ready(true),
            (Call::Iterate, Some(handle)) => {
                handle.operator("itself").unload(high).expect("a motor schema");
                io.say("goes on");
            }
            (Call::Sleep, _) => io.say("lies down"),
            (Call::Drop, _) => io.say("ends"),
            _ => {}
        }
        Ok(())
    });
    rig.until_did("high ends");
    let lines = rig.stage.lines();
    let last = |line: &str| lines.iter().rposition(|said| said == line);
    assert!(last("high goes on") < last("high lies down"), "{lines:#?}");
    assert!(last("high lies down") < last("high ends"), "{lines:#?}");
    assert_eq!(rig.stage.count("high goes on"), 1);
    rig.stop();
}

fn r6_what_somebody_awake_needs_is_not_unloaded(executor: Executor) {
    let (mut rig, _) = start(executor);
    let [eye, robot, high, low] = ["eye", "robot", "high", "low"].map(|name| rig.place(name));
    let operator = rig.operator();
    let said = operator.unload(robot).expect_err("it is needed");
    assert_eq!(
        said,
        "`robot` is needed by high, low, awake now; stop what needs it first"
    );
    assert!(
        operator
            .unload(eye)
            .expect_err("it is needed")
            .contains("by high,")
    );
    operator.hold_asleep(high).expect("it can be stopped");
    rig.until(|rig| rig.see("eye").state == State::Slept);
    operator.unload(eye).expect("nobody awake needs it");
    rig.until_did("eye drop");
    rig.until(|rig| rig.handle.value::<f64>("eye.out") == Ok(None));

    // A schema that needs the eye wakes up without it, and finds no value.
    operator.release(high).expect("it can be released");
    rig.until(|rig| rig.winner("roots").as_deref() == Some("high"));
    assert_eq!(rig.see("eye").state, State::Slept);
    operator.load(eye).expect("it is at rest");
    rig.until(|rig| rig.handle.value::<f64>("eye.out") == Ok(Some(1.0)));

    operator.hold_asleep(high).expect("it can be stopped");
    operator.hold_asleep(low).expect("it can be stopped");
    rig.until(|rig| rig.see("robot").state == State::Slept);
    operator.unload(robot).expect("nobody awake needs it");
    rig.until_did("robot drop");
    operator.release(low).expect("it can be released");
    operator.load(robot).expect("it is at rest");
    rig.until(|rig| rig.see("robot").state == State::Winner);
    rig.stop();
}

fn r14_a_schema_that_sleeps_is_unloaded_at_once(executor: Executor) {
    let (mut rig, _) = start(executor);
    let left = rig.place("left");
    let operator = rig.operator();
    operator.play(left).expect("it can be played");
    rig.until_did("left awake");
    operator.release(left).expect("it can be released");
    rig.until_did("left sleep");
    operator.unload(left).expect("a motor schema");
    rig.until_did("left drop");
    // No request keeps it awake, so it is released and stays asleep.
    operator.load(left).expect("it is at rest");
    assert_eq!(rig.see("left").state, State::Slept);
    assert_eq!(rig.see("left").operator, None);
    operator.play(left).expect("it can be played");
    rig.until(|rig| rig.see("left").state != State::Slept);
    rig.stop();
}

fn an_application_with_unloaded_schemas_ends_in_order(executor: Executor) {
    let (rig, _) = start(executor);
    for name in ["left", "high", "low"] {
        let place = rig.place(name);
        rig.operator().unload(place).expect("a motor schema");
    }
    let handle = rig.handle.clone();
    rig.stop();
    let states = handle.snapshot().schemas.into_iter().map(|schema| schema.state);
    assert!(states.eq([State::Slept; 5]));
    assert!(handle.operator("ana").load(0).is_err());
}
