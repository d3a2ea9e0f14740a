//! Every end has the same order: actuators first, then children before fathers, drivers last; then the
//! instances in reverse order.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use jde_board::value::Value;
use jde_core::State;
use jde_host::Options;
use jde_records::event::{Event, Occurrence, Outcome, What};

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor};

on_every_executor!(
    stop_ends_in_order,
    a_mission_that_is_done_ends_in_order,
    a_mission_that_failed_ends_in_order,
    the_limit_ends_in_order,
    a_drop_ends_in_order,
    a_panic_of_the_caller_ends_in_order,
    an_instance_that_panics_in_its_end_keeps_no_other_from_its_own,
    a_handle_remains_usable_after_the_end,
    the_first_outcome_counts,
    an_observer_that_panics_ends_the_application_with_actuators_stopped,
);

mod real_time {
    use super::{
        r7_no_schema_gains_authority_while_the_application_ends,
        the_end_waits_for_a_schema_that_is_going_to_sleep,
    };

    crate::common::in_real_time!(
        the_end_waits_for_a_schema_that_is_going_to_sleep,
        r7_no_schema_gains_authority_while_the_application_ends,
    );
}

const FAMILY: &str = r#"
    roots = ["father"]
    mission = "father.mission"
    [schemas.robot]
    type = "test/robot"
    [schemas.father]
    type = "test/motor"
    children = { a = "child" }
    [schemas.child]
    type = "test/motor"
    children = { a = "grandchild" }
    [schemas.grandchild]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn start_with(executor: Executor, options: Options) -> TestApp {
    let scenario = Scenario::new();
    for name in ["father", "child"] {
        scenario.on_call(name, |call, io| {
            match call {
                Call::Check => io.ready(true),
                Call::Iterate => {
                    io.wake("a");
                }
                _ => {}
            }
            Ok(())
        });
    }
    scenario.drives("grandchild", &Arc::new(true.into()), 0.1);
    TestApp::start_with(executor, &scenario, FAMILY, options)
}

fn start(executor: Executor) -> TestApp {
    let mut app = start_with(executor, Options::default());
    app.until_line("robot velocity 0.1");
    app
}

/// Asserts that everything ended in the order of the rules.
#[track_caller]
fn assert_ended_in_order(scenario: &Scenario) {
    let order = [
        "robot velocity 0",
        "grandchild sleep",
        "child sleep",
        "father sleep",
        "robot sleep",
        "grandchild drop",
        "child drop",
        "father drop",
        "robot drop",
    ];
    let positions = order.map(|line| scenario.last(line));
    assert!(positions.is_sorted(), "{:#?}", scenario.lines());
    for line in order {
        assert_eq!(scenario.count(line), 1, "{line}");
    }
}

fn stop_ends_in_order(executor: Executor) {
    let app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    assert_eq!(app.stop(), Outcome::Stopped);
    assert_ended_in_order(&scenario);
    assert!(matches!(
        scenario.events().last(),
        Some(Event::Other(Occurrence {
            what: What::Ended {
                outcome: Outcome::Stopped,
                ..
            },
            ..
        }))
    ));
}

fn a_mission_that_is_done_ends_in_order(executor: Executor) {
    mission(executor, 101.0, Outcome::Done);
}

fn a_mission_that_failed_ends_in_order(executor: Executor) {
    mission(executor, 102.0, Outcome::Failed);
}

fn mission(executor: Executor, gain: f64, outcome: Outcome) {
    let app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    let father = app.index("father");
    // The father runs until its mission has ended.
    app.operator()
        .modulate(father, "gain", &Value::Float(100.0))
        .expect("a modulation");
    app.operator()
        .modulate(father, "gain", &Value::Float(gain))
        .expect("a modulation");
    assert_eq!(app.wait(), outcome);
    assert_ended_in_order(&scenario);
}

fn the_limit_ends_in_order(executor: Executor) {
    let mut app = start_with(
        executor,
        Options {
            limit: Some(300 * MS),
            ..Options::default()
        },
    );
    // On a busy machine the limit may occur before the first command.
    app.until(|app| app.scenario.has_line("robot velocity 0.1") || app.handle.outcome().is_some());
    let scenario = Arc::clone(&app.scenario);
    let handle = app.handle.clone();
    assert_eq!(app.wait(), Outcome::TimeUp);
    assert!(handle.now() >= 300 * MS);
    if scenario.has_line("robot velocity 0.1") {
        assert_ended_in_order(&scenario);
    }
}

