//! Judgements that do not return (R18): the guard hangs, and whoever commands or reads a command goes on.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_core::Health;

use super::guards::{TWO, commands_once, guarded};
use super::hangs::hung;
use crate::common::{Call, Executor, Scenario, TestApp, in_real_time};

// In lockstep, a call that never returns stops the run.
in_real_time!(
    r18_a_judgement_that_hangs_is_a_hang_of_the_guard,
    r18_a_hung_judgement_of_a_command_in_force_is_a_hang_of_the_guard,
);

/// The guard hangs within 50 ms.
fn impatient() -> String {
    TWO.replace(
        "type = \"test/eye\"",
        "type = \"test/eye\"\nhang = \"50ms\"\nrestart = \"never\"",
    )
}

fn r18_a_judgement_that_hangs_is_a_hang_of_the_guard(executor: Executor) {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, Some(-2.0));
    let ready = Arc::new(AtomicBool::new(false));
    let is_ready = Arc::clone(&ready);
    scenario.on_call("high", move |call, io| {
        match call {
            Call::Check => io.ready(is_ready.load(Ordering::SeqCst)),
            // The call that hangs keeps no lock that its successor needs.
            Call::Iterate => io.then(|io| _ = io.command(0.5)),
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &impatient());
    app.until(|app| app.scenario.count("eye iterate") > 1);
    ready.store(true, Ordering::SeqCst);
    let eye = app.index("eye");
    app.until(|app| app.schema("eye").health != Health::Ok);
    // The event is reported after the health has changed, on another thread.
    app.until(|app| app.scenario.has_event(|event| hung(event, eye)));
    // The others go on, and everything is refused.
    let before = (scenario.count("robot iterate"), scenario.count("high iterate"));
    app.until(|app| {
        app.scenario.count("robot iterate") > before.0 + 5
            && app.scenario.count("high iterate") > before.1 + 1
    });
    assert_eq!(app.schema("high").faults, 0);
    assert!(!scenario.has_line("robot velocity 0.5"));
    // An operator starts it again.
    *limit.lock() = Some(1.0);
    app.operator().load(eye).expect("it is loaded");
    app.until_line("robot velocity 0.5");
    assert_eq!(app.schema("high").faults, 0);
    app.stop();
}

fn r18_a_hung_judgement_of_a_command_in_force_is_a_hang_of_the_guard(executor: Executor) {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, Some(1.0));
    commands_once(&scenario, 0.5);
    let mut app = TestApp::start(executor, &scenario, &impatient());
    app.until_line("robot velocity 0.5");
    *limit.lock() = Some(-2.0);
    app.until_line("robot velocity 0");
    let eye = app.index("eye");
    app.until(|app| app.scenario.has_event(|event| hung(event, eye)));
    let before = scenario.count("robot iterate");
    app.until(|app| app.scenario.count("robot iterate") > before + 5);
    assert_eq!((app.schema("high").faults, app.schema("robot").faults), (0, 0));
    app.stop();
}
