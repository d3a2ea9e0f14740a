//! Builds that fail: before they take over, on trial, and after the trial. The previous build continues without
//! a selection, or the level selects again as for any fault.

use jde_core::Health;
use jde_host::reload::ReloadOptions;
use jde_records::event::What;

use super::counter::build;
use super::{level_events, reload, rollback_reasons, start};
use crate::common::{Executor, TestApp, in_real_time, on_every_executor};

on_every_executor!(
    a_build_that_cannot_take_over_leaves_the_previous_build_running,
    a_failure_on_trial_restores_the_previous_build_without_a_fault,
    a_fault_after_the_trial_is_a_fault,
);

mod hanging {
    use super::*;

    in_real_time!(
        a_build_that_hangs_on_trial_is_abandoned_for_the_previous_build,
        a_build_that_hangs_while_it_takes_over_is_abandoned_for_the_previous_build,
        a_hang_after_the_trial_restarts_the_current_build,
        a_pending_build_takes_over_after_a_call_that_hangs,
    );
}

fn a_build_that_cannot_take_over_leaves_the_previous_build_running(executor: Executor) {
    let mut app = start(executor);
    let before = app.scenario.events().len();
    for (number, reason) in [
        (4, "it refuses what was remembered: the saved memory is invalid"),
        (5, "it cannot be made: panicked"),
        (7, "it cannot awake"),
    ] {
        let refused = reload(&mut app, number, ReloadOptions::default()).expect_err("it cannot");
        assert!(refused.starts_with(reason), "{refused}");
        let lines = app.scenario.lines().len();
        app.until(|app| {
            app.scenario.lines()[lines..]
                .iter()
                .any(|line| line.starts_with("counter 1 step"))
        });
        assert_eq!(rollback_reasons(&app).last(), Some(&refused));
        let view = app.schema("counter").reload.expect("it was tried");
        assert_eq!(
            (view.reloads, view.on_trial, view.undone),
            (0, false, Some(refused))
        );
    }
    assert_eq!(
        level_events(&app, before).len(),
        0,
        "{:#?}",
        level_events(&app, before)
    );
    assert!(
        !app.scenario.has_line("robot velocity 0"),
        "the robot never stopped"
    );
    let steps = app.scenario.lines();
    let mut steps: Vec<u32> = steps
        .iter()
        .filter_map(|line| line.strip_prefix("counter 1 step ")?.parse().ok())
        .collect();
    let count = steps.len();
    steps.dedup();
    assert_eq!(
        steps,
        (1..=count as u32).collect::<Vec<_>>(),
        "the count continues"
    );
    app.stop();
}

fn a_failure_on_trial_restores_the_previous_build_without_a_fault(executor: Executor) {
    for number in [3, 6] {
        let mut app = start(executor);
        let before = app.scenario.events().len();
        // A failure in the build's first turn is reported as the result of the reload.
        let outcome = reload(&mut app, number, ReloadOptions::default());
        assert_eq!(outcome.is_ok(), number == 3, "{outcome:?}");
        app.until(|app| !rollback_reasons(app).is_empty());
        let lines = app.scenario.lines().len();
        app.until(|app| {
            app.scenario.lines()[lines..]
                .iter()
                .any(|line| line.starts_with("counter 1 step"))
        });
        assert_eq!(
            level_events(&app, before).len(),
            0,
            "{:#?}",
            level_events(&app, before)
        );
        assert!(
            !app.scenario.has_line("robot velocity 0"),
            "the robot never stopped"
        );
        assert_eq!(app.schema("counter").faults, 0);
        let view = app.schema("counter").reload.expect("it was tried");
        assert!(!view.on_trial && view.undone.is_some(), "{view:?}");
        assert!(app.scenario.has_line(&format!("counter {number} drop")));
        assert!(app.scenario.first("counter 1 sleep") < app.scenario.last("counter 1 awake"));
        app.stop();
    }
}

fn a_fault_after_the_trial_is_a_fault(executor: Executor) {
    let mut app = start(executor);
    let options = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    let takeover = reload(&mut app, 3, options).expect("it fits");
    assert_eq!(takeover.probation, 0);
    app.until_line("counter 1 drop");
    let counter = app.index("counter");
    app.until(|app| {
        app.scenario.has_event(|event| {
            matches!(event.what(), Some(What::HealthChanged { schema, health: Health::Faulted(reason), .. })
                if *schema == counter && reason == "its third step is wrong")
        })
    });
    assert_eq!(rollback_reasons(&app), [""; 0]);
    // A restart uses the build in force.
    app.until(|app| app.scenario.count("counter 3 awake") > 1);
    app.stop();
}

