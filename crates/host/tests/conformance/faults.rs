//! Schemas that panic or fail in any of their calls. They harm no other schema, and their restart policy
//! decides.

use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Arc, Mutex};

use jde_core::{Health, State};
use jde_host::{Options, StartError};
use jde_records::event::{Event, Outcome};

use crate::common::{Call, Executor, LIVE, Rig, Stage, on_every_executor};

on_every_executor!(
    a_schema_that_cannot_be_made_starts_nothing,
    a_panic_while_waking_is_a_fault,
    a_panic_in_a_check_is_a_fault,
    a_panic_in_an_iteration_is_a_fault,
    a_panic_while_going_to_sleep_is_a_fault,
    a_panic_while_dropped_hurts_nobody,
    an_error_is_a_fault_with_its_words,
    a_faulted_winner_is_replaced_at_once_and_its_commands_end,
    a_restart_makes_a_fresh_instance,
    restarts_end_at_their_limit,
    restarts_that_are_long_ago_count_no_more,
    who_has_used_up_its_restarts_is_played_or_loaded_back,
    r15_a_fault_without_a_successor_is_a_switch,
    a_schema_that_never_restarts_stays_faulted,
    a_driver_that_cannot_start_ends_the_application,
    a_driver_that_worked_before_is_restarted,
    a_perceptive_schema_that_faults_is_restarted,
    nobody_acts_on_what_a_faulted_schema_said_before,
    nobody_acts_on_what_a_faulted_schema_says_as_it_goes_to_sleep,
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
fn start(executor: Executor, when: Call, fail: impl Fn(u64) -> jde_schema::Result + Send + 'static) -> Rig {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("high", move |call, io| {
        if call == Call::Check {
            io.ready(io.stage.did("low iterate"));
        }
        if call == Call::Iterate {
            io.command(0.3);
        }
        if call == when { fail(io.memory) } else { Ok(()) }
    });
    Rig::start(executor, &stage, PAIR)
}

/// The reasons of the faults of an instance, in order.
fn faults(rig: &Rig, name: &str) -> Vec<String> {
    let place = rig.place(name);
    let events = rig.stage.events().into_iter();
    let reasons = events.filter_map(|event| match event {
        Event::HealthChanged {
            schema,
            health: Health::Faulted(reason),
            ..
        } if schema == place => Some(reason),
        _ => None,
    });
    reasons.collect()
}

/// Runs until `high` has faulted for that reason and `low` drives in its place.
fn replaced(rig: &mut Rig, because: &str) {
    rig.until(|rig| !faults(rig, "high").is_empty());
    let reasons = faults(rig, "high");
    assert!(
        reasons.iter().all(|reason| reason.contains(because)),
        "{reasons:?}"
    );
    rig.until_did("robot velocity 0.1");
    assert!(rig.see("high").faults > 0);
    assert_eq!((rig.see("low").faults, rig.see("robot").faults), (0, 0));
}

fn a_schema_that_cannot_be_made_starts_nothing(executor: Executor) {
    let stage = Stage::new();
    let body = r#"
        roots = ["first", "second"]
        [schemas.first]
        type = "test/motor"
        [schemas.second]
        type = "test/stillborn"
        [schemas.third]
        type = "test/motor"
    "#;
    let body = body.replace("\"second\"]", "\"second\", \"third\"]");
    let before = LIVE.get();
    let refused = Rig::try_start(executor, &stage, &body, Options::default());
    let Err(error @ StartError::Create { .. }) = refused else {
        panic!("it started");
    };
    let said = error.to_string();
    assert!(
        said.starts_with("schema `second` (type `test/stillborn`) cannot be made: panicked at "),
        "{said}"
    );
    assert!(said.ends_with("there is no such device"), "{said}");
    assert_eq!(LIVE.get(), before, "what was made was ended");
    assert_eq!(stage.lines(), [""; 0]);
}

fn a_panic_while_waking_is_a_fault(executor: Executor) {
    let mut rig = start(executor, Call::Awake, |_| panic!("no eyes"));
    replaced(&mut rig, "panicked in awake: panicked at ");
    assert!(faults(&rig, "high")[0].ends_with("no eyes"));
    assert!(!rig.stage.did("high iterate"));
    rig.stop();
}

fn a_panic_in_a_check_is_a_fault(executor: Executor) {
    let mut rig = start(executor, Call::Check, |_| panic!("no idea"));
    replaced(&mut rig, "panicked in check: panicked at ");
    assert!(!rig.stage.did("high iterate"));
    rig.stop();
}

fn a_panic_in_an_iteration_is_a_fault(executor: Executor) {
    let mut rig = start(executor, Call::Iterate, |_| panic!("no legs"));
    replaced(&mut rig, "panicked in iterate: panicked at ");
    rig.until(|rig| faults(rig, "high").len() == 3);
    rig.stop();
}

