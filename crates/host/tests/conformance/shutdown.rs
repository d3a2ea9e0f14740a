//! Every end has the same order: actuators first, then children before fathers, drivers last; then the
//! instances in reverse order.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use jde_board::value::Value;
use jde_core::State;
use jde_host::Options;
use jde_records::event::{Event, Outcome};

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    stop_ends_in_order,
    a_mission_that_is_done_ends_in_order,
    a_mission_that_failed_ends_in_order,
    the_limit_ends_in_order,
    a_drop_ends_in_order,
    a_panic_of_the_caller_ends_in_order,
    a_handle_is_of_use_after_the_end,
    the_first_outcome_counts,
    an_observer_that_panics_ends_the_application_with_actuators_at_rest,
);

mod real_time {
    use super::{
        r7_nobody_gains_authority_while_the_end_is_under_way, who_was_just_put_to_sleep_is_waited_for,
    };

    crate::common::in_real_time!(
        who_was_just_put_to_sleep_is_waited_for,
        r7_nobody_gains_authority_while_the_end_is_under_way,
    );
}

const FAMILY: &str = r#"
    roots = ["father"]
    mission = "father.mission"
    [schemas.robot]
    type = "test/robot"
    [schemas.father]
    type = "test/motor"
    children = { a = "son" }
    [schemas.son]
    type = "test/motor"
    children = { a = "grandson" }
    [schemas.grandson]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn start_with(executor: Executor, options: Options) -> Rig {
    let stage = Stage::new();
    for name in ["father", "son"] {
        stage.play(name, |call, io| {
            match call {
                Call::Check => io.ready(true),
                Call::Iterate => {
                    io.wake("a");
                }
                Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
            }
            Ok(())
        });
    }
    stage.drives("grandson", &Arc::new(true.into()), 0.1);
    Rig::start_with(executor, &stage, FAMILY, options)
}

fn start(executor: Executor) -> Rig {
    let mut rig = start_with(executor, Options::default());
    rig.until_did("robot velocity 0.1");
    rig
}

/// Asserts that everything came to rest in the order of the rules.
#[track_caller]
fn at_rest(stage: &Stage) {
    let order = [
        "robot velocity 0",
        "grandson sleep",
        "son sleep",
        "father sleep",
        "robot sleep",
        "grandson drop",
        "son drop",
        "father drop",
        "robot drop",
    ];
    let places = order.map(|line| stage.last(line));
    assert!(places.is_sorted(), "{:#?}", stage.lines());
    for line in order {
        assert_eq!(stage.count(line), 1, "{line}");
    }
}

fn stop_ends_in_order(executor: Executor) {
    let rig = start(executor);
    let stage = Arc::clone(&rig.stage);
    assert_eq!(rig.stop(), Outcome::Stopped);
    at_rest(&stage);
    assert!(matches!(
        stage.events().last(),
        Some(Event::Ended {
            outcome: Outcome::Stopped,
            ..
        })
    ));
}

fn a_mission_that_is_done_ends_in_order(executor: Executor) {
    mission(executor, 101.0, Outcome::Done);
}

fn a_mission_that_failed_ends_in_order(executor: Executor) {
    mission(executor, 102.0, Outcome::Failed);
}

fn mission(executor: Executor, gain: f64, outcome: Outcome) {
    let rig = start(executor);
    let stage = Arc::clone(&rig.stage);
    let father = rig.place("father");
    // It runs while its mission is not over.
    rig.operator()
        .modulate(father, "gain", &Value::Float(100.0))
        .expect("a modulation");
    rig.operator()
        .modulate(father, "gain", &Value::Float(gain))
        .expect("a modulation");
    assert_eq!(rig.wait(), outcome);
    at_rest(&stage);
}

fn the_limit_ends_in_order(executor: Executor) {
    let mut rig = start_with(
        executor,
        Options {
            limit: Some(300 * MS),
            ..Options::default()
        },
    );
    // On a busy machine the limit may occur before the first command.
    rig.until(|rig| rig.stage.did("robot velocity 0.1") || rig.handle.outcome().is_some());
    let stage = Arc::clone(&rig.stage);
    let handle = rig.handle.clone();
    assert_eq!(rig.wait(), Outcome::TimeUp);
    assert!(handle.now() >= 300 * MS);
    if stage.did("robot velocity 0.1") {
        at_rest(&stage);
    }
}

fn a_drop_ends_in_order(executor: Executor) {
    let rig = start(executor);
    let stage = Arc::clone(&rig.stage);
    let handle = rig.handle.clone();
    drop(rig);
    at_rest(&stage);
    assert_eq!(handle.outcome(), Some(Outcome::Stopped));
}

