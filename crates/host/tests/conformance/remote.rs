//! Imports of other applications' exports: to a schema they are like any other import.

use jde_app::RemoteVariable;
use jde_board::typed::TypedWriter;
use jde_core::State;

use crate::common::{Call, Executor, MS, Rig, Stage, on_every_executor};

on_every_executor!(
    r12_a_value_from_elsewhere_triggers_is_taken_back_and_comes_again,
    an_import_that_nobody_serves_has_no_value_and_holds_up_nothing,
);

const APP: &str = r#"
    roots = ["low"]
    [schemas.low]
    type = "test/motor"
    period = "1000s"
    imports = { input = "robot2:eye.out", other = { from = "robot2:eye.out", stale = "300ms" } }
    triggers = ["input"]
"#;

fn looks(stage: &Stage) {
    stage.play("low", |call, io| {
        if call == Call::Check {
            match io.input() {
                Some((value, number)) => io.say(format!("sees {value} {number}")),
                None => io.say("blind"),
            }
            io.ready(io.input().is_some());
        }
        Ok(())
    });
}

fn r12_a_value_from_elsewhere_triggers_is_taken_back_and_comes_again(executor: Executor) {
    let stage = Stage::new();
    looks(&stage);
    let mut rig = Rig::start(executor, &stage, APP);
    let [remote] = &rig.handle.application().remotes[..] else {
        panic!("both imports are of one variable");
    };
    assert_eq!((&*remote.peer, &*remote.variable), ("robot2", "eye.out"));
    assert_eq!(remote.stale_ns, 300 * MS);
    let out = rig.handle.board().get(&remote.local).expect("it is declared");
    let mut link =
        TypedWriter::<f64>::open(&out, RemoteVariable::WRITER, "link").expect("nobody else writes it");
    assert!(TypedWriter::<f64>::open(&out, 1, "another").is_err());
    rig.until_did("low blind");

    let now = rig.handle.now();
    link.write(1.0, now.saturating_sub(5 * MS), now).expect("a value");
    rig.until_did("low sees 1 1");
    rig.until(|rig| rig.see("low").state == State::Winner);
    let status = out.status(rig.handle.now());
    assert_eq!(status.last_writer, Some(RemoteVariable::WRITER));
    assert!(
        status.age >= Some((5 * MS).min(now)),
        "it was on its way for some time"
    );

    let blind = rig.stage.count("low blind");
    out.retract();
    rig.until(|rig| rig.stage.count("low blind") > blind);
    rig.until(|rig| rig.see("low").state == State::Checking);

    let now = rig.handle.now();
    link.write(2.0, now, now).expect("a value");
    rig.until_did("low sees 2 2");
    rig.until(|rig| rig.see("low").state == State::Winner);
    rig.stop();
}

fn an_import_that_nobody_serves_has_no_value_and_holds_up_nothing(executor: Executor) {
    let stage = Stage::new();
    looks(&stage);
    let body = APP.replace("1000s", "10ms");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| rig.stage.count("low blind") > 5);
    assert_eq!(rig.see("low").state, State::Checking);
    assert_eq!(rig.handle.value::<f64>("robot2:eye.out"), Ok(None));
    rig.stop();
}
