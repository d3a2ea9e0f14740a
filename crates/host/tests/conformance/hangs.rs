//! Calls that do not return: authority goes, siblings take over, everybody else goes on, and the end comes all the same.
//!
//! In lockstep there is one thread and no time to miss, so these are for the executors of real time.

use std::sync::{Arc, Mutex, mpsc};

use jde_core::{Health, State};
use jde_host::event::{Event, Outcome};

use crate::common::{Call, Executor, Rig, Stage, in_real_time};

in_real_time!(
    r1_a_loser_that_hangs_loses_its_authority_after_patience,
    a_winner_that_hangs_is_faulted_and_its_sibling_takes_over,
    a_schema_that_comes_back_from_a_hang_runs_again,
    many_that_hang_leave_the_others_running,
    a_driver_that_hangs_while_it_starts_ends_the_application,
    the_end_comes_although_a_call_never_returns,
    r5_a_father_that_hangs_takes_its_children_with_it,
);

const PAIR: &str = r#"
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

/// Something to hang on, until the test drops or uses the other end.
fn hook() -> (mpsc::Sender<()>, impl Fn() + Send + 'static) {
    let (release, held) = mpsc::channel::<()>();
    let held = Mutex::new(held);
    (release, move || {
        // An error says that the other end was dropped.
        let _ = held.lock().unwrap().recv();
    })
}

fn hung(event: &Event, place: usize) -> bool {
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

fn a_schema_that_comes_back_from_a_hang_runs_again(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let mut hung_once = false;
    stage.play("low", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate if !hung_once => {
                hung_once = true;
                hang();
            }
            Call::Iterate => {
                io.command(0.1);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    let low = rig.place("low");
    rig.until(|rig| rig.stage.told(|event| hung(event, low)));
    release.send(()).expect("it hangs");
    rig.until_did("robot velocity 0.1");
    rig.until(|rig| rig.see("low").health == Health::Ok);
    assert!(stage.first("low sleep") < stage.last("low awake"));
    assert!(
        stage.first("low drop") < stage.last("low awake"),
        "what hung is not trusted again"
    );
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
            // By twelve at once the pool would have nobody left.
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

fn the_end_comes_although_a_call_never_returns(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let ready = Arc::new(true.into());
    stage.drives("high", &ready, 0.3);
    let hang = Mutex::new(Some(hang));
    stage.play("low", move |call, io| {
        if call == Call::Check {
            io.say("check");
            if let Some(hang) = hang.lock().unwrap().take() {
                hang();
                io.say("back");
            }
        }
        Ok(())
    });
    // By so long a budget it would not count as hung for a quarter of an hour.
    let body = PAIR.replace("restart = { back-off = \"5ms\", limit = 5 }", "budget = \"100s\"");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot velocity 0.3");
    rig.until_did("low check");
    let low = rig.place("low");
    assert_eq!(rig.stop(), Outcome::Stopped);
    assert!(
        stage.told(|event| hung(event, low)),
        "it is said who stayed behind"
    );
    assert!(matches!(
        stage.events().last(),
        Some(Event::Ended {
            outcome: Outcome::Stopped,
            ..
        })
    ));
    let lines = stage.lines();
    for ended in [
        "high sleep",
        "robot sleep",
        "high drop",
        "robot drop",
        "robot velocity 0",
    ] {
        assert!(lines.iter().any(|line| line == ended), "{ended}");
    }
    assert!(!stage.did("low drop"), "what may still run is not ended");
    drop(release);
    stage.wait_until(|| stage.did("low back"));
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
    // Nobody needs it any more.
    rig.until_did("robot sleep");
    assert!(matches!(rig.see("father").health, Health::Faulted(_)));
    drop(release);
    rig.stop();
}
