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
        r14_everything_is_stopped_although_a_winner_does_not_return,
        r14_what_a_slow_winner_still_commands_is_not_held,
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

/// A winner that is inside an iteration until the other end is dropped, and then commands once more.
fn slow(stage: &Stage) -> mpsc::Sender<()> {
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
    stage.drives("low", &Arc::new(true.into()), 0.1);
    release
}

fn velocity(rig: &Rig) -> Option<Twist> {
    rig.handle.value("robot.velocity").expect("it is one")
}

/// It would not count as hung for minutes.
const SLOW: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    budget = "100s"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn r14_everything_is_stopped_although_a_winner_does_not_return(executor: Executor) {
    let stage = Stage::new();
    let release = slow(&stage);
    let mut rig = Rig::start(executor, &stage, SLOW);
    rig.until_did("robot velocity 0.3");
    rig.operator().stop_all().expect("nothing keeps it from that");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.until(|rig| rig.winner("roots").is_none());
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high sleep");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    assert!(!stage.did("low iterate"));
    rig.stop();
}

fn r14_what_a_slow_winner_still_commands_is_not_held(executor: Executor) {
    let stage = Stage::new();
    let release = slow(&stage);
    // By R9 its last command would be in force for a quarter of an hour.
    let roots = "root = { absence = \"hold\", hold = \"1000s\", patience = \"100s\" }\n[schemas.robot]";
    let mut rig = Rig::start(executor, &stage, &SLOW.replace("[schemas.robot]", roots));
    rig.until_did("robot velocity 0.3");
    rig.operator().stop_all().expect("nothing keeps it from that");
    drop(release);
    rig.until_did("high then Accepted");
    rig.until(|rig| rig.winner("roots").is_none());
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.until_did("robot sleep");
    rig.stop();
}
