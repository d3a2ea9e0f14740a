//! Calls that do not return: authority is withdrawn, siblings take over, all other schemas continue, and the
//! application can still end.
//!
//! Lockstep has one thread, and calls take no time there, so these tests run on the real-time executors only.

use std::sync::{Arc, mpsc};

use jde_core::{Health, SchemaId, State};
use jde_records::event::{Event, Outcome, What};
use parking_lot::Mutex;

use crate::common::{Call, Executor, Language, Scenario, TestApp, in_languages, in_real_time};

in_real_time!(
    r1_a_loser_that_hangs_loses_its_authority_after_patience,
    a_winner_that_hangs_is_faulted_and_its_sibling_takes_over,
    a_schema_that_hangs_wins_again_in_a_fresh_instance_while_its_call_still_hangs,
    values_that_an_abandoned_call_publishes_are_discarded,
    many_schemas_that_hang_do_not_stop_the_others,
    a_driver_that_hangs_while_it_starts_ends_the_application,
    r5_the_children_of_a_father_that_hangs_sleep,
);

in_languages!(Threads, [C Cpp Python]:
    a_winner_that_hangs_is_faulted_and_its_sibling_takes_over,
    a_driver_that_hangs_while_it_starts_ends_the_application,
    r5_the_children_of_a_father_that_hangs_sleep,
);
// A process in which a call hangs is killed, so no call of it returns.
in_languages!(Threads, [C Cpp]:
    r1_a_loser_that_hangs_loses_its_authority_after_patience,
    a_schema_that_hangs_wins_again_in_a_fresh_instance_while_its_call_still_hangs,
    values_that_an_abandoned_call_publishes_are_discarded,
);

pub(crate) const PAIR: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    restart = "never"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    restart = { back-off = "5ms", limit = 5 }
    actuators = { base = "robot.velocity" }
"#;

/// A function that blocks until the sender is used or dropped.
pub(crate) fn blocker() -> (mpsc::Sender<()>, impl Fn() + Send + 'static) {
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    (release, move || {
        // An error means that the sender was dropped.
        let _ = held.lock().recv();
    })
}

pub(crate) fn hung(event: &Event, index: SchemaId) -> bool {
    matches!(event.what(), Some(What::Hung { schema, .. }) if *schema == index)
}

