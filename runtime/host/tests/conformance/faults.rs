//! Schemas that panic or fail in any of their calls. They affect no other schema. Their restart policy
//! decides what follows.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;

use jde_core::{Health, Id, State};
use jde_host::{Options, StartError};
use jde_records::event::{Event, Outcome, StateChange, What};
use parking_lot::Mutex;

use crate::common::{Call, Executor, LIVE, Language, Scenario, TestApp, in_languages, on_every_executor};

on_every_executor!(
    a_schema_that_cannot_be_created_prevents_the_start,
    a_panic_while_waking_is_a_fault,
    a_panic_in_a_check_is_a_fault,
    a_panic_in_an_iteration_is_a_fault,
    a_panic_while_going_to_sleep_is_a_fault,
    a_panic_in_drop_affects_no_other_schema,
    an_error_is_a_fault_with_the_text_of_the_error,
    a_faulted_winner_is_replaced_at_once_and_its_commands_end,
    a_restart_makes_a_fresh_instance,
    restarts_end_at_their_limit,
    restarts_before_the_window_do_not_count,
    a_schema_without_restarts_left_returns_when_it_is_played_or_loaded,
    r15_a_fault_without_a_successor_is_a_switch,
    a_schema_that_never_restarts_stays_faulted,
    a_driver_that_cannot_start_ends_the_application,
    a_driver_that_worked_before_is_restarted,
    a_perceptive_schema_that_faults_is_restarted,
    exports_of_a_faulted_schema_are_retracted,
    values_that_a_faulted_schema_publishes_in_sleep_are_discarded,
);

in_languages!(Lockstep, [C Cpp Python]:
    a_panic_while_waking_is_a_fault,
    a_panic_in_a_check_is_a_fault,
    a_panic_in_an_iteration_is_a_fault,
    a_panic_while_going_to_sleep_is_a_fault,
    an_error_is_a_fault_with_the_text_of_the_error,
    a_restart_makes_a_fresh_instance,
    a_driver_that_cannot_start_ends_the_application,
    a_driver_that_worked_before_is_restarted,
    a_perceptive_schema_that_faults_is_restarted,
);
// No function of a schema in Python ends it, and no count of instances crosses to its process.
in_languages!(Lockstep, [C Cpp]:
    a_schema_that_cannot_be_created_prevents_the_start,
    a_panic_in_drop_affects_no_other_schema,
    values_that_a_faulted_schema_publishes_in_sleep_are_discarded,
);

const PAIR: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    restart = { back-off = "5ms", limit = 3 }
    [schemas.high]
    type = "test/motor"
    restart = { back-off = "5ms", limit = 2 }
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// `high` is READY and fails by `fail` in one of its calls; `low` drives.
fn start(
    executor: Executor,
    when: Call,
    fail: impl Fn(u64) -> jde_schema::Result + Send + 'static,
) -> TestApp {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("high", move |call, io| {
        if call == Call::Check {
            io.ready(io.scenario.has_line("low iterate"));
        }
        if call == Call::Iterate {
            io.command(0.3);
        }
        if call == when { fail(io.memory) } else { Ok(()) }
    });
    TestApp::start(executor, &scenario, PAIR)
}

/// The reasons of the faults of an instance, in order.
fn faults(app: &TestApp, name: &str) -> Vec<String> {
    let index = app.index(name);
    let events = app.scenario.events().into_iter();
    let reasons = events.filter_map(|event| match event.what()? {
        What::HealthChanged {
            schema,
            health: Health::Faulted(reason),
        } if *schema == index => Some(reason.clone()),
        _ => None,
    });
    reasons.collect()
}

/// Whether the instance has failed once, by an error with this text.
fn has_error(app: &TestApp, name: &str, text: &str) -> bool {
    matches!(&faults(app, name)[..], [reason] if Language::of_test().is_error(reason, text))
}

