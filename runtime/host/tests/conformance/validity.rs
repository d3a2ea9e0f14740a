//! How values end (R19): with their validity, with the sleep of their writer, and for every reader.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};

use jde_core::{Health, State};
use jde_schema::NoValue;

use crate::common::{Call, Executor, MS, Scenario, TestApp, in_languages, on_every_executor};

on_every_executor!(
    r19_the_values_of_a_schema_that_is_stopped_end_at_once,
    r19_nobody_reads_a_value_of_before_the_sleep_of_its_writer,
    r19_a_value_that_is_not_renewed_ends_whatever_period_an_operator_writes,
    r19_an_import_may_take_no_value_of_an_age_that_the_writer_permits,
    r19_an_iteration_without_a_value_ends_what_it_made_and_is_no_fault,
    r19_a_schema_that_is_forced_without_a_value_commands_nothing,
    r7_a_period_that_an_operator_writes_lengthens_no_command,
);

mod real_time {
    use super::r19_the_value_of_a_call_that_does_not_return_ends_before_the_call_hangs;

    crate::common::in_real_time!(r19_the_value_of_a_call_that_does_not_return_ends_before_the_call_hangs);
}

in_languages!(Lockstep, [C Cpp Python]:
    r19_the_values_of_a_schema_that_is_stopped_end_at_once,
    r19_a_value_that_is_not_renewed_ends_whatever_period_an_operator_writes,
    r19_a_schema_that_is_forced_without_a_value_commands_nothing,
);

/// `low` drives while the eye has a value. Nothing but its period lets it check, which is long.
const SEES: &str = r#"
    roots = ["low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.low]
    type = "test/motor"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
"#;

/// Lets `low` drive while it has an input.
fn drive_while_seeing(scenario: &Scenario) {
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(io.input().is_some()),
            Call::Iterate => _ = io.command(0.1),
            _ => {}
        }
        Ok(())
    });
}

/// Lets the eye publish while `sees` is true.
fn publish_while(scenario: &Scenario, sees: &Arc<AtomicBool>) {
    let sees = Arc::clone(sees);
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate && sees.load(SeqCst) {
            io.publish(1.0);
        }
        Ok(())
    });
}

fn r19_the_values_of_a_schema_that_is_stopped_end_at_once(executor: Executor) {
    let scenario = Scenario::new();
    drive_while_seeing(&scenario);
    publish_while(&scenario, &Arc::new(true.into()));
    let mut app = TestApp::start(executor, &scenario, SEES);
    app.until_line("robot velocity 0.1");
    // The end of the value is the only reason for a check.
    let low = app.index("low");
    app.operator().set_period(low, 3_600_000 * MS).expect("a period");
    app.until(|app| app.schema("low").period == 3_600_000 * MS);
    let eye = app.index("eye");
    app.operator().hold_asleep(eye).expect("the operator may");
    app.until_line("robot velocity 0");
    assert_eq!(app.schema("low").state, State::Checking);
    app.operator().release(eye).expect("the operator may");
    app.stop();
}

