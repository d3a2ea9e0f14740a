//! Calls that do not return: authority is withdrawn, siblings take over, all others continue, and the
//! application can still end.
//!
//! In lockstep there is one thread and no time to miss, so these tests are for the executors of real time.

use std::sync::{Arc, Mutex, mpsc};

use jde_core::{Health, State};
use jde_records::event::{Event, Outcome};

use crate::common::{Call, Executor, Rig, Stage, in_real_time};

in_real_time!(
    r1_a_loser_that_hangs_loses_its_authority_after_patience,
    a_winner_that_hangs_is_faulted_and_its_sibling_takes_over,
    a_schema_that_hangs_wins_again_in_a_fresh_instance_while_its_call_still_hangs,
    nobody_sees_what_a_call_publishes_that_was_given_up,
    many_that_hang_leave_the_others_running,
    a_driver_that_hangs_while_it_starts_ends_the_application,
    r5_a_father_that_hangs_takes_its_children_with_it,
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
pub(crate) fn hook() -> (mpsc::Sender<()>, impl Fn() + Send + 'static) {
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    (release, move || {
        // An error means that the sender was dropped.
        let _ = held.lock().unwrap().recv();
    })
}

pub(crate) fn hung(event: &Event, place: usize) -> bool {
    matches!(event, Event::Hung { schema, .. } if *schema == place)
}

fn r1_a_loser_that_hangs_loses_its_authority_after_patience(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let ready = Arc::new(false.into());
    stage.drives("high", &ready, 0.3);
    let mut hung_once = false;
    stage.play("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate if !hung_once => {
                hung_once = true;
                io.command(0.1);
                hang();
                let outcome = io.command(9.9);
                io.say(format!("back {outcome:?}"));
            }
            Call::Awake | Call::Iterate | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.1");
    ready.store(true, std::sync::atomic::Ordering::SeqCst);
    rig.until_did("robot velocity 0.3");
    assert!(!rig.see("low").authority);
    release.send(()).expect("it hangs");
    rig.until_did("low back Refused");
    assert!(rig.see("low").refused > 0);
    let low = rig.place("low");
    assert!(stage.told(|event| matches!(event, Event::Refused { schema, .. } if *schema == low)));
    assert!(!stage.did("robot velocity 9.9"));
    rig.stop();
}

fn a_winner_that_hangs_is_faulted_and_its_sibling_takes_over(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    stage.drives("low", &Arc::new(true.into()), 0.1);
    stage.play("high", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                hang();
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    let after = stage.lines().len();
    rig.until(|rig| {
        rig.stage.lines()[after..]
            .iter()
            .any(|line| line == "robot velocity 0.1")
    });
    let high = rig.place("high");
    assert!(stage.told(|event| hung(event, high)));
    let view = rig.see("high");
    assert_eq!(
        (view.state, view.authority, view.faults),
        (State::Slept, false, 1)
    );
    assert!(
        matches!(view.health, Health::Faulted(reason) if reason.starts_with("has not returned from a call for "))
    );
    drop(release);
    rig.stop();
}

fn a_schema_that_hangs_wins_again_in_a_fresh_instance_while_its_call_still_hangs(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let mut hang = Some(hang);
    stage.play("low", move |call, io| {
        match (call, hang.is_some()) {
            (Call::Check, _) => io.ready(true),
            (Call::Iterate, true) => {
                io.command(0.1);
                let hang = hang.take().expect("it is there");
                io.then(move |io| {
                    hang();
                    io.say("back");
                    // An instance of the same name has authority now.
                    io.command(9.9);
                    io.say("went on");
                });
            }
            (Call::Iterate, false) => {
                io.command(0.2);
            }
            (Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop, _) => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(
        executor,
        &stage,
        &PAIR.replace("limit = 5 }", "limit = 5 }\nhang = \"250ms\""),
    );
    let low = rig.place("low");
    rig.until_did("robot velocity 0.1");
    rig.until_did("robot velocity 0.2");
    assert!(stage.told(|event| hung(event, low)));
    assert!(stage.told(
        |event| matches!(event, Event::CallAbandoned { schema, abandoned: 1, retained_bytes, process, .. }
        if *schema == low && *retained_bytes > 0 && process.files > 0)
    ));
    rig.until(|rig| rig.see("low").health == Health::Ok);
    assert_eq!(rig.see("low").left, 1);
    assert!(!stage.did("low drop"), "what may still run is not ended");
    release.send(()).expect("it hangs");
    rig.until(|rig| rig.see("low").left == 0);
    rig.until(|rig| {
        let came_back =
            |event: &Event| matches!(event, Event::AbandonedCallReturned { schema, abandoned: 0, .. } if *schema == low);
        rig.stage.told(came_back)
    });
    assert_eq!(stage.count("low drop"), 1, "it ends when it returns, and once");
    assert!(stage.did("low back"));
    assert!(!stage.did("low went on"), "whatever it asks for ends it");
    let before = stage.count("low iterate");
    rig.until(|rig| rig.stage.count("low iterate") > before + 3);
    assert!(!stage.did("robot velocity 9.9"), "R7");
    assert_eq!(rig.see("low").faults, 1);
    rig.stop();
    assert_eq!(stage.count("low drop"), 2);
}

fn nobody_sees_what_a_call_publishes_that_was_given_up(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let mut hang = Some(hang);
    let mut value = 10.0;
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            value += 1.0;
            match hang.take() {
                Some(hang) => {
                    io.publish(1.0);
                    io.then(move |io| {
                        hang();
                        io.say("back");
                        io.publish(99.0);
                    });
                }
                None => io.publish(value),
            }
        }
        Ok(())
    });
    stage.play("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => io.say(format!("saw {:?}", io.input().map(|(value, _)| value))),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("low saw Some(1.0)");
    // The value is no longer valid while its writer hangs.
    rig.until(|rig| rig.stage.lines().iter().any(|line| line == "low saw None"));
    rig.until(|rig| {
        rig.stage
            .lines()
            .iter()
            .any(|line| line.starts_with("low saw Some(2"))
    });
    release.send(()).expect("it hangs");
    rig.until(|rig| rig.stage.count("eye drop") == 1);
    let before = stage.count("eye iterate");
    rig.until(|rig| rig.stage.count("eye iterate") > before + 3);
    assert!(stage.did("eye back"));
    assert!(!stage.did("low saw Some(99.0)"));
    rig.stop();
}

fn many_that_hang_leave_the_others_running(executor: Executor) {
    let stage = Stage::new();
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
    let mut hooks = Vec::new();
    for number in 0..12 {
        let (release, hang) = hook();
        hooks.push(release);
        let name = format!("eye-{number}");
        stage.play(&name, move |call, _| {
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
    stage.play("low", |call, io| {
        match call {
            Call::Check => io.ready(true),
            // With twelve calls at once, the pool would have no free worker.
            Call::Iterate => {
                io.wake("helper");
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| (0..12).all(|number| rig.see(&format!("eye-{number}")).faults > 0));
    let before = stage.count("low iterate");
    rig.until(|rig| rig.stage.count("low iterate") > before + 10);
    assert_eq!(rig.see("low").faults, 0);
    drop(hooks);
    rig.stop();
}

fn a_driver_that_hangs_while_it_starts_ends_the_application(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    stage.play("robot", move |call, _| {
        if call == Call::Awake {
            hang();
        }
        Ok(())
    });
    let rig = Rig::start(executor, &stage, PAIR);
    let Outcome::Broken(reason) = rig.wait() else {
        panic!("it was not noticed");
    };
    assert!(
        reason.starts_with("driver `robot` could not start: has not returned from a call for "),
        "{reason}"
    );
    drop(release);
}

fn r5_a_father_that_hangs_takes_its_children_with_it(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let mut iterations = 0;
    stage.play("father", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                iterations += 1;
                io.wake("a");
                if iterations > 3 {
                    hang();
                }
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    stage.drives("left", &Arc::new(true.into()), 0.1);
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.1");
    rig.until_did("left sleep");
    // No schema needs the robot any more.
    rig.until_did("robot sleep");
    assert!(matches!(rig.see("father").health, Health::Faulted(_)));
    drop(release);
    rig.stop();
}