/// Runs until `high` has faulted for such reasons and `low` drives instead.
fn replaced(app: &mut TestApp, is_reason: impl Fn(&str) -> bool) {
    app.until(|app| !faults(app, "high").is_empty());
    let reasons = faults(app, "high");
    assert!(reasons.iter().all(|reason| is_reason(reason)), "{reasons:?}");
    app.until_line("robot velocity 0.1");
    assert!(app.schema("high").faults > 0);
    assert_eq!((app.schema("low").faults, app.schema("robot").faults), (0, 0));
}

fn a_schema_that_cannot_be_created_prevents_the_start(executor: Executor) {
    let scenario = Scenario::new();
    let body = r#"
        roots = ["first", "second"]
        [schemas.first]
        type = "test/motor"
        [schemas.second]
        type = "test/fails-to-create"
        [schemas.third]
        type = "test/motor"
    "#;
    let body = body.replace("\"second\"]", "\"second\", \"third\"]");
    let before = LIVE.get();
    let refused = TestApp::try_start(executor, &scenario, &body, Options::default());
    let Err(error @ StartError::Create { .. }) = refused else {
        panic!("it started");
    };
    let message = error.to_string();
    assert!(message.starts_with("schema `second` (type `"), "{message}");
    assert!(message.contains("cannot be created: "), "{message}");
    assert!(message.contains("there is no such device"), "{message}");
    assert_eq!(LIVE.get(), before, "every instance that was created has ended");
    assert_eq!(scenario.lines(), [""; 0]);
}

fn a_panic_while_waking_is_a_fault(executor: Executor) {
    let mut app = start(executor, Call::Awake, |_| panic!("no sensor"));
    replaced(&mut app, |reason| {
        Language::of_test().is_panic(reason, "awake", "no sensor")
    });
    assert!(!app.scenario.has_line("high iterate"));
    app.stop();
}

fn a_panic_in_a_check_is_a_fault(executor: Executor) {
    let mut app = start(executor, Call::Check, |_| panic!("no value"));
    replaced(&mut app, |reason| {
        Language::of_test().is_panic(reason, "check", "no value")
    });
    assert!(!app.scenario.has_line("high iterate"));
    app.stop();
}

fn a_panic_in_an_iteration_is_a_fault(executor: Executor) {
    let mut app = start(executor, Call::Iterate, |_| panic!("no motor"));
    replaced(&mut app, |reason| {
        Language::of_test().is_panic(reason, "iterate", "no motor")
    });
    app.until(|app| faults(app, "high").len() == 3);
    app.stop();
}

fn a_panic_while_going_to_sleep_is_a_fault(executor: Executor) {
    let mut app = start(executor, Call::Sleep, |_| panic!("no release"));
    app.until_line("robot velocity 0.3");
    let high = app.index("high");
    app.operator().hold_asleep(high).expect("it can be stopped");
    replaced(&mut app, |reason| reason.contains("no release"));
    app.until(|app| app.scenario.count("high drop") == Language::of_test().ends(1));
    // A new instance takes its place.
    app.operator().release(high).expect("it can be released");
    let before = app.scenario.count("high iterate");
    app.until(|app| app.scenario.count("high iterate") > before);
    assert_eq!(app.stop(), Outcome::Stopped);
}

fn a_panic_in_drop_affects_no_other_schema(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate => Err("a fault".into()),
        Call::Drop => panic!("a panic in drop"),
        _ => Ok(()),
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until(|app| faults(app, "high").len() == 3);
    app.until_line("robot velocity 0.1");
    assert_eq!(app.stop(), Outcome::Stopped);
    assert_eq!(scenario.count("high drop"), 3);
}

fn an_error_is_a_fault_with_the_text_of_the_error(executor: Executor) {
    let mut app = start(executor, Call::Iterate, |_| Err("the battery is low".into()));
    replaced(&mut app, |reason| {
        Language::of_test().is_error(reason, "the battery is low")
    });
    app.stop();
}