/// Runs until an instance of this build that awoke after the first `since` lines takes a step.
fn until_steps(app: &mut TestApp, build: u32, since: usize) {
    app.until(|app| {
        let lines = app.scenario.lines().split_off(since);
        let awake = lines
            .iter()
            .position(|line| *line == format!("counter {build} awake"));
        awake.is_some_and(|awake| {
            let step = format!("counter {build} step");
            lines[awake..].iter().any(|line| line.starts_with(&step))
        })
    });
}

/// Releases the call that hangs, and waits for the end of its instance.
fn release_hang(app: &mut TestApp, build: u32) {
    assert_eq!(app.schema("counter").left, 1);
    assert!(!app.scenario.has_line(&format!("counter {build} drop")));
    app.scenario.record(|| "release".to_owned());
    app.until(|app| app.schema("counter").left == 0);
    app.until_line(&format!("counter {build} drop"));
}

fn a_build_that_hangs_on_trial_is_abandoned_for_the_previous_build(executor: Executor) {
    let mut app = start(executor);
    reload(&mut app, 8, ReloadOptions::default()).expect("it fits");
    app.until_line("counter 8 hangs");
    let counter = app.index("counter");
    let since = app.scenario.lines().len();
    until_steps(&mut app, 1, since);
    // The level selected again, as after any fault.
    assert!(app.scenario.has_event(|event| {
        matches!(event.what(), Some(What::HealthChanged { schema, health: Health::Faulted(_), .. }) if *schema == counter)
    }));
    let reason = rollback_reasons(&app).pop().expect("it was undone");
    assert!(
        reason.starts_with("has not returned from a call for "),
        "{reason}"
    );
    let view = app.schema("counter").reload.expect("it was reloaded");
    assert!(!view.on_trial && view.undone.is_some(), "{view:?}");
    assert!(
        !app.scenario.has_line("counter 1 drop"),
        "the kept instance ends with the call"
    );
    release_hang(&mut app, 8);
    app.until_line("counter 1 drop");
    // Another build may take over now.
    reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    app.until_line("counter 2 awake");
    app.stop();
}

fn a_build_that_hangs_while_it_takes_over_is_abandoned_for_the_previous_build(executor: Executor) {
    for number in [15, 16] {
        let mut app = start(executor);
        let since = app.scenario.lines().len();
        let refused = reload(&mut app, number, ReloadOptions::default()).expect_err("it never has a turn");
        assert!(
            refused.starts_with("has not returned from a call for "),
            "{refused}"
        );
        assert!(app.scenario.has_line(&format!("counter {number} hangs")));
        until_steps(&mut app, 1, since);
        assert_eq!(rollback_reasons(&app), [refused]);
        assert_eq!(app.schema("counter").faults, 1);
        release_hang(&mut app, number);
        reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
        app.until_line("counter 2 awake");
        app.stop();
    }
}

fn a_hang_after_the_trial_restarts_the_current_build(executor: Executor) {
    let mut app = start(executor);
    let options = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut app, 8, options).expect("it fits");
    app.until_line("counter 8 hangs");
    let since = app.scenario.lines().len();
    until_steps(&mut app, 8, since);
    assert_eq!(rollback_reasons(&app), [""; 0]);
    app.scenario.record(|| "release".to_owned());
    app.stop();
}

fn a_pending_build_takes_over_after_a_call_that_hangs(executor: Executor) {
    let mut app = start(executor);
    let options = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut app, 17, options).expect("it fits");
    app.until_line("counter 17 waits");
    // The stop and the reload wait for the end of the iteration. The schema goes to sleep first and hangs there.
    let counter = app.index("counter");
    let operator = app.operator();
    operator.hold_asleep(counter).expect("it can be stopped");
    let pending = operator.replace(counter, &build(2), options).expect("it fits");
    app.scenario.record(|| "go".to_owned());
    app.until_line("counter 17 hangs");
    app.until_reloaded(&pending)
        .expect("the next turn performs the reload");
    operator.release(counter).expect("it was stopped");
    app.until_line("counter 2 step 1");
    // Another build may take over now.
    reload(&mut app, 1, options).expect("it fits");
    app.scenario.record(|| "release".to_owned());
    app.stop();
}
