//! Stopping everything by an operator, and releasing it (R14).

use std::sync::{Arc, OnceLock, mpsc};
use std::time::Duration;

use jde_core::State;
use jde_host::transaction_observer::{ObservedTransaction, TransactionObserver};
use jde_host::{Handle, Options};
use jde_records::snapshot::HoldKind;
use jde_types::Twist;
use parking_lot::Mutex;

use crate::common::{Call, Executor, Scenario, TestApp, in_real_time, on_every_executor};

on_every_executor!(
    r14_what_is_stopped_before_the_start_waits_until_everything_is_released,
    r14_stop_all_stops_everything_at_once_without_a_takeover,
    r14_the_end_of_a_lease_does_not_resume_what_stop_all_stopped,
    r14_release_all_keeps_individual_stops_and_unloads,
);

mod hanging {
    use super::*;

    in_real_time!(
        r14_after_stop_all_a_running_iteration_commands_nothing_more,
        r14_after_release_all_a_running_schema_commands_again_from_its_next_iteration,
        r14_releasing_another_schema_gives_a_stopped_one_no_authority,
        r14_concurrent_stops_and_releases_keep_the_board_in_agreement_with_the_rules,
    );
}

const ONE: &str = r#"
    roots = ["high"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn r14_the_end_of_a_lease_does_not_resume_what_stop_all_stopped(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    let mut app = TestApp::start(executor, &scenario, ONE);
    app.until_line("robot velocity 0.3");
    let high = app.index("high");
    let operator = app.operator();
    operator.force(high).expect("it is awake");
    operator.stop_all().expect("the operator may");
    // The end of a lease does the same as `release_own`.
    operator.release_own(high).expect("the operator may");
    app.until_line("robot sleep");
    let hold = app.schema("high").operator.map(|hold| hold.kind);
    assert_eq!(
        (app.schema("high").state, hold),
        (State::Slept, Some(HoldKind::Stopped))
    );
    // The end of the lease of an individual stop does not resume it either.
    operator.hold_asleep(high).expect("the operator may");
    operator.release_own(high).expect("the operator may");
    assert_eq!(app.schema("high").state, State::Slept);
    let before = scenario.count("high iterate");
    operator.release_all().expect("the operator may");
    app.until(|app| app.scenario.count("high iterate") > before);
    app.stop();
}

fn r14_release_all_keeps_individual_stops_and_unloads(executor: Executor) {
    let scenario = Scenario::new();
    let body = r#"
        roots = ["before", "since", "gone", "free"]
        [schemas.before]
        type = "test/motor"
        [schemas.since]
        type = "test/motor"
        [schemas.gone]
        type = "test/motor"
        [schemas.free]
        type = "test/motor"
    "#;
    scenario.drives("free", &Arc::new(true.into()), 0.0);
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("free iterate");
    // An instance that was never created is not dropped.
    app.until_line("gone awake");
    let [before, since, gone] = ["before", "since", "gone"].map(|name| app.index(name));
    let (ana, ben) = (app.operator(), app.handle.operator("ben@base"));
    ana.hold_asleep(before).expect("the operator may");
    ana.unload(gone).expect("no schema needs it");
    app.until_line("gone drop");
    ben.stop_all().expect("the operator may");
    ana.hold_asleep(since).expect("the operator may");
    app.until_line("free sleep");
    let holds = |app: &TestApp| {
        ["before", "since", "gone", "free"].map(|name| {
            let hold = app.schema(name).operator;
            hold.map(|hold| (hold.kind, hold.by, hold.with_everything))
        })
    };
    let stopped =
        |operator: &str, with_everything| Some((HoldKind::Stopped, operator.to_owned(), with_everything));
    let unloaded = Some((HoldKind::Unloaded, "ana@laptop".to_owned(), true));
    let all = stopped("ben@base", true);
    assert_eq!(holds(&app), [all.clone(), all.clone(), unloaded, all]);

    let iterated = scenario.count("free iterate");
    ben.release_all().expect("the operator may");
    app.until(|app| app.scenario.count("free iterate") > iterated);
    let unloaded = Some((HoldKind::Unloaded, "ana@laptop".to_owned(), false));
    let by_ana = stopped("ana@laptop", false);
    assert_eq!(holds(&app), [by_ana.clone(), by_ana, unloaded, None]);
    for name in ["before", "since", "gone"] {
        assert_eq!(app.schema(name).state, State::Slept, "{name}");
    }

    // A schema that is loaded while everything is stopped stays stopped until everything is released.
    ben.stop_all().expect("the operator may");
    app.until_line("free sleep");
    ana.load(gone).expect("it was unloaded");
    ana.release_own(before).expect("it was stopped");
    assert_eq!(
        ["before", "gone"].map(|name| app.schema(name).state),
        [State::Slept; 2]
    );
    ben.release_all().expect("the operator may");
    for name in ["before", "gone"] {
        assert_ne!(app.schema(name).state, State::Slept, "{name}");
    }
    app.stop();
}

fn r14_what_is_stopped_before_the_start_waits_until_everything_is_released(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    let options = Options {
        start_hook: Some(Box::new(|handle| Ok(handle.operator("ana@laptop").stop_all()?))),
        ..Options::default()
    };
    let mut app = TestApp::start_with(executor, &scenario, ONE, options);
    let hold = app.schema("high").operator.expect("it is held");
    assert_eq!((hold.by.as_str(), hold.with_everything), ("ana@laptop", true));
    let states = ["high", "robot"].map(|name| app.schema(name).state);
    assert_eq!(states, [State::Slept; 2]);
    app.operator().release_all().expect("the operator may");
    app.until_line("robot velocity 0.3");
    app.stop();
}

fn r14_stop_all_stops_everything_at_once_without_a_takeover(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    scenario.drives("father", &Arc::new(true.into()), 0.2);
    // The group would hold the last command (R9).
    let body = r#"
        roots = ["high", "father"]
        root = { absence = "hold", hold = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        [schemas.father]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.3");
    let father = scenario.count("father iterate");
    app.operator().stop_all().expect("the operator may");
    app.until(|app| app.winner("roots").is_none());
    assert_eq!(velocity(&app), Some(Twist::ZERO));
    app.until_line("robot sleep");
    for root in ["high", "father"] {
        let view = app.schema(root);
        let hold = view.operator.expect("it is held");
        assert_eq!(
            (view.state, hold.kind, hold.by.as_str()),
            (State::Slept, HoldKind::Stopped, "ana@laptop")
        );
    }
    assert_eq!(scenario.count("father iterate"), father, "no schema takes over");
    let before = scenario.count("high iterate");
    app.operator().release_all().expect("the operator may");
    app.until(|app| app.scenario.count("high iterate") > before);
    assert_eq!(app.schema("father").operator, None);
    app.stop();
}

/// A winner that stays inside its first iteration until the sender is dropped, and then commands once more.
/// The patience is so long that the call does not count as hung and R1 does not withdraw the authority.
fn start_blocked(executor: Executor) -> (TestApp, mpsc::Sender<()>) {
    let scenario = Scenario::new();
    let (release, held) = mpsc::channel::<()>();
    scenario.on_call("high", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                // An error means that the sender was dropped.
                let _ = held.recv();
                let outcome = io.command(0.4);
                io.record(format!("then {outcome:?}"));
            }
            _ => {}
        }
        Ok(())
    });
    // By R9 the last command would be in force for 1000 s.
    let body = r#"
        roots = ["high", "low"]
        root = { absence = "hold", hold = "1000s", patience = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        budget = "1000s"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.3");
    (app, release)
}

