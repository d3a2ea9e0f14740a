//! Failures that appear only in real time: a process that dies between calls, and a call that does not
//! return.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_records::event::{Event, Outcome, What};

use crate::common::{Executor, Scenario, TestApp, in_real_time};
use crate::crashes::{PAIR, scenario, with_restarts};
use crate::faulty;
use crate::isolated_app::IsolatedApp;

in_real_time!(
    the_death_of_a_process_between_calls_is_detected_at_once,
    a_process_that_hangs_is_killed_and_no_thread_is_lost,
    r7_a_process_that_loses_authority_in_a_call_is_refused_in_that_call,
);

fn the_death_of_a_process_between_calls_is_detected_at_once(executor: Executor) {
    let scenario = scenario();
    let body = PAIR.replace("restart = \"never\"", "restart = \"never\"\nperiod = \"1000s\"");
    let mut isolated = IsolatedApp::start(executor, &scenario, &body);
    isolated.until_at(0.3);
    // The period of 1000 s leaves the process without calls after the first iteration.
    isolated.app.until(|app| app.schema("high").iterations == 1);
    let killed = std::process::Command::new("kill")
        .args(["-9", &isolated.process().to_string()])
        .status()
        .expect("kill runs");
    assert!(killed.success());
    let reason = isolated.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGKILL"),
        "{reason}"
    );
    isolated.until_at(0.1);
    assert_eq!(isolated.app.schema("high").faults, 1);
    isolated.app.stop();
}

fn r7_a_process_that_loses_authority_in_a_call_is_refused_in_that_call(executor: Executor) {
    let scenario = Scenario::new();
    let is_ready = Arc::new(AtomicBool::new(false));
    scenario.drives("low", &is_ready, 0.1);
    let body = PAIR.replace(r#"["high", "low"]"#, r#"["low", "high"]"#);
    let mut isolated = IsolatedApp::start(executor, &scenario, &body);
    isolated.until_at(0.3);
    isolated.trouble(faulty::COMMAND);
    // The iteration goes on for as long as its commands are accepted.
    let tried = |app: &TestApp, value| {
        app.handle
            .value::<f64>("high.tried")
            .is_ok_and(|tried| tried == Some(value))
    };
    isolated.app.until(|app| tried(app, 1.0));
    is_ready.store(true, Ordering::Relaxed);
    isolated.app.until(|app| tried(app, -1.0));
    isolated.until_at(0.1);
    let view = isolated.app.schema("high");
    assert_eq!(view.faults, 0);
    assert!(view.refused > 0, "the refusal is counted");
    isolated.app.stop();
}

fn a_process_that_hangs_is_killed_and_no_thread_is_lost(executor: Executor) {
    let scenario = scenario();
    let mut isolated = IsolatedApp::start(executor, &scenario, &with_restarts(PAIR));
    isolated.until_at(0.3);
    let first = isolated.process();
    isolated.trouble(faulty::HANG);
    let reason = isolated.until_failed(1);
    assert!(
        reason.starts_with("has not returned from a call for "),
        "{reason}"
    );
    isolated.trouble(0);
    let before = isolated.app.schema("high").iterations;
    isolated
        .app
        .until(|app| app.schema("high").iterations > before + 1);
    isolated.until_at(0.3);
    assert_ne!(isolated.process(), first);
    let failed = isolated.app.schema("high").faults as usize;
    assert_eq!(isolated.app.stop(), Outcome::Stopped);
    // An instance that is abandoned at the end would cause one more `Hung` event.
    let hung = |event: &Event| matches!(event.what(), Some(What::Hung { .. }));
    assert_eq!(scenario.count_events(hung), failed, "no instance is abandoned");
}
