//! Calls that hang at the end: of an instance, or of the application.

use std::sync::Arc;

use jde_core::Health;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::{Event, Occurrence, Outcome, What};
use parking_lot::Mutex;

use super::hangs::{PAIR, blocker, hung};
use crate::common::{Call, Executor, Scenario, TEST, TestApp, in_real_time};

in_real_time!(
    an_instance_that_hangs_in_drop_is_abandoned_and_its_successor_wins,
    the_application_ends_although_a_call_never_returns,
    the_application_ends_although_an_instance_never_ends,
    a_pending_reload_is_resolved_when_the_application_ends,
);

fn an_instance_that_hangs_in_drop_is_abandoned_and_its_successor_wins(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let mut hang = Some(hang);
    let mut failed = false;
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate if !failed => {
                failed = true;
                return Err("a fault".into());
            }
            Call::Iterate => {
                io.command(0.2);
            }
            Call::Drop => {
                if let Some(hang) = hang.take() {
                    io.then(move |_| hang());
                }
            }
            _ => {}
        }
        Ok(())
    });
    let body = PAIR.replace("limit = 5 }", "limit = 5 }\nhang = \"250ms\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    let low = app.index("low");
    app.until_line("robot velocity 0.2");
    assert!(scenario.has_event(
        |event| matches!(event.what(), Some(What::CallAbandoned { schema, abandoned: 1, .. }) if *schema == low)
    ));
    app.until(|app| app.schema("low").health == Health::Ok);
    assert_eq!(app.schema("low").left, 1);
    release.send(()).expect("the call hangs");
    app.until(|app| app.schema("low").left == 0);
    app.stop();
    assert_eq!(scenario.count("low drop"), 2);
}

fn the_application_ends_although_a_call_never_returns(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let ready = Arc::new(true.into());
    scenario.drives("high", &ready, 0.3);
    let hang = Mutex::new(Some(hang));
    scenario.on_call("low", move |call, io| {
        if call == Call::Check {
            io.record("check");
            if let Some(hang) = hang.lock().take() {
                hang();
                io.record("returned");
            }
        }
        Ok(())
    });
    // With this budget a call would count as hung only after 1000 s.
    let body = PAIR.replace("restart = { back-off = \"5ms\", limit = 5 }", "budget = \"100s\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.3");
    app.until_line("low check");
    let low = app.index("low");
    assert_eq!(app.stop(), Outcome::Stopped);
    assert!(
        scenario.has_event(|event| hung(event, low)),
        "the instance that did not end is reported"
    );
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
    let lines = scenario.lines();
    for ended in [
        "high sleep",
        "robot sleep",
        "high drop",
        "robot drop",
        "robot velocity 0",
    ] {
        assert!(lines.iter().any(|line| line == ended), "{ended}");
    }
    assert!(
        !scenario.has_line("low drop"),
        "an instance whose call runs is not dropped"
    );
    drop(release);
    scenario.wait_until(|| scenario.has_line("low returned"));
}

fn the_application_ends_although_an_instance_never_ends(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    let mut hang = Some(hang);
    scenario.on_call("low", move |call, io| {
        if call == Call::Drop
            && let Some(hang) = hang.take()
        {
            io.then(move |_| hang());
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    let low = app.index("low");
    assert_eq!(app.stop(), Outcome::Stopped);
    assert!(
        scenario.has_event(|event| hung(event, low)),
        "the instance that did not end is reported"
    );
    for ended in ["high drop", "robot drop", "robot velocity 0"] {
        assert!(scenario.has_line(ended), "{ended}");
    }
    drop(release);
}

fn a_pending_reload_is_resolved_when_the_application_ends(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let hang = Mutex::new(Some(hang));
    scenario.on_call("low", move |call, io| {
        if call == Call::Check {
            io.record("check");
            if let Some(hang) = hang.lock().take() {
                hang();
            }
        }
        Ok(())
    });
    let body = PAIR.replace("restart = { back-off = \"5ms\", limit = 5 }", "budget = \"100s\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("low check");
    let low = app.index("low");
    let build = LoadedPlugin::linked_in(&TEST).expect("its tables are valid");
    let operator = app.operator();
    let reload = operator
        .replace(low, &build, ReloadOptions::default())
        .expect("it fits");
    assert_eq!(reload.outcome(), None, "the schema is inside a call");
    app.stop();
    let error = reload
        .outcome()
        .expect("it is resolved")
        .expect_err("it had no turn");
    assert_eq!(error, "the application has ended");
    let late = operator.replace(low, &build, ReloadOptions::default());
    assert_eq!(late.err(), Some(vec![error]));
    drop(release);
}