fn r19_nobody_reads_a_value_of_before_the_sleep_of_its_writer(executor: Executor) {
    let scenario = Scenario::new();
    let woken = Arc::new(AtomicU64::new(0));
    let wakes = Arc::clone(&woken);
    scenario.on_call("eye", move |call, io| {
        match call {
            Call::Awake => wakes.store(io.now(), SeqCst),
            Call::Iterate => io.publish(io.now() as f64),
            _ => {}
        }
        Ok(())
    });
    scenario.on_call("low", move |call, io| {
        if call == Call::Check {
            if let Some((published, _)) = io.input() {
                let is_new = published >= woken.load(SeqCst) as f64;
                io.record(if is_new {
                    "reads a new value"
                } else {
                    "reads an old value"
                });
            }
            io.ready(true);
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, SEES);
    let low = app.index("low");
    for _ in 0..3 {
        let seen = scenario.count("low reads a new value");
        app.until(|app| app.scenario.count("low reads a new value") > seen);
        let slept = scenario.count("eye sleep");
        // Who stops a schema still needs what it needed; who unloads it does not (R6).
        app.operator().unload(low).expect("the operator may");
        app.until(|app| app.scenario.count("eye sleep") > slept);
        app.until(|app| app.operator().load(low).is_ok());
    }
    app.stop();
    assert!(
        !scenario.has_line("low reads an old value"),
        "{:#?}",
        scenario.lines()
    );
}

fn r19_a_value_that_is_not_renewed_ends_whatever_period_an_operator_writes(executor: Executor) {
    let scenario = Scenario::new();
    drive_while_seeing(&scenario);
    let sees = Arc::new(true.into());
    publish_while(&scenario, &sees);
    let mut app = TestApp::start(executor, &scenario, SEES);
    app.until_line("robot velocity 0.1");
    let eye = app.index("eye");
    app.operator().set_period(eye, 3_600_000 * MS).expect("a period");
    sees.store(false, SeqCst);
    app.until_line("robot velocity 0");
    assert_eq!(
        app.schema("eye").health,
        Health::Ok,
        "it is silent, and has not failed"
    );
    let end = app.handle.now();
    let status = app.handle.board().find("eye.out").expect("an export").status(end);
    assert!(status.ended);
    // Three periods are less than the least validity of 60 ms.
    assert!(status.age.is_some_and(|age| age > 60 * MS), "{status:?}");
    if executor == Executor::Lockstep {
        assert!(status.age.is_some_and(|age| age <= 80 * MS), "{status:?}");
    }
    app.stop();
}

fn r19_an_import_may_take_no_value_of_an_age_that_the_writer_permits(executor: Executor) {
    let scenario = Scenario::new();
    drive_while_seeing(&scenario);
    let sees = Arc::new(true.into());
    publish_while(&scenario, &sees);
    let body = SEES
        .replace(r#""eye.out""#, r#"{ from = "eye.out", stale = "2s" }"#)
        .replace(r#"type = "test/eye""#, "type = \"test/eye\"\nperiod = \"1000s\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.1");
    sees.store(false, SeqCst);
    app.until_line("robot velocity 0");
    let now = app.handle.now();
    let variable = app.handle.board().find("eye.out").expect("an export");
    assert!(variable.has_value(now), "others may read it still");
    app.stop();
}

/// Lets `low` drive by its input, without which its iteration cannot act. Its check needs the input too, or believes that
/// it always can.
fn drive_by_the_input(scenario: &Scenario, is_checked: bool) {
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => {
                if is_checked {
                    io.input().ok_or(NoValue { import: "input" })?;
                }
                io.ready(true);
            }
            Call::Iterate => {
                io.input().ok_or(NoValue { import: "input" })?;
                _ = io.command(0.1);
            }
            _ => {}
        }
        Ok(())
    });
}

fn r19_an_iteration_without_a_value_ends_what_it_made_and_is_no_fault(executor: Executor) {
    let scenario = Scenario::new();
    drive_by_the_input(&scenario, true);
    scenario.on_call("lens", |call, io| {
        if call == Call::Iterate {
            let (seen, _) = io.input().ok_or(NoValue { import: "input" })?;
            io.publish(seen);
        }
        Ok(())
    });
    let sees = Arc::new(AtomicBool::new(true));
    publish_while(&scenario, &sees);
    // What the lens made would be valid for ever.
    let lens = r#"
        [schemas.lens]
        type = "test/eye"
        period = "1000s"
        triggers = ["input"]
        imports = { input = "eye.out" }
    "#;
    let body = SEES.replace("eye.out", "lens.out") + lens;
    let mut app = TestApp::start(executor, &scenario, &body);
    for time in 1..=3 {
        app.until(|app| app.scenario.count("robot velocity 0.1") >= time);
        let stops = scenario.count("robot velocity 0");
        sees.store(false, SeqCst);
        app.until(|app| app.scenario.count("robot velocity 0") > stops);
        app.until(|app| app.schema("low").state == State::Checking);
        assert_eq!(app.schema("low").health, Health::Ok);
        assert_eq!(app.schema("lens").health, Health::Ok);
        let made = app.handle.board().find("lens.out").expect("an export");
        assert!(
            !made.has_value(app.handle.now()),
            "it was made of a value that has ended"
        );
        sees.store(true, SeqCst);
    }
    app.until(|app| app.scenario.count("robot velocity 0.1") > 3);
    app.stop();
}

fn r19_a_schema_that_is_forced_without_a_value_commands_nothing(executor: Executor) {
    let scenario = Scenario::new();
    drive_by_the_input(&scenario, false);
    let sees = Arc::new(AtomicBool::new(true));
    publish_while(&scenario, &sees);
    let mut app = TestApp::start(executor, &scenario, SEES);
    let low = app.index("low");
    app.operator().force(low).expect("the operator may");
    app.until_line("robot velocity 0.1");
    let stops = scenario.count("robot velocity 0");
    sees.store(false, SeqCst);
    app.until(|app| app.scenario.count("robot velocity 0") > stops);
    let seen = scenario.count("low iterate");
    app.until(|app| app.scenario.count("low iterate") > seen + 2);
    assert_eq!(app.schema("low").state, State::Winner);
    assert_eq!(app.schema("low").health, Health::Ok);
    app.stop();
}

fn r7_a_period_that_an_operator_writes_lengthens_no_command(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => _ = io.reach(0.1),
            _ => {}
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.low]
        type = "test/motor"
        actuators = { arm = "robot.reach" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot reach 0.1");
    let low = app.index("low");
    app.operator().set_period(low, 1_000_000 * MS).expect("a period");
    // Its driver states 50 ms.
    app.until_line("robot reach 0");
    assert_eq!(app.schema("low").state, State::Winner);
    app.stop();
}

fn r19_the_value_of_a_call_that_does_not_return_ends_before_the_call_hangs(executor: Executor) {
    let scenario = Scenario::new();
    drive_while_seeing(&scenario);
    let held = Arc::new(AtomicBool::new(false));
    let holds = Arc::clone(&held);
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
            let scenario = Arc::clone(io.scenario);
            scenario.wait_until(|| !holds.load(SeqCst));
        }
        Ok(())
    });
    let body = SEES.replace(r#"type = "test/eye""#, "type = \"test/eye\"\nhang = \"1000s\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.1");
    held.store(true, SeqCst);
    app.until_line("robot velocity 0");
    assert_eq!(app.schema("eye").health, Health::Ok);
    held.store(false, SeqCst);
    scenario.notify();
    app.stop();
}
