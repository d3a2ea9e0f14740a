//! What a winner finds of earlier commands (R7, R9): taken over by it, or neutral.

mod fathers;

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex, mpsc};

use jde_types::Twist;

use crate::common::{Call, Executor, Rig, Stage, in_real_time, on_every_executor};

on_every_executor!(
    r7_whoever_commands_something_else_finds_the_losers_command_neutral,
    r7_after_a_fault_the_next_finds_the_losers_command_neutral,
    r7_after_a_stop_by_an_operator_the_next_finds_the_losers_command_neutral,
    r9_a_hold_ends_when_a_sibling_wins,
    r9_a_hold_below_ends_when_somebody_else_wins_above,
    r9_a_hold_ends_when_the_same_one_wins_again,
    r7_of_two_actuators_the_one_that_nobody_takes_over_is_neutral,
    r7_between_two_that_command_the_same_actuator_it_never_jerks,
    r7_what_the_winner_does_not_write_in_its_first_iteration_is_neutral_after_it,
);

mod hanging {
    use super::*;

    in_real_time!(r7_after_the_end_of_patience_the_next_finds_the_losers_command_neutral,);
}

/// One schema drives the base and the other the arm of one robot. The base's command would be in force for
/// 1000 s.
const PAIR: &str = r#"
    roots = ["first", "second"]
    [schemas.robot]
    type = "test/robot"
    [schemas.first]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.second]
    type = "test/motor"
    actuators = { arm = "robot.reach" }
"#;