fn r1_a_loser_that_hangs_loses_its_authority_after_patience(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let ready = Arc::new(false.into());
    scenario.drives("high", &ready, 0.3);
    let mut hung_once = false;
    scenario.on_call("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate if !hung_once => {
                hung_once = true;
                io.command(0.1);
                hang();
                let outcome = io.command(9.9);
                io.record(format!("returned {outcome:?}"));
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.1");
    ready.store(true, std::sync::atomic::Ordering::SeqCst);
    app.until_line("robot velocity 0.3");
    assert!(!app.schema("low").authority);
    release.send(()).expect("the call hangs");
    app.until_line("low returned Refused");
    assert!(app.schema("low").refused > 0);
    let low = app.index("low");
    assert!(
        scenario
            .has_event(|event| matches!(event.what(), Some(What::Refused { schema, .. }) if *schema == low))
    );
    assert!(!scenario.has_line("robot velocity 9.9"));
    app.stop();
}

fn a_winner_that_hangs_is_faulted_and_its_sibling_takes_over(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    scenario.on_call("high", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                hang();
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    let before = scenario.lines().len();
    app.until(|app| {
        app.scenario.lines()[before..]
            .iter()
            .any(|line| line == "robot velocity 0.1")
    });
    let high = app.index("high");
    assert!(scenario.has_event(|event| hung(event, high)));
    let view = app.schema("high");
    assert_eq!(
        (view.state, view.authority, view.faults),
        (State::Slept, false, 1)
    );
    assert!(
        matches!(view.health, Health::Faulted(reason) if reason.starts_with("has not returned from a call for "))
    );
    drop(release);
    app.stop();
}

fn a_schema_that_hangs_wins_again_in_a_fresh_instance_while_its_call_still_hangs(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let mut hang = Some(hang);
    scenario.on_call("low", move |call, io| {
        match (call, hang.is_some()) {
            (Call::Check, _) => io.ready(true),
            (Call::Iterate, true) => {
                io.command(0.1);
                let hang = hang.take().expect("it was checked");
                io.then(move |io| {
                    hang();
                    io.record("returned");
                    // An instance of the same name has authority now.
                    io.command(9.9);
                    io.record("continued");
                });
            }
            (Call::Iterate, false) => {
                io.command(0.2);
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(
        executor,
        &scenario,
        &PAIR.replace("limit = 5 }", "limit = 5 }\nhang = \"250ms\""),
    );
    let low = app.index("low");
    app.until_line("robot velocity 0.1");
    app.until_line("robot velocity 0.2");
    assert!(scenario.has_event(|event| hung(event, low)));
    assert!(scenario.has_event(
        |event| matches!(event.what(), Some(What::CallAbandoned { schema, abandoned: 1, retained_bytes, process, .. })
        if *schema == low && *retained_bytes > 0 && process.files > 0)
    ));
    app.until(|app| app.schema("low").health == Health::Ok);
    assert_eq!(app.schema("low").left, 1);
    assert!(
        !scenario.has_line("low drop"),
        "an instance whose call runs is not dropped"
    );
    release.send(()).expect("the call hangs");
    app.until(|app| app.schema("low").left == 0);
    app.until(|app| {
        let returned =
            |event: &Event| matches!(event.what(), Some(What::AbandonedCallReturned { schema, abandoned: 0, .. }) if *schema == low);
        app.scenario.has_event(returned)
    });
    assert_eq!(
        scenario.count("low drop"),
        1,
        "it is dropped once, after its call returns"
    );
    assert!(scenario.has_line("low returned"));
    // In C nothing unwinds: each request is refused, and the call goes on.
    assert_eq!(
        scenario.has_line("low continued"),
        Language::of_test() == Language::C,
        "any request ends an abandoned call"
    );
    let before = scenario.count("low iterate");
    app.until(|app| app.scenario.count("low iterate") > before + 3);
    assert!(!scenario.has_line("robot velocity 9.9"), "R7");
    assert_eq!(app.schema("low").faults, 1);
    app.stop();
    assert_eq!(scenario.count("low drop"), 2);
}

fn values_that_an_abandoned_call_publishes_are_discarded(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    let mut hang = Some(hang);
    let mut value = 10.0;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            value += 1.0;
            match hang.take() {
                Some(hang) => {
                    io.publish(1.0);
                    io.then(move |io| {
                        hang();
                        io.record("returned");
                        io.publish(99.0);
                    });
                }
                None => io.publish(value),
            }
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => io.record(format!("read {:?}", io.input().map(|(value, _)| value))),
            _ => {}
        }
        Ok(())
    });
    let body = r#"
        roots = ["low"]
        [schemas.eye]
        type = "test/eye"
        restart = { back-off = "200ms", limit = 5 }
        hang = "250ms"
        [schemas.low]
        type = "test/motor"
        imports = { input = "eye.out" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("low read Some(1.0)");
    // The value is invalid while its writer hangs.
    app.until(|app| app.scenario.lines().iter().any(|line| line == "low read None"));
    app.until(|app| {
        app.scenario
            .lines()
            .iter()
            .any(|line| line.starts_with("low read Some(2"))
    });
    release.send(()).expect("the call hangs");
    app.until(|app| app.scenario.count("eye drop") == 1);
    let before = scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > before + 3);
    assert!(scenario.has_line("eye returned"));
    assert!(!scenario.has_line("low read Some(99.0)"));
    app.stop();
}

fn many_schemas_that_hang_do_not_stop_the_others(executor: Executor) {
    let scenario = Scenario::new();
    let mut body = String::from(
        r#"
        roots = ["low"]
        [schemas.robot]
        type = "test/robot"
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        children = { helper = "eye-0" }
        "#,
    );
    let mut senders = Vec::new();
    for number in 0..12 {
        let (release, hang) = blocker();
        senders.push(release);
        let name = format!("eye-{number}");
        scenario.on_call(&name, move |call, _| {
            if call == Call::Iterate {
                hang();
            }
            Ok(())
        });
        let next = match number {
            11 => String::new(),
            _ => format!("imports = {{ input = \"eye-{}.out\" }}", number + 1),
        };
        body += &format!("[schemas.{name}]\ntype = \"test/eye\"\n{next}\n");
    }
    scenario.on_call("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            // With twelve calls at once, the pool would have no free worker.
            Call::Iterate => {
                io.wake("helper");
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| (0..12).all(|number| app.schema(&format!("eye-{number}")).faults > 0));
    let before = scenario.count("low iterate");
    app.until(|app| app.scenario.count("low iterate") > before + 10);
    assert_eq!(app.schema("low").faults, 0);
    drop(senders);
    app.stop();
}

fn a_driver_that_hangs_while_it_starts_ends_the_application(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    scenario.on_call("robot", move |call, _| {
        if call == Call::Awake {
            hang();
        }
        Ok(())
    });
    let app = TestApp::start(executor, &scenario, PAIR);
    let Outcome::Broken(reason) = app.wait() else {
        panic!("the hang was not detected");
    };
    assert!(
        reason.starts_with("driver `robot` could not start: has not returned from a call for "),
        "{reason}"
    );
    drop(release);
}

fn r5_the_children_of_a_father_that_hangs_sleep(executor: Executor) {
    let scenario = Scenario::new();
    let (release, hang) = blocker();
    scenario.on_call("father", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                if io.scenario.has_line("robot velocity 0.1") {
                    hang();
                }
            }
            _ => {}
        }
        Ok(())
    });
    scenario.drives("left", &Arc::new(true.into()), 0.1);
    let body = r#"
        roots = ["father"]
        [schemas.robot]
        type = "test/robot"
        [schemas.father]
        type = "test/motor"
        restart = "never"
        children = { a = "left" }
        [schemas.left]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.1");
    app.until_line("left sleep");
    // No schema needs the robot any more.
    app.until_line("robot sleep");
    assert!(matches!(app.schema("father").health, Health::Faulted(_)));
    drop(release);
    app.stop();
}