fn a_faulted_winner_is_replaced_at_once_and_its_commands_end(executor: Executor) {
    let mut app = start(executor, Call::Iterate, |_| Err("it broke".into()));
    let scenario = Arc::clone(&app.scenario);
    app.until(|app| !faults(app, "high").is_empty());
    let [high, low] = ["high", "low"].map(|name| app.index(name));
    app.stop();
    let events = scenario.events();
    let position = |expected: &dyn Fn(&Event) -> bool| events.iter().position(expected).expect("it occurred");
    let fault = position(
        &|event| matches!(event.what(), Some(What::HealthChanged { schema, health: Health::Faulted(_), .. }) if *schema == high),
    );
    // The level has selected again within the same transaction: no event of `high` comes between.
    let asleep = position(
        &|event| matches!(event, Event::State(StateChange { schema, to: State::Slept, .. }) if *schema == high),
    );
    assert_eq!(asleep, fault + 1);
    let next = events[asleep..].iter().find_map(|event| match event {
        Event::Decision(record) => Some(record.clone()),
        _ => None,
    });
    let next = next.expect("a selection");
    assert_eq!(next.choice, Some(low), "{next:?}");
    assert!(matches!(next.cause, jde_core::Cause::Faulted(id) if id == high));
}

fn a_restart_makes_a_fresh_instance(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    let memories = Arc::new(Mutex::new(Vec::new()));
    let record = Arc::clone(&memories);
    let mut failures = 0;
    scenario.on_call("high", move |call, io| {
        match call {
            Call::Awake => record.lock().push(io.memory),
            Call::Check => io.ready(true),
            Call::Iterate if failures < 2 => {
                failures += 1;
                return Err("twice".into());
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until(|app| app.schema("high").health == Health::Ok && app.scenario.count("high iterate") > 5);
    assert_eq!(*memories.lock(), [0; 3]);
    assert_eq!(scenario.count("high drop"), Language::of_test().ends(2));
    app.stop();
}

fn restarts_end_at_their_limit(executor: Executor) {
    let mut app = start(executor, Call::Iterate, |_| Err("always".into()));
    // The first run, and two restarts.
    app.until(|app| app.schema("high").faults == 3);
    let before = app.scenario.count("low iterate");
    app.until(|app| app.scenario.count("low iterate") > before + 20);
    let view = app.schema("high");
    assert_eq!((view.state, view.faults), (State::Slept, 3));
    assert_eq!(view.health, Health::Faulted("always".into()));
    assert_eq!(app.scenario.count("high awake"), 3);
    app.stop();
}

fn restarts_before_the_window_do_not_count(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        // An instance fails after it has run for a while.
        Call::Iterate if io.memory > 40 => Err("again".into()),
        _ => Ok(()),
    });
    let body = PAIR.replace(
        "restart = { back-off = \"5ms\", limit = 2 }",
        "restart = { back-off = \"1ms\", limit = 1, within = \"50ms\" }",
    );
    let mut app = TestApp::start(executor, &scenario, &body);
    assert_eq!(app.schema("high").restarts_left, Some(1));
    app.until(|app| app.schema("high").faults == 5);
    app.stop();
}

fn a_schema_without_restarts_left_returns_when_it_is_played_or_loaded(executor: Executor) {
    let mut app = start(executor, Call::Iterate, |_| Err("always".into()));
    let high = app.index("high");
    for (round, remedy) in ["play", "load", "unload and load"].into_iter().enumerate() {
        app.until(|app| {
            let view = app.schema("high");
            view.faults == 3 * (round as u64 + 1) && matches!(view.health, Health::Faulted(_))
        });
        let view = app.schema("high");
        assert_eq!(
            (view.state, view.restarts_left),
            (State::Slept, Some(0)),
            "{remedy}"
        );
        let refused = app.operator().force(high).expect_err("it is faulted");
        assert!(
            refused.contains("when it is played, loaded or reloaded"),
            "{refused}"
        );
        match remedy {
            "play" => app.operator().play(high),
            "load" => app.operator().load(high),
            _ => app
                .operator()
                .unload(high)
                .and_then(|()| app.operator().load(high)),
        }
        .unwrap_or_else(|refused| panic!("{remedy}: {refused}"));
    }
    app.until(|app| app.schema("high").faults == 12);
    app.stop();
}

fn r15_a_fault_without_a_successor_is_a_switch(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate => Err("it broke".into()),
        _ => Ok(()),
    });
    let body = PAIR.replace(
        "restart = { back-off = \"5ms\", limit = 2 }",
        "restart = \"never\"",
    );
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| app.schema("high").faults == 1 && app.group("roots").switches == 2);
    let last = app.group("roots").last.expect("there was one");
    assert_eq!((last.from, last.to), (Some(app.index("high").index()), None));
    app.stop();
}