fn a_panic_of_the_caller_ends_in_order(executor: Executor) {
    let rig = start(executor);
    let stage = Arc::clone(&rig.stage);
    let caught = catch_unwind(AssertUnwindSafe(move || {
        let _runs = rig;
        std::panic::resume_unwind(Box::new("the caller's own"));
    }));
    assert!(caught.is_err());
    at_rest(&stage);
}

fn a_handle_is_of_use_after_the_end(executor: Executor) {
    let rig = start(executor);
    let handle = rig.handle.clone();
    let father = rig.place("father");
    rig.stop();
    let snapshot = handle.snapshot();
    assert!(
        snapshot
            .schemas
            .iter()
            .all(|view| view.state == State::Slept && !view.authority)
    );
    assert!(snapshot.groups.iter().all(|group| group.winner.is_none()));
    for refused in [
        handle.operator("ana@laptop").play(father),
        handle.operator("ana@laptop").force(father),
        handle.operator("ana@laptop").hold_asleep(father),
        handle.operator("ana@laptop").release(father),
    ] {
        assert!(refused.is_err());
    }
    handle.stop();
    assert_eq!(handle.outcome(), Some(Outcome::Stopped));
}

fn the_first_outcome_counts(executor: Executor) {
    let rig = start(executor);
    rig.handle.stop();
    let father = rig.place("father");
    rig.operator()
        .modulate(father, "gain", &Value::Float(101.0))
        .expect("a modulation");
    assert_eq!(rig.wait(), Outcome::Stopped);
}

fn an_observer_that_panics_ends_the_application_with_actuators_at_rest(executor: Executor) {
    let stage = Stage::new();
    let mut once = true;
    let panics = move |event: &Event| {
        if matches!(event, Event::Refused { .. }) && std::mem::take(&mut once) {
            // Without the output of the panic hook.
            std::panic::resume_unwind(Box::new("an observer's own"));
        }
    };
    let options = Options {
        observers: vec![Box::new(panics)],
        ..Options::default()
    };
    stage.drives("low", &Arc::new(true.into()), 0.1);
    // It commands without authority once low drives. An observer receives that event within the call.
    stage.play("high", |call, io| {
        if call == Call::Check && io.stage.did("robot velocity 0.1") {
            io.command(0.3);
        }
        Ok(())
    });
    let body = r#"
        roots = ["high", "low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start_with(executor, &stage, body, options);
    rig.until_did("robot velocity 0.1");
    let Outcome::Broken(reason) = rig.wait() else {
        panic!("it is the host's fault");
    };
    assert!(reason.starts_with("the host itself panicked"), "{reason}");
    assert!(stage.last("robot velocity 0") < stage.first("robot sleep"));
}

fn who_was_just_put_to_sleep_is_waited_for(executor: Executor) {
    let mut rig = start(executor);
    let stage = Arc::clone(&rig.stage);
    stage.play("grandson", |call, io| {
        if call == Call::Sleep {
            // Long enough that the end is in progress; the end waits up to a second.
            let end = io.now() + 300 * MS;
            while io.now() < end {
                std::thread::yield_now();
            }
            io.say("lies down");
        }
        Ok(())
    });
    rig.operator()
        .hold_asleep(rig.place("son"))
        .expect("it can be stopped");
    rig.until_did("grandson sleep");
    assert_eq!(rig.stop(), Outcome::Stopped);
    assert!(stage.first("grandson lies down") < stage.first("father sleep"));
    assert_eq!(stage.count("grandson drop"), 1);
    assert!(!stage.told(|event| matches!(event, Event::Hung { .. })));
}

fn r7_nobody_gains_authority_while_the_end_is_under_way(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("high", |call, io| {
        match call {
            Call::Check => io.ready(io.stage.did("robot velocity 0")),
            Call::Iterate => {
                let outcome = io.command(0.3);
                io.say(format!("{outcome:?}"));
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    // While the robot brakes for the last time, another schema becomes READY, and wins.
    stage.play("robot", |call, io| {
        let end = io.now() + 5_000 * MS;
        while call == Call::Iterate
            && io.stage.did("robot velocity 0")
            && !io.stage.did("high Refused")
            && !io.stage.did("high sleep")
            && io.now() < end
        {
            std::thread::yield_now();
        }
        Ok(())
    });
    let body = r#"
        roots = ["high", "low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.1");
    assert_eq!(rig.stop(), Outcome::Stopped);
    assert_eq!(stage.count("high Accepted"), 0);
    assert!(!stage.did("robot velocity 0.3"));
}