/// A schema that commands the base, and a father whose children command the base and the arm.
const FAMILY: &str = r#"
    roots = ["first", "father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.first]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.father]
    type = "test/motor"
    children = { a = "left", b = "right" }
    groups.base = { policy = "priority" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.right]
    type = "test/motor"
    actuators = { arm = "robot.reach" }
"#;

fn switch(on: bool) -> Arc<AtomicBool> {
    Arc::new(AtomicBool::new(on))
}

/// Records the base's command at each iteration of a schema that does not write it. That schema may be the
/// first to win at the start.
fn finds(stage: &Stage, name: &str, ready: &Arc<AtomicBool>) -> Arc<Mutex<Vec<f64>>> {
    let found = Arc::new(Mutex::new(Vec::new()));
    let (finds, ready) = (Arc::clone(&found), Arc::clone(ready));
    stage.play(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                if let Some(handle) = io.stage.handle() {
                    let found: Option<Twist> = handle.value("robot.velocity").expect("it is one");
                    finds
                        .lock()
                        .unwrap()
                        .push(found.map_or(0.0, |twist| twist.linear.x));
                    io.stage.stir();
                }
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    found
}

/// A father that wakes both its children in each iteration.
fn leads(stage: &Stage, name: &str, ready: &Arc<AtomicBool>) {
    let ready = Arc::clone(ready);
    stage.play(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
}

fn velocity(rig: &Rig) -> f64 {
    let found: Option<Twist> = rig.handle.value("robot.velocity").expect("it is one");
    found.map_or(0.0, |twist| twist.linear.x)
}

fn r7_whoever_commands_something_else_finds_the_losers_command_neutral(executor: Executor) {
    let stage = Stage::new();
    let (first, second) = (switch(true), switch(true));
    stage.drives("first", &first, 0.3);
    let found = finds(&stage, "second", &second);
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.until_did("robot velocity 0");
    rig.stop();
}

fn r7_after_a_fault_the_next_finds_the_losers_command_neutral(executor: Executor) {
    let stage = Stage::new();
    let (fails, second) = (switch(false), switch(true));
    let failing = Arc::clone(&fails);
    stage.play("first", move |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate if failing.load(SeqCst) => Err("it broke".into()),
        Call::Iterate => {
            io.command(0.3);
            Ok(())
        }
        Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => Ok(()),
    });
    let found = finds(&stage, "second", &second);
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    fails.store(true, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.stop();
}

fn r7_after_a_stop_by_an_operator_the_next_finds_the_losers_command_neutral(executor: Executor) {
    let stage = Stage::new();
    stage.drives("first", &switch(true), 0.3);
    let found = finds(&stage, "second", &switch(true));
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    let first = rig.place("first");
    rig.operator().hold_asleep(first).expect("it can be stopped");
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.stop();
}

fn r7_after_the_end_of_patience_the_next_finds_the_losers_command_neutral(executor: Executor) {
    let stage = Stage::new();
    let second = switch(false);
    let (release, held) = mpsc::channel::<()>();
    stage.play("first", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                // An error means that the sender was dropped.
                let _ = held.recv();
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let found = finds(&stage, "second", &second);
    let body = PAIR.replace("actuators = { base", "budget = \"1000s\"\n actuators = { base");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    second.store(true, SeqCst);
    let place = rig.place("second");
    rig.operator().force(place).expect("it can be forced");
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    drop(release);
    rig.stop();
}

/// Holds every command for 1000 s.
fn holding(body: &str) -> String {
    format!("root = {{ absence = \"hold\", hold = \"1000s\" }}\n{body}")
}

fn r9_a_hold_ends_when_a_sibling_wins(executor: Executor) {
    let stage = Stage::new();
    let (first, second) = (switch(true), switch(false));
    stage.drives("first", &first, 0.3);
    let found = finds(&stage, "second", &second);
    let mut rig = Rig::start(executor, &stage, &holding(PAIR));
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|rig| rig.winner("roots").is_none());
    assert_eq!(velocity(&rig), 0.3, "it is held");
    second.store(true, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.until_did("robot velocity 0");
    rig.stop();
}

fn r9_a_hold_below_ends_when_somebody_else_wins_above(executor: Executor) {
    let stage = Stage::new();
    let (example, vff, head) = (switch(true), switch(true), switch(false));
    leads(&stage, "example", &example);
    stage.drives("vff", &vff, 0.4);
    let found = finds(&stage, "head", &head);
    let body = r#"
        roots = ["head", "example"]
        [schemas.robot]
        type = "test/robot"
        [schemas.head]
        type = "test/motor"
        actuators = { arm = "robot.reach" }
        [schemas.example]
        type = "test/motor"
        children = { a = "vff" }
        groups.base = { policy = "priority", absence = "hold", hold = "1000s" }
        [schemas.vff]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.4");
    found.lock().unwrap().clear();
    vff.store(false, SeqCst);
    rig.until(|rig| rig.winner("example/base").is_none());
    assert_eq!(velocity(&rig), 0.4, "it is held");
    head.store(true, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.until_did("robot velocity 0");
    rig.stop();
}

fn r9_a_hold_ends_when_the_same_one_wins_again(executor: Executor) {
    let stage = Stage::new();
    let (first, writes) = (switch(true), switch(true));
    let (ready, writing) = (Arc::clone(&first), Arc::clone(&writes));
    stage.play("first", move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate if writing.load(SeqCst) => {
                io.command(0.3);
            }
            Call::Iterate | Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, &holding(PAIR));
    rig.until_did("robot velocity 0.3");
    first.store(false, SeqCst);
    rig.until(|rig| rig.winner("roots").is_none());
    writes.store(false, SeqCst);
    first.store(true, SeqCst);
    rig.until_did("robot velocity 0");
    assert_eq!(rig.winner("roots").as_deref(), Some("first"));
    rig.stop();
}

fn r7_of_two_actuators_the_one_that_nobody_takes_over_is_neutral(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    let ready = Arc::clone(&first);
    stage.play("first", move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                io.command(0.3);
                io.reach(0.2);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let found = finds(&stage, "second", &switch(true));
    // Both schemas command the robot's first command, and only `first` commands the legs'.
    let body = r#"
        roots = ["first", "second"]
        [schemas.robot]
        type = "test/robot"
        [schemas.legs]
        type = "test/robot"
        [schemas.first]
        type = "test/motor"
        actuators = { base = "robot.velocity", arm = "legs.velocity" }
        [schemas.second]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("legs velocity 0.2");
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| found.lock().unwrap().len() > 1);
    assert_eq!(
        found.lock().unwrap()[..2],
        [0.3, 0.0],
        "taken over, and not written"
    );
    let legs: Option<Twist> = rig.handle.value("legs.velocity").expect("it is one");
    assert_eq!(legs, Some(Twist::ZERO), "not taken over");
    rig.stop();
}

fn r7_between_two_that_command_the_same_actuator_it_never_jerks(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    stage.drives("second", &switch(true), 0.2);
    let body = PAIR.replace("arm = \"robot.reach\"", "base = \"robot.velocity\"");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot velocity 0.3");
    let command = rig.handle.board().get("robot.velocity").expect("a command");
    let (values, reads) = (
        Arc::new(Mutex::new(Vec::new())),
        Mutex::new(command.reader("test")),
    );
    let heard = Arc::clone(&values);
    let watch = command.watch(move || {
        let mut reader = reads.lock().unwrap();
        let bytes = reader.latch().expect("it was published").bytes.to_vec();
        reader.release();
        heard.lock().unwrap().push(bytes);
    });
    first.store(false, SeqCst);
    rig.until_did("robot velocity 0.2");
    drop(watch);
    let neutral = jde_types::Value::as_bytes(&Twist::ZERO).to_vec();
    assert!(!values.lock().unwrap().contains(&neutral));
    rig.stop();
}

fn r7_what_the_winner_does_not_write_in_its_first_iteration_is_neutral_after_it(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    let found = finds(&stage, "second", &switch(true));
    let body = PAIR.replace("arm = \"robot.reach\"", "base = \"robot.velocity\"");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| found.lock().unwrap().len() > 1);
    assert_eq!(found.lock().unwrap()[..2], [0.3, 0.0]);
    rig.until_did("robot velocity 0");
    rig.stop();
}