fn a_schema_that_never_restarts_stays_faulted(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("high", |call, _| {
        if call == Call::Check {
            Err("no".into())
        } else {
            Ok(())
        }
    });
    let body = PAIR.replace(
        "restart = { back-off = \"5ms\", limit = 2 }",
        "restart = \"never\"",
    );
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| app.scenario.count("low iterate") > 20);
    assert_eq!((scenario.count("high awake"), app.schema("high").faults), (1, 1));
    app.stop();
}

fn a_driver_that_cannot_start_ends_the_application(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("robot", |call, _| match call {
        Call::Awake => Err("no cable".into()),
        _ => Ok(()),
    });
    let app = TestApp::start(executor, &scenario, PAIR);
    let outcome = app.wait();
    let is_expected = matches!(&outcome, Outcome::Broken(reason)
        if reason.starts_with("driver `robot` could not start: ") && reason.contains("no cable"));
    assert!(is_expected, "{outcome:?}");
    assert!(scenario.has_event(
        |event| matches!(event.what(), Some(What::Ended { outcome: ended, .. }) if *ended == outcome)
    ));
}

fn a_driver_that_worked_before_is_restarted(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    let calls = AtomicUsize::new(0);
    scenario.on_call("robot", move |call, _| {
        if call == Call::Iterate && calls.fetch_add(1, SeqCst) == 3 {
            return Err("the cable fell out".into());
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until(|app| app.scenario.count("robot awake") == 2 && app.scenario.count("robot velocity 0.1") > 0);
    app.until(|app| app.schema("robot").health == Health::Ok && app.schema("robot").iterations > 6);
    assert!(has_error(&app, "robot", "the cable fell out"));
    assert_eq!(app.handle.outcome(), None);
    app.stop();
}

fn a_perceptive_schema_that_faults_is_restarted(executor: Executor) {
    let scenario = Scenario::new();
    let mut failed = false;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            if !std::mem::replace(&mut failed, true) {
                return Err("dust".into());
            }
            io.publish(1.0);
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            io.ready(io.input().is_some());
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        restart = { back-off = "5ms", limit = 2 }
        [schemas.low]
        type = "test/motor"
        imports = { input = "eye.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low iterate");
    assert!(has_error(&app, "eye", "dust"));
    app.stop();
}

fn exports_of_a_faulted_schema_are_retracted(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            if io.scenario.has_line("low iterate") {
                return Err("dust".into());
            }
            io.publish(1.0);
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            io.ready(io.input().is_some());
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        restart = "never"
        [schemas.low]
        type = "test/motor"
        period = "1000s"
        imports = { input = "eye.out" }
        triggers = ["input"]
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low iterate");
    // The period is long: `low` checks again because the value was retracted (R12).
    app.until(|app| app.schema("low").state == State::Checking);
    app.until(|app| faults(app, "eye") == ["dust"]);
    app.stop();
}

fn values_that_a_faulted_schema_publishes_in_sleep_are_discarded(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        match call {
            Call::Iterate => return Err("dust".into()),
            Call::Sleep => io.publish(1.0),
            _ => {}
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        restart = "never"
        [schemas.low]
        type = "test/motor"
        imports = { input = "eye.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("eye drop");
    assert!(app.scenario.has_line("eye sleep"));
    let out = app.handle.value::<f64>("eye.out");
    assert_eq!(out, Ok(None));
    app.stop();
}