fn velocity(app: &TestApp) -> Option<Twist> {
    app.handle.value("robot.velocity").expect("it is a command")
}

fn r14_after_stop_all_a_running_iteration_commands_nothing_more(executor: Executor) {
    let (mut app, release) = start_blocked(executor);
    app.operator().stop_all().expect("the operator may");
    assert_eq!(velocity(&app), Some(Twist::ZERO));
    drop(release);
    app.until_line("high then Refused");
    app.until_line("high sleep");
    app.until_line("robot sleep");
    assert_eq!(velocity(&app), Some(Twist::ZERO));
    assert_eq!(app.winner("roots"), None);
    app.stop();
}

fn r14_after_release_all_a_running_schema_commands_again_from_its_next_iteration(executor: Executor) {
    let (mut app, release) = start_blocked(executor);
    app.operator().stop_all().expect("the operator may");
    app.operator().release_all().expect("the operator may");
    drop(release);
    app.until_line("high then Refused");
    app.until_line("high then Accepted");
    assert!(app.scenario.first("high then Refused") < app.scenario.first("high then Accepted"));
    app.until_line("robot velocity 0.4");
    app.stop();
}

fn r14_releasing_another_schema_gives_a_stopped_one_no_authority(executor: Executor) {
    let (mut app, release) = start_blocked(executor);
    app.operator().stop_all().expect("the operator may");
    let low = app.index("low");
    app.operator().release(low).expect("it was stopped");
    drop(release);
    app.until_line("high then Refused");
    app.until_line("high sleep");
    assert_eq!(velocity(&app), Some(Twist::ZERO));
    app.stop();
}

