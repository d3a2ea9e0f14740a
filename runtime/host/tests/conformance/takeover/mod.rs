//! What happens to the commands of a loser at a takeover (R7, R9): the winner takes them over, or they become
//! neutral.

mod fathers;

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, mpsc};

use jde_core::State;
use jde_types::Twist;
use parking_lot::Mutex;

use crate::common::{Call, Executor, Scenario, TestApp, in_real_time, on_every_executor};

on_every_executor!(
    r7_the_losers_command_is_neutral_when_the_winner_commands_another_actuator,
    r7_the_losers_command_is_neutral_after_a_fault,
    r7_the_losers_command_is_neutral_after_a_stop_by_an_operator,
    r9_a_hold_ends_when_a_sibling_wins,
    r9_a_hold_below_a_father_ends_when_another_schema_wins_above,
    r9_a_hold_ends_when_the_same_schema_wins_again,
    r7_of_two_actuators_the_one_that_is_not_taken_over_is_neutral,
    r7_an_actuator_that_is_taken_over_receives_no_neutral_command,
    r7_a_command_that_the_winner_does_not_write_in_its_first_iteration_becomes_neutral,
);

mod hanging {
    use super::*;

    in_real_time!(r7_the_losers_command_is_neutral_after_the_end_of_patience,);
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

/// Records the base's command at each iteration of a schema that does not write it. A schema that is ready at the start may
/// be the first winner, and then ends that iteration late.
fn record_velocity(scenario: &Scenario, name: &str, ready: &Arc<AtomicBool>) -> Arc<Mutex<Vec<f64>>> {
    let found = Arc::new(Mutex::new(Vec::new()));
    let (recorder, ready) = (Arc::clone(&found), Arc::clone(ready));
    scenario.on_call(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                if let Some(handle) = io.scenario.handle() {
                    let command: Option<Twist> = handle.value("robot.velocity").expect("it is a command");
                    recorder.lock().push(command.map_or(0.0, |twist| twist.linear.x));
                    io.scenario.notify();
                }
            }
            _ => {}
        }
        Ok(())
    });
    found
}

/// A father that wakes both its children in each iteration.
fn wakes_children(scenario: &Scenario, name: &str, ready: &Arc<AtomicBool>) {
    let ready = Arc::clone(ready);
    scenario.on_call(name, move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            _ => {}
        }
        Ok(())
    });
}

fn velocity(app: &TestApp) -> f64 {
    let command: Option<Twist> = app.handle.value("robot.velocity").expect("it is a command");
    command.map_or(0.0, |twist| twist.linear.x)
}

fn r7_the_losers_command_is_neutral_when_the_winner_commands_another_actuator(executor: Executor) {
    let scenario = Scenario::new();
    let (first, second) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    let found = record_velocity(&scenario, "second", &second);
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    app.until(|app| app.schema("second").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    app.until_line("robot velocity 0");
    app.stop();
}

fn r7_the_losers_command_is_neutral_after_a_fault(executor: Executor) {
    let scenario = Scenario::new();
    let (fails, second) = (switch(false), switch(false));
    let failing = Arc::clone(&fails);
    scenario.on_call("first", move |call, io| match call {
        Call::Check => {
            io.ready(true);
            Ok(())
        }
        Call::Iterate if failing.load(SeqCst) => Err("it broke".into()),
        Call::Iterate => {
            io.command(0.3);
            Ok(())
        }
        _ => Ok(()),
    });
    let found = record_velocity(&scenario, "second", &second);
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    app.until(|app| app.schema("second").state == State::Ready);
    fails.store(true, SeqCst);
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    app.stop();
}

fn r7_the_losers_command_is_neutral_after_a_stop_by_an_operator(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("first", &switch(true), 0.3);
    let second = switch(false);
    let found = record_velocity(&scenario, "second", &second);
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    app.until(|app| app.schema("second").state == State::Ready);
    let first = app.index("first");
    app.operator().hold_asleep(first).expect("it can be stopped");
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    app.stop();
}

fn r7_the_losers_command_is_neutral_after_the_end_of_patience(executor: Executor) {
    let scenario = Scenario::new();
    let second = switch(false);
    let (release, held) = mpsc::channel::<()>();
    scenario.on_call("first", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                // An error means that the sender was dropped.
                let _ = held.recv();
            }
            _ => {}
        }
        Ok(())
    });
    let found = record_velocity(&scenario, "second", &second);
    let body = PAIR.replace("actuators = { base", "budget = \"1000s\"\n actuators = { base");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    let second = app.index("second");
    app.operator().force(second).expect("it can be forced");
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    drop(release);
    app.stop();
}

/// Returns the application with a root group that holds commands for 1000 s.
fn holding(body: &str) -> String {
    format!("root = {{ absence = \"hold\", hold = \"1000s\" }}\n{body}")
}

