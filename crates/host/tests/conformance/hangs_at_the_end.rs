//! Calls that hang at the end: of an instance, or of the application.

use std::sync::{Arc, Mutex};

use jde_core::Health;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::{Event, Outcome};

use super::hangs::{PAIR, hook, hung};
use crate::common::{Call, Executor, Rig, Stage, TEST, in_real_time};

in_real_time!(
    who_hangs_while_it_ends_is_left_behind_and_wins_again,
    the_end_comes_although_a_call_never_returns,
    the_end_comes_although_an_instance_never_ends,
    whoever_waits_for_a_build_to_take_over_is_answered_at_the_end,
);

fn who_hangs_while_it_ends_is_left_behind_and_wins_again(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let mut hang = Some(hang);
    let mut failed = false;
    stage.play("low", move |call, io| {
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
            Call::Awake | Call::Sleep | Call::Arbitrate => {}
        }
        Ok(())
    });
    let body = PAIR.replace("limit = 5 }", "limit = 5 }\nhang = \"250ms\"");
    let mut rig = Rig::start(executor, &stage, &body);
    let low = rig.place("low");
    rig.until_did("robot velocity 0.2");
    assert!(
        stage.told(
            |event| matches!(event, Event::CallAbandoned { schema, abandoned: 1, .. } if *schema == low)
        )
    );
    rig.until(|rig| rig.see("low").health == Health::Ok);
    assert_eq!(rig.see("low").left, 1);
    release.send(()).expect("it hangs");
    rig.until(|rig| rig.see("low").left == 0);
    rig.stop();
    assert_eq!(stage.count("low drop"), 2);
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
    // With this budget a call would count as hung only after 1000 s.
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

fn the_end_comes_although_an_instance_never_ends(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    stage.drives("high", &Arc::new(true.into()), 0.3);
    let mut hang = Some(hang);
    stage.play("low", move |call, io| {
        if call == Call::Drop
            && let Some(hang) = hang.take()
        {
            io.then(move |_| hang());
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    let low = rig.place("low");
    assert_eq!(rig.stop(), Outcome::Stopped);
    assert!(
        stage.told(|event| hung(event, low)),
        "it is said who stayed behind"
    );
    for ended in ["high drop", "robot drop", "robot velocity 0"] {
        assert!(stage.did(ended), "{ended}");
    }
    drop(release);
}

fn whoever_waits_for_a_build_to_take_over_is_answered_at_the_end(executor: Executor) {
    let stage = Stage::new();
    let (release, hang) = hook();
    let hang = Mutex::new(Some(hang));
    stage.play("low", move |call, io| {
        if call == Call::Check {
            io.say("check");
            if let Some(hang) = hang.lock().unwrap().take() {
                hang();
            }
        }
        Ok(())
    });
    let body = PAIR.replace("restart = { back-off = \"5ms\", limit = 5 }", "budget = \"100s\"");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("low check");
    let low = rig.place("low");
    let build = LoadedPlugin::linked_in(&TEST).expect("its tables are right");
    let operator = rig.operator();
    let order = operator
        .replace(low, &build, ReloadOptions::default())
        .expect("it fits");
    assert_eq!(order.outcome(), None, "it is inside a call");
    rig.stop();
    let answer = order.outcome().expect("it is over").expect_err("it had no turn");
    assert_eq!(answer, "the application has ended");
    let late = operator.replace(low, &build, ReloadOptions::default());
    assert_eq!(late.err(), Some(vec![answer]));
    drop(release);
}
