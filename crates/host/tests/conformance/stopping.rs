//! Everything stopped at once by an operator, and let go on (R14).

use std::sync::{Arc, mpsc};

use jde_core::State;
use jde_host::snapshot::HoldKind;
use jde_types::Twist;

use crate::common::{Call, Executor, Rig, Stage, in_real_time, on_every_executor};

on_every_executor!(r14_everything_is_stopped_at_once_and_nobody_takes_over_on_the_way);

mod hanging {
    use super::*;

    in_real_time!(
        r14_who_is_inside_an_iteration_commands_nothing_more_when_everything_is_stopped,
        r14_who_is_let_go_on_inside_an_iteration_commands_again,
        r14_who_stays_stopped_inside_an_iteration_commands_nothing_when_another_is_let_go_on,
    );
}

fn r14_everything_is_stopped_at_once_and_nobody_takes_over_on_the_way(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &Arc::new(true.into()), 0.3);
    stage.drives("father", &Arc::new(true.into()), 0.2);
    // Also where the last command would be held (R9).
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.3");
    let father = stage.count("father iterate");
    rig.operator().stop_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.winner("roots").is_none());
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.until_did("robot sleep");
    for root in ["high", "father"] {
        let view = rig.see(root);
        let hold = view.operator.expect("it is held");
        assert_eq!(
            (view.state, hold.kind, hold.by.as_str()),
            (State::Slept, HoldKind::Stopped, "ana@laptop")
        );
    }
    assert_eq!(
        stage.count("father iterate"),
        father,
        "nobody takes over on the way"
    );
    let before = stage.count("high iterate");
    rig.operator().release_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.stage.count("high iterate") > before);
    assert_eq!(rig.see("father").operator, None);
    rig.stop();
}

/// A winner that is inside its first iteration until the other end is dropped, and then commands once more. Nobody is patient enough
/// to count it as hung, or to take its authority by R1.
fn slow(executor: Executor) -> (Rig, mpsc::Sender<()>) {
    let stage = Stage::new();
    let (release, held) = mpsc::channel::<()>();
    stage.play("high", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                // An error says that the other end was dropped.
                let _ = held.recv();
                let outcome = io.command(0.4);
                io.say(format!("then {outcome:?}"));
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    // By R9 the last command would be in force for a quarter of an hour.
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
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.3");
    (rig, release)
}

fn velocity(rig: &Rig) -> Option<Twist> {
    rig.handle.value("robot.velocity").expect("it is one")
}

fn r14_who_is_inside_an_iteration_commands_nothing_more_when_everything_is_stopped(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high sleep");
    rig.until_did("robot sleep");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    assert_eq!(rig.winner("roots"), None);
    rig.stop();
}

fn r14_who_is_let_go_on_inside_an_iteration_commands_again(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    rig.operator().release_all().expect("nothing keeps it from that");
    drop(release);
    rig.until_did("high then Accepted");
    rig.until_did("robot velocity 0.4");
    rig.stop();
}

fn r14_who_stays_stopped_inside_an_iteration_commands_nothing_when_another_is_let_go_on(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    let low = rig.place("low");
    rig.operator().release(low).expect("it was stopped");
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high sleep");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.stop();
}