fn r9_a_hold_ends_when_a_sibling_wins(executor: Executor) {
    let scenario = Scenario::new();
    let (first, second) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    let found = record_velocity(&scenario, "second", &second);
    let mut app = TestApp::start(executor, &scenario, &holding(PAIR));
    app.until_line("robot velocity 0.3");
    first.store(false, SeqCst);
    app.until(|app| app.winner("roots").is_none());
    assert_eq!(velocity(&app), 0.3, "the command is held");
    second.store(true, SeqCst);
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    app.until_line("robot velocity 0");
    app.stop();
}

fn r9_a_hold_below_a_father_ends_when_another_schema_wins_above(executor: Executor) {
    let scenario = Scenario::new();
    let (example, vff, head) = (switch(true), switch(true), switch(false));
    wakes_children(&scenario, "example", &example);
    scenario.drives("vff", &vff, 0.4);
    let found = record_velocity(&scenario, "head", &head);
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("robot velocity 0.4");
    vff.store(false, SeqCst);
    app.until(|app| app.winner("example/base").is_none());
    assert_eq!(velocity(&app), 0.4, "the command is held");
    head.store(true, SeqCst);
    app.until(|_| !found.lock().is_empty());
    assert_eq!(found.lock()[0], 0.0);
    app.until_line("robot velocity 0");
    app.stop();
}

fn r9_a_hold_ends_when_the_same_schema_wins_again(executor: Executor) {
    let scenario = Scenario::new();
    let (first, writes) = (switch(true), switch(true));
    let (ready, writing) = (Arc::clone(&first), Arc::clone(&writes));
    scenario.on_call("first", move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate if writing.load(SeqCst) => {
                io.command(0.3);
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, &holding(PAIR));
    app.until_line("robot velocity 0.3");
    first.store(false, SeqCst);
    app.until(|app| app.winner("roots").is_none());
    writes.store(false, SeqCst);
    first.store(true, SeqCst);
    app.until_line("robot velocity 0");
    assert_eq!(app.winner("roots").as_deref(), Some("first"));
    app.stop();
}

fn r7_of_two_actuators_the_one_that_is_not_taken_over_is_neutral(executor: Executor) {
    let scenario = Scenario::new();
    let first = switch(true);
    let ready = Arc::clone(&first);
    scenario.on_call("first", move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                io.command(0.3);
                io.reach(0.2);
            }
            _ => {}
        }
        Ok(())
    });
    let second = switch(false);
    let found = record_velocity(&scenario, "second", &second);
    // Both schemas command the robot, and only `first` commands the legs.
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
    let mut app = TestApp::start(executor, &scenario, body);
    app.until_line("legs velocity 0.2");
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    app.until(|app| app.schema("second").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| found.lock().len() > 1);
    assert_eq!(found.lock()[..2], [0.3, 0.0], "taken over but not written");
    let legs: Option<Twist> = app.handle.value("legs.velocity").expect("it is a command");
    assert_eq!(legs, Some(Twist::ZERO), "not taken over");
    app.stop();
}

fn r7_an_actuator_that_is_taken_over_receives_no_neutral_command(executor: Executor) {
    let scenario = Scenario::new();
    let first = switch(true);
    scenario.drives("first", &first, 0.3);
    scenario.drives("second", &switch(true), 0.2);
    let body = PAIR.replace("arm = \"robot.reach\"", "base = \"robot.velocity\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.3");
    let command = app.handle.board().get("robot.velocity").expect("a command");
    let (values, reader) = (
        Arc::new(Mutex::new(Vec::new())),
        Mutex::new(command.reader("test")),
    );
    let recorder = Arc::clone(&values);
    let watch = command.watch(move || {
        let mut reader = reader.lock();
        let bytes = reader.latch(0).expect("it was published").bytes.to_vec();
        reader.release();
        recorder.lock().push(bytes);
    });
    first.store(false, SeqCst);
    app.until_line("robot velocity 0.2");
    drop(watch);
    let neutral = jde_types::Value::as_bytes(&Twist::ZERO).to_vec();
    assert!(!values.lock().contains(&neutral));
    app.stop();
}

fn r7_a_command_that_the_winner_does_not_write_in_its_first_iteration_becomes_neutral(executor: Executor) {
    let scenario = Scenario::new();
    let first = switch(true);
    scenario.drives("first", &first, 0.3);
    let second = switch(false);
    let found = record_velocity(&scenario, "second", &second);
    let body = PAIR.replace("arm = \"robot.reach\"", "base = \"robot.velocity\"");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot velocity 0.3");
    second.store(true, SeqCst);
    app.until(|app| app.schema("second").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| found.lock().len() > 1);
    assert_eq!(found.lock()[..2], [0.3, 0.0]);
    app.until_line("robot velocity 0");
    app.stop();
}
