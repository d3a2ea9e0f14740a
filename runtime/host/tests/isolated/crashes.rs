//! The end of a schema's process, for any reason: its level selects again, all other schemas continue, and a
//! new process has all its bindings.

use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;

use jde_core::{Health, State};
use jde_isolation::launch::receive_files;
use jde_isolation::messages::{Done, FromChild, Function, ToChild};
use jde_isolation::wire::Wire;
use jde_records::event::{Outcome, What};

use crate::common::{Executor, Scenario, on_every_executor};
use crate::faulty;
use crate::isolated_app::IsolatedApp;

on_every_executor!(
    a_schema_whose_process_dies_is_faulted_and_its_sibling_takes_over,
    a_restarted_schema_has_a_fresh_process_and_finds_its_bindings,
    a_panic_is_caught_and_leaves_no_process_behind,
    what_a_call_published_before_its_process_died_took_effect,
    a_process_that_reads_what_it_was_not_sent_is_ended,
    an_import_cannot_be_overwritten,
);

/// `high` wins while it is ready; otherwise `low` wins.
pub(crate) const PAIR: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "faulty/faulty"
    isolate = "process"
    restart = "never"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// A scenario in which `low` drives at 0.1.
pub(crate) fn scenario() -> Arc<Scenario> {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario
}

/// The same application, with `high` restarted after 5 ms instead of never.
pub(crate) fn with_restarts(text: &str) -> String {
    text.replace("\"never\"", "{ back-off = \"5ms\", limit = 100 }")
}

fn a_schema_whose_process_dies_is_faulted_and_its_sibling_takes_over(executor: Executor) {
    let troubles = [
        (faulty::SEGFAULT, "its process was killed by SIGSEGV"),
        (faulty::ABORT, "its process was killed by SIGABRT"),
        (faulty::EXIT, "its process exited by itself, with status 3"),
    ];
    for (trouble, expected) in troubles {
        let scenario = scenario();
        let mut isolated = IsolatedApp::start(executor, &scenario, PAIR);
        isolated.until_at(0.3);
        assert_ne!(isolated.process(), std::process::id());
        isolated.trouble(trouble);
        let reason = isolated.until_failed(1);
        assert!(reason.starts_with(expected), "{reason}");
        isolated.until_at(0.1);
        let view = isolated.app.schema("high");
        assert_eq!((view.state, view.faults), (State::Slept, 1));
        let before = scenario.count("low iterate");
        isolated.app.until(|app| {
            app.scenario.count("low iterate") > before + 5 && app.schema("high").process.is_none()
        });
        assert_eq!(
            isolated.app.schema("low").faults + isolated.app.schema("robot").faults,
            0
        );
        assert_eq!(isolated.app.stop(), Outcome::Stopped);
    }
}

fn a_restarted_schema_has_a_fresh_process_and_finds_its_bindings(executor: Executor) {
    let scenario = scenario();
    let mut isolated = IsolatedApp::start(executor, &scenario, &with_restarts(PAIR));
    isolated.until_at(0.3);
    let first = isolated.process();
    isolated.trouble(faulty::SEGFAULT);
    isolated.until_failed(2);
    isolated.trouble(0);
    let (high, failed) = (isolated.app.index("high"), isolated.app.schema("high").faults);
    let before = isolated.app.schema("high").iterations;
    isolated
        .app
        .until(|app| app.schema("high").iterations > before + 1);
    isolated.until_at(0.3);
    assert_ne!(isolated.process(), first);
    let reported = scenario.count_events(
        |event| matches!(event.what(), Some(What::HealthChanged { schema, health: Health::Faulted(_), .. }) if *schema == high),
    );
    let faults = isolated.app.schema("high").faults;
    assert!(
        failed <= faults && faults as usize == reported,
        "each death is reported once"
    );
    isolated.app.stop();
}

fn a_panic_is_caught_and_leaves_no_process_behind(executor: Executor) {
    let scenario = scenario();
    let mut isolated = IsolatedApp::start(executor, &scenario, PAIR);
    isolated.until_at(0.3);
    isolated.trouble(faulty::PANIC);
    let reason = isolated.until_failed(1);
    assert!(
        reason.starts_with("panicked in iterate: ") && reason.ends_with("the requested panic"),
        "{reason}"
    );
    isolated.until_at(0.1);
    let before = scenario.count("low iterate");
    isolated
        .app
        .until(|app| app.scenario.count("low iterate") > before && app.schema("high").process.is_none());
    isolated.app.stop();
}

fn what_a_call_published_before_its_process_died_took_effect(executor: Executor) {
    let mut isolated = IsolatedApp::start(executor, &scenario(), PAIR);
    isolated.until_at(0.3);
    isolated.trouble(faulty::SEGFAULT);
    isolated.until_failed(1);
    isolated.until_at(0.1);
    let count = isolated
        .app
        .handle
        .board()
        .find("high.count")
        .expect("it is exported");
    assert_eq!(count.newest(), isolated.app.schema("high").iterations);
    assert!(!count.has_value(isolated.app.handle.now()));
    isolated.app.stop();
}

/// A child that breaks the protocol: it claims to have read every input.
pub(crate) fn forge() -> std::io::Result<()> {
    let stream = UnixStream::from(std::io::stdin().as_fd().try_clone_to_owned()?);
    drop(receive_files(&stream)?);
    let mut wire = Wire::new(stream);
    loop {
        let claims = match wire.receive()? {
            ToChild::Call(call) => matches!(call.function, Function::Check),
            ToChild::Destroy => false,
            ToChild::Early { .. } | ToChild::EarlyLoan { .. } | ToChild::Reply(_) => continue,
        };
        wire.send(&FromChild::Done(Done {
            read_early: if claims { u64::MAX.into() } else { 0 },
            ..Done::default()
        }))?;
    }
}

fn a_process_that_reads_what_it_was_not_sent_is_ended(executor: Executor) {
    let mut isolated = IsolatedApp::start_forged(executor, &scenario(), PAIR);
    let reason = isolated.until_failed(1);
    assert_eq!(reason, "its process read an input that it was not sent");
    isolated.until_at(0.1);
    isolated.app.stop();
}

fn an_import_cannot_be_overwritten(executor: Executor) {
    let body = r#"
        roots = ["high", "source"]
        [schemas.source]
        type = "faulty/faulty"
        [schemas.high]
        type = "faulty/faulty"
        isolate = "process"
        restart = "never"
        imports = { scan = "source.seen" }
        speed = 0.3
    "#;
    let scenario = scenario();
    let mut isolated = IsolatedApp::start(executor, &scenario, body);
    // `high` sleeps until the source has iterated, so that a scan exists.
    let high = isolated.app.index("high");
    let operator = isolated.app.operator();
    operator.hold_asleep(high).expect("the operator may");
    isolated.app.until(|app| app.schema("source").iterations > 0);
    operator.release(high).expect("the operator may");
    isolated.app.until(|app| app.schema("high").iterations > 0);
    isolated.trouble(faulty::WRITE_IMPORT);
    let reason = isolated.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGSEGV"),
        "{reason}"
    );
    isolated.app.stop();
}