fn a_panic_while_going_to_sleep_is_a_fault(executor: Executor) {
    let mut rig = start(executor, Call::Sleep, |_| panic!("no peace"));
    rig.until_did("robot velocity 0.3");
    let high = rig.place("high");
    rig.operator().hold_asleep(high).expect("it can be stopped");
    replaced(&mut rig, "no peace");
    rig.until_did("high drop");
    // A new instance takes its place.
    rig.operator().release(high).expect("it can be released");
    let before = rig.stage.count("high iterate");
    rig.until(|rig| rig.stage.count("high iterate") > before);
    assert_eq!(rig.stop(), Outcome::Stopped);
}

fn a_panic_while_dropped_hurts_nobody(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate => Err("that is all".into()),
        Call::Drop => panic!("not even that"),
        Call::Awake | Call::Sleep | Call::Arbitrate => Ok(()),
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until(|rig| faults(rig, "high").len() == 3);
    rig.until_did("robot velocity 0.1");
    assert_eq!(rig.stop(), Outcome::Stopped);
    assert_eq!(stage.count("high drop"), 3);
}

fn an_error_is_a_fault_with_its_words(executor: Executor) {
    let mut rig = start(executor, Call::Iterate, |_| Err("the battery is low".into()));
    replaced(&mut rig, "the battery is low");
    assert!(
        faults(&rig, "high")
            .iter()
            .all(|reason| reason == "the battery is low")
    );
    rig.stop();
}

fn a_faulted_winner_is_replaced_at_once_and_its_commands_end(executor: Executor) {
    let mut rig = start(executor, Call::Iterate, |_| Err("it broke".into()));
    let stage = Arc::clone(&rig.stage);
    rig.until(|rig| !faults(rig, "high").is_empty());
    let [high, low] = ["high", "low"].map(|name| rig.place(name));
    rig.stop();
    let events = stage.events();
    let at = |wanted: &dyn Fn(&Event) -> bool| events.iter().position(wanted).expect("it happened");
    let fault = at(
        &|event| matches!(event, Event::HealthChanged { schema, health: Health::Faulted(_), .. } if *schema == high),
    );
    // The level has selected again within the same transaction: no event of `high` comes between.
    let asleep =
        at(&|event| matches!(event, Event::StateChanged { schema, to: State::Slept, .. } if *schema == high));
    assert_eq!(asleep, fault + 1);
    let next = events[asleep..].iter().find_map(|event| match event {
        Event::Decided(record) => Some(record.clone()),
        _ => None,
    });
    let next = next.expect("a selection");
    assert_eq!(next.choice.map(|id| id.index()), Some(low), "{next:?}");
    assert!(matches!(next.cause, jde_core::Cause::Faulted(id) if id.index() == high));
}

fn a_restart_makes_a_fresh_instance(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    let memories = Arc::new(Mutex::new(Vec::new()));
    let notes = Arc::clone(&memories);
    let mut failures = 0;
    stage.play("high", move |call, io| {
        match call {
            Call::Awake => notes.lock().unwrap().push(io.memory),
            Call::Check => io.ready(true),
            Call::Iterate if failures < 2 => {
                failures += 1;
                return Err("twice".into());
            }
            Call::Iterate | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until(|rig| rig.see("high").health == Health::Ok && rig.stage.count("high iterate") > 5);
    assert_eq!(*memories.lock().unwrap(), [0; 3]);
    assert_eq!(stage.count("high drop"), 2);
    rig.stop();
}

fn restarts_end_at_their_limit(executor: Executor) {
    let mut rig = start(executor, Call::Iterate, |_| Err("always".into()));
    // The first run, and two restarts.
    rig.until(|rig| rig.see("high").faults == 3);
    let before = rig.stage.count("low iterate");
    rig.until(|rig| rig.stage.count("low iterate") > before + 20);
    let view = rig.see("high");
    assert_eq!((view.state, view.faults), (State::Slept, 3));
    assert_eq!(view.health, Health::Faulted("always".into()));
    assert_eq!(rig.stage.count("high awake"), 3);
    rig.stop();
}

fn restarts_that_are_long_ago_count_no_more(executor: Executor) {
    let stage = Stage::new();
    stage.play("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        // An instance fails after it has run for a while.
        Call::Iterate if io.memory > 40 => Err("again".into()),
        Call::Iterate | Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => Ok(()),
    });
    let body = PAIR.replace(
        "restart = { back-off = \"5ms\", limit = 2 }",
        "restart = { back-off = \"1ms\", limit = 1, within = \"50ms\" }",
    );
    let mut rig = Rig::start(executor, &stage, &body);
    assert_eq!(rig.see("high").restarts_left, Some(1));
    rig.until(|rig| rig.see("high").faults == 5);
    rig.stop();
}

fn who_has_used_up_its_restarts_is_played_or_loaded_back(executor: Executor) {
    let mut rig = start(executor, Call::Iterate, |_| Err("always".into()));
    let high = rig.place("high");
    for (round, back) in ["play", "load", "unload and load"].into_iter().enumerate() {
        rig.until(|rig| {
            let view = rig.see("high");
            view.faults == 3 * (round as u64 + 1) && matches!(view.health, Health::Faulted(_))
        });
        let down = rig.see("high");
        assert_eq!(
            (down.state, down.restarts_left),
            (State::Slept, Some(0)),
            "{back}"
        );
        let refused = rig.operator().force(high).expect_err("it is faulted");
        assert!(
            refused.contains("when it is played, loaded or reloaded"),
            "{refused}"
        );
        match back {
            "play" => rig.operator().play(high),
            "load" => rig.operator().load(high),
            _ => rig
                .operator()
                .unload(high)
                .and_then(|()| rig.operator().load(high)),
        }
        .unwrap_or_else(|refused| panic!("{back}: {refused}"));
    }
    rig.until(|rig| rig.see("high").faults == 12);
    rig.stop();
}

fn r15_a_fault_without_a_successor_is_a_switch(executor: Executor) {
    let stage = Stage::new();
    stage.play("high", |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate => Err("it broke".into()),
        Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => Ok(()),
    });
    let body = PAIR.replace(
        "restart = { back-off = \"5ms\", limit = 2 }",
        "restart = \"never\"",
    );
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| rig.see("high").faults == 1 && rig.group("roots").switches == 2);
    let last = rig.group("roots").last.expect("there was one");
    assert_eq!((last.from, last.to), (Some(rig.place("high")), None));
    rig.stop();
}