fn a_drop_ends_in_order(executor: Executor) {
    let app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    let handle = app.handle.clone();
    drop(app);
    assert_ended_in_order(&scenario);
    assert_eq!(handle.outcome(), Some(Outcome::Stopped));
}

fn a_panic_of_the_caller_ends_in_order(executor: Executor) {
    let app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    let caught = catch_unwind(AssertUnwindSafe(move || {
        let _app = app;
        std::panic::resume_unwind(Box::new("a panic of the caller"));
    }));
    assert!(caught.is_err());
    assert_ended_in_order(&scenario);
}

fn a_handle_remains_usable_after_the_end(executor: Executor) {
    let app = start(executor);
    let handle = app.handle.clone();
    let father = app.index("father");
    app.stop();
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

fn an_instance_that_panics_in_its_end_keeps_no_other_from_its_own(executor: Executor) {
    let app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    scenario.on_call("child", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Drop => panic!("a panic in drop"),
            _ => {}
        }
        Ok(())
    });
    assert_eq!(app.stop(), Outcome::Stopped);
    assert_ended_in_order(&scenario);
}

fn the_first_outcome_counts(executor: Executor) {
    let app = start(executor);
    app.handle.stop();
    let father = app.index("father");
    app.operator()
        .modulate(father, "gain", &Value::Float(101.0))
        .expect("a modulation");
    assert_eq!(app.wait(), Outcome::Stopped);
}

fn an_observer_that_panics_ends_the_application_with_actuators_stopped(executor: Executor) {
    let scenario = Scenario::new();
    let mut first = true;
    let panics = move |event: &Event| {
        if matches!(event.what(), Some(What::Refused { .. })) && std::mem::take(&mut first) {
            // Without the output of the panic hook.
            std::panic::resume_unwind(Box::new("a panic of the observer"));
        }
    };
    let options = Options {
        observers: vec![Box::new(panics)],
        ..Options::default()
    };
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    // `high` commands without authority once `low` drives. The observer receives the refusal within that call.
    scenario.on_call("high", |call, io| {
        if call == Call::Check && io.scenario.has_line("robot velocity 0.1") {
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
    let mut app = TestApp::start_with(executor, &scenario, body, options);
    app.until_line("robot velocity 0.1");
    let Outcome::Broken(reason) = app.wait() else {
        panic!("the outcome is not Broken");
    };
    assert!(reason.starts_with("the host itself panicked"), "{reason}");
    assert!(scenario.last("robot velocity 0") < scenario.first("robot sleep"));
}

fn the_end_waits_for_a_schema_that_is_going_to_sleep(executor: Executor) {
    let mut app = start(executor);
    let scenario = Arc::clone(&app.scenario);
    scenario.on_call("grandchild", |call, io| {
        if call == Call::Sleep {
            // Long enough that the application is ending, which waits up to a second.
            let end = io.now() + 300 * MS;
            while io.now() < end {
                std::thread::yield_now();
            }
            io.record("sleeps now");
        }
        Ok(())
    });
    app.operator()
        .hold_asleep(app.index("child"))
        .expect("it can be stopped");
    app.until_line("grandchild sleep");
    assert_eq!(app.stop(), Outcome::Stopped);
    assert!(scenario.first("grandchild sleeps now") < scenario.first("father sleep"));
    assert_eq!(scenario.count("grandchild drop"), 1);
    assert!(!scenario.has_event(|event| matches!(event.what(), Some(What::Hung { .. }))));
}

fn r7_no_schema_gains_authority_while_the_application_ends(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("high", |call, io| {
        match call {
            Call::Check => io.ready(io.scenario.has_line("robot velocity 0")),
            Call::Iterate => {
                let outcome = io.command(0.3);
                io.record(format!("{outcome:?}"));
            }
            _ => {}
        }
        Ok(())
    });
    // While the robot brakes for the last time, another schema becomes READY and wins.
    scenario.on_call("robot", |call, io| {
        let end = io.now() + 5_000 * MS;
        while call == Call::Iterate
            && io.scenario.has_line("robot velocity 0")
            && !io.scenario.has_line("high Refused")
            && !io.scenario.has_line("high sleep")
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.1");
    assert_eq!(app.stop(), Outcome::Stopped);
    assert_eq!(scenario.count("high Accepted"), 0);
    assert!(!scenario.has_line("robot velocity 0.3"));
}