/// Compares the authority by the rules with the authority on the board after each transaction.
struct Agreement {
    handle: Arc<OnceLock<Handle>>,
    violation: Arc<Mutex<Option<String>>>,
}

impl TransactionObserver for Agreement {
    fn on_transaction(&mut self, transaction: &ObservedTransaction<'_>) {
        let Some(handle) = self.handle.get() else { return };
        let command = handle.board().get("robot.velocity").expect("a command");
        for name in ["high", "low"] {
            let id = handle.application().instance(name).expect("the instance exists");
            let rules = transaction.hierarchy.has_authority(id);
            if rules != command.has_grant(id.0) {
                let violation = format!(
                    "{name}: authority by the rules {rules}, on the board {}, after {:?}",
                    !rules, transaction.effects
                );
                self.violation.lock().get_or_insert(violation);
            }
        }
    }
}

fn r14_concurrent_stops_and_releases_keep_the_board_in_agreement_with_the_rules(executor: Executor) {
    /// Actions of each operator: enough that they interleave in every way.
    const ACTIONS: usize = 300;
    let scenario = Scenario::quiet();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    scenario.drives("low", &Arc::new(true.into()), 0.2);
    let (handle, violation) = (Arc::new(OnceLock::new()), Arc::new(Mutex::new(None)));
    let options = Options {
        transaction_observer: Some(Box::new(Agreement {
            handle: Arc::clone(&handle),
            violation: Arc::clone(&violation),
        })),
        ..Options::default()
    };
    let body = r#"
        roots = ["high", "low"]
        root = { absence = "hold", hold = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        period = "1ms"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        period = "1ms"
        actuators = { base = "robot.velocity" }
    "#;
    let app = TestApp::start_with(executor, &scenario, body, options);
    assert!(handle.set(app.handle.clone()).is_ok());
    let [high, low] = ["high", "low"].map(|name| app.index(name));
    std::thread::scope(|scope| {
        for action in 0..4 {
            let operator = app.handle.operator(&format!("operator {action}"));
            scope.spawn(move || {
                for _ in 0..ACTIONS {
                    let result = match action {
                        0 => operator.stop_all(),
                        1 => operator.release_all(),
                        2 => operator.play(high),
                        _ => operator.release(low),
                    };
                    result.expect("the operator may");
                }
            });
        }
    });
    assert_eq!(*violation.lock(), None);
    // Whatever the last action was, the application can be released and then commands.
    app.operator().release_all().expect("the operator may");
    let command = app.handle.board().get("robot.velocity").expect("a command");
    while app.winner("roots").as_deref() != Some("high") || command.status(0).last_writer != Some(high.0) {
        command.wait_newer(command.newest(), Duration::from_millis(10));
    }
    assert_eq!(*violation.lock(), None);
    app.stop();
}