fn a_schema_that_never_restarts_stays_faulted(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("high", |call, _| {
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
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| rig.stage.count("low iterate") > 20);
    assert_eq!((stage.count("high awake"), rig.see("high").faults), (1, 1));
    rig.stop();
}

fn a_driver_that_cannot_start_ends_the_application(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("robot", |call, _| match call {
        Call::Awake => Err("no cable".into()),
        _ => Ok(()),
    });
    let rig = Rig::start(executor, &stage, PAIR);
    let expected = Outcome::Broken(String::from("driver `robot` could not start: no cable"));
    assert_eq!(rig.wait(), expected);
    assert!(stage.told(|event| matches!(event, Event::Ended { outcome, .. } if *outcome == expected)));
}

fn a_driver_that_worked_before_is_restarted(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    let calls = AtomicUsize::new(0);
    stage.play("robot", move |call, _| {
        if call == Call::Iterate && calls.fetch_add(1, SeqCst) == 3 {
            return Err("the cable fell out".into());
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until(|rig| rig.stage.count("robot awake") == 2 && rig.stage.count("robot velocity 0.1") > 0);
    rig.until(|rig| rig.see("robot").health == Health::Ok && rig.see("robot").iterations > 6);
    assert_eq!(faults(&rig, "robot"), ["the cable fell out"]);
    assert_eq!(rig.handle.outcome(), None);
    rig.stop();
}

fn a_perceptive_schema_that_faults_is_restarted(executor: Executor) {
    let stage = Stage::new();
    let mut failed = false;
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            if !std::mem::replace(&mut failed, true) {
                return Err("dust".into());
            }
            io.publish(1.0);
        }
        Ok(())
    });
    stage.play("low", |call, io| {
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("low iterate");
    assert_eq!(faults(&rig, "eye"), ["dust"]);
    rig.stop();
}

fn nobody_acts_on_what_a_faulted_schema_said_before(executor: Executor) {
    let stage = Stage::new();
    stage.play("eye", |call, io| {
        if call == Call::Iterate {
            if io.stage.did("low iterate") {
                return Err("dust".into());
            }
            io.publish(1.0);
        }
        Ok(())
    });
    stage.play("low", |call, io| {
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("low iterate");
    // Its period is long: it checks again because the value was retracted (R12).
    rig.until(|rig| rig.see("low").state == State::Checking);
    rig.until(|rig| faults(rig, "eye") == ["dust"]);
    rig.stop();
}

fn nobody_acts_on_what_a_faulted_schema_says_as_it_goes_to_sleep(executor: Executor) {
    let stage = Stage::new();
    stage.play("eye", |call, io| {
        match call {
            Call::Iterate => return Err("dust".into()),
            Call::Sleep => io.publish(1.0),
            Call::Awake | Call::Check | Call::Arbitrate | Call::Drop => {}
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("eye drop");
    assert!(rig.stage.did("eye sleep"));
    let out = rig.handle.value::<f64>("eye.out");
    assert_eq!(out, Ok(None));
    rig.stop();
}
