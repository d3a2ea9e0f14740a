//! Which schema wins, which may command, and which sleep (R1, R3, R5, R6, R7, R13).

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, OnceLock};

use jde_board::Variable;
use jde_core::{Case, State};
use jde_host::Options;
use jde_records::event::{Event, Observer, StateChange, What};
use parking_lot::Mutex;

use crate::common::{Call, Executor, Scenario, TestApp, in_languages, on_every_executor};

on_every_executor!(
    r1_only_the_current_winner_commands,
    r3_a_single_ready_schema_wins_without_arbitration,
    r3_r13_the_first_root_wins_a_collision,
    r13_the_roots_have_a_policy_like_any_group,
    r13_levels_of_roots_have_a_winner_each,
    r5_children_sleep_before_the_new_winner_acts,
    r5_awake_siblings_stay_awake,
    r6_a_driver_that_no_schema_needs_sleeps,
    r7_a_command_outside_authority_is_refused_and_counted,
    r7_a_father_without_authority_wakes_no_child,
);

in_languages!(Lockstep, [C Cpp Python]:
    r7_a_command_outside_authority_is_refused_and_counted,
    r7_a_father_without_authority_wakes_no_child,
);

const PAIR: &str = r#"
    roots = ["high", "low"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

const FAMILY: &str = r#"
    roots = ["high", "father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.legs]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.father]
    type = "test/motor"
    children = { a = "left", b = "right" }
    groups.base = { policy = "priority" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity", arm = "legs.reach" }
    [schemas.right]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn switch(on: bool) -> Arc<AtomicBool> {
    Arc::new(AtomicBool::new(on))
}

/// A father that wakes both its children in each iteration.
fn wakes_children(scenario: &Scenario, name: &str) {
    scenario.on_call(name, |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            _ => {}
        }
        Ok(())
    });
}

/// Records each new winner, and the newest sequence number of one command at that time.
struct Winners {
    variable: Arc<OnceLock<Arc<Variable>>>,
    changes: Arc<Mutex<Vec<(u64, u32)>>>,
}

impl Observer for Winners {
    fn on_event(&mut self, event: &Event) {
        if let (
            Event::State(StateChange {
                schema,
                to: State::Winner,
                ..
            }),
            Some(variable),
        ) = (event, self.variable.get())
        {
            // The previous winner has lost its authority by now, and this one does not have it yet.
            self.changes.lock().push((variable.newest(), schema.0));
        }
    }
}

fn r1_only_the_current_winner_commands(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &switch(true), 0.1);
    let checks = AtomicU64::new(0);
    scenario.on_call("high", move |call, io| {
        match call {
            Call::Check => io.ready(checks.fetch_add(1, SeqCst) % 4 < 2),
            // Five commands in a row, to provoke a late one.
            Call::Iterate => (0..5).for_each(|_| {
                io.command(0.3);
            }),
            _ => {}
        }
        Ok(())
    });
    let (variable, changes) = (Arc::default(), Arc::default());
    let winners = Winners {
        variable: Arc::clone(&variable),
        changes: Arc::clone(&changes),
    };
    let options = Options {
        observers: vec![Box::new(winners)],
        ..Options::default()
    };
    let body = PAIR.replace("\"test/motor\"", "\"test/motor\"\n period = \"1ms\"");
    let mut app = TestApp::start_with(executor, &scenario, &body, options);
    let [high, low] = ["high", "low"].map(|name| app.index(name).0);
    let command = app.handle.board().get("robot.velocity").expect("a command");
    let commands: Arc<Mutex<Vec<(u64, u32)>>> = Arc::default();
    let (recorder, reader) = (Arc::clone(&commands), Mutex::new(command.reader("test")));
    let watch = command.watch(move || {
        let mut reader = reader.lock();
        let stamp = reader.latch(0).expect("it was published").stamp;
        reader.release();
        recorder.lock().push((stamp.sequence, stamp.writer));
    });
    assert!(variable.set(command).is_ok());
    app.until(|_| changes.lock().len() > 100);
    app.stop();
    drop(watch);

    let changes = changes.lock();
    let mut checked = 0;
    for (sequence, writer) in commands.lock().iter().copied() {
        // A command with the recorded number was published before the change of the winner.
        let Some((_, winner)) = changes.iter().rfind(|(newest, _)| *newest < sequence) else {
            continue;
        };
        if writer == high || writer == low {
            assert_eq!(writer, *winner, "command {sequence}, winners {changes:?}");
            checked += 1;
        }
    }
    assert!(checked > 50, "{checked} commands");
}

fn r3_a_single_ready_schema_wins_without_arbitration(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("low", &switch(true), 0.1);
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.1");
    assert_eq!(app.winner("roots").as_deref(), Some("low"));
    let low = app.index("low");
    assert!(scenario.has_event(|event| matches!(event, Event::Decision(record)
        if record.case == Case::Alone && record.choice == Some(low))));
    assert!(!scenario.has_line("high iterate"));
    app.stop();
}

fn r3_r13_the_first_root_wins_a_collision(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &switch(true), 0.3);
    scenario.drives("low", &switch(true), 0.1);
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until(|app| {
        app.scenario
            .has_event(|event| matches!(event, Event::Decision(record) if record.case == Case::Collision))
    });
    app.until_line("robot velocity 0.3");
    assert_eq!(app.winner("roots").as_deref(), Some("high"));
    // `low` becomes READY after the end of its last iteration.
    app.until(|app| app.schema("low").state == State::Ready);
    app.stop();
}

fn r13_the_roots_have_a_policy_like_any_group(executor: Executor) {
    let scenario = Scenario::new();
    for (name, urgency) in [("high", 1.0), ("low", 2.0)] {
        scenario.on_call(name, move |call, io| {
            if call == Call::Check {
                io.ready(jde_schema::Precondition::from(true).urgency(urgency));
            }
            Ok(())
        });
    }
    let body = format!("root = {{ policy = \"urgency\" }}\n{PAIR}");
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| {
        app.winner("roots").as_deref() == Some("low") && app.schema("high").state == State::Ready
    });
    app.until_line("low iterate");
    app.stop();
}

fn r13_levels_of_roots_have_a_winner_each(executor: Executor) {
    let scenario = Scenario::new();
    let (high, low) = (switch(false), switch(true));
    scenario.drives("high", &high, 0.1);
    scenario.drives("low", &low, 0.2);
    scenario.drives("other", &switch(true), 0.3);
    let levels = r#"
        roots.one = { members = ["high", "low"], policy = "priority" }
        roots.two = { members = ["other"] }
        [schemas.legs]
        type = "test/robot"
        [schemas.other]
        type = "test/motor"
        actuators = { base = "legs.velocity" }"#;
    let body = PAIR.replace(r#"roots = ["high", "low"]"#, levels);
    let mut app = TestApp::start(executor, &scenario, &body);
    let wins = |app: &TestApp, name: &str| {
        app.winner("roots/one").as_deref() == Some(name)
            && app.winner("roots/two").as_deref() == Some("other")
    };
    app.until(|app| wins(app, "low") && app.schema("low").authority && app.schema("other").authority);
    high.store(true, SeqCst);
    scenario.notify();
    app.until(|app| wins(app, "high"));
    assert_eq!(
        app.group("roots/two").switches,
        1,
        "the other level has not changed"
    );
    app.stop();
    assert_eq!(scenario.count("other sleep"), 1, "it was awake all the time");
}

fn r5_children_sleep_before_the_new_winner_acts(executor: Executor) {
    let scenario = Scenario::new();
    let alarm = switch(false);
    wakes_children(&scenario, "father");
    scenario.drives("left", &switch(true), 0.1);
    scenario.drives("right", &switch(true), 0.2);
    let (ready, seen) = (Arc::clone(&alarm), Arc::new(Mutex::new(Vec::new())));
    let recorder = Arc::clone(&seen);
    scenario.on_call("high", move |call, io| {
        if call == Call::Check {
            io.ready(ready.load(SeqCst));
        }
        if let (Call::Iterate, Some(handle)) = (call, io.scenario.handle()) {
            let schemas = handle.snapshot().schemas.into_iter();
            recorder.lock().push(
                schemas
                    .map(|view| (view.name, view.state, view.authority))
                    .collect::<Vec<_>>(),
            );
            io.command(0.3);
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.1");
    alarm.store(true, SeqCst);
    app.until_line("robot velocity 0.3");
    let first = seen.lock()[0].clone();
    let state = |name: &str| first.iter().find(|(other, ..)| other == name).cloned().unwrap();
    assert_eq!(state("left"), ("left".into(), State::Slept, false));
    assert_eq!(state("right"), ("right".into(), State::Slept, false));
    assert!(matches!(
        state("father"),
        (_, State::Ready | State::Checking, false)
    ));
    assert_eq!(state("high"), ("high".into(), State::Winner, true));
    app.until_line("left sleep");
    app.until_line("right sleep");
    app.stop();
}

fn r5_awake_siblings_stay_awake(executor: Executor) {
    let scenario = Scenario::new();
    let alarm = switch(false);
    wakes_children(&scenario, "father");
    scenario.drives("left", &alarm, 0.1);
    scenario.drives("right", &switch(true), 0.2);
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.2");
    alarm.store(true, SeqCst);
    app.until_line("robot velocity 0.1");
    assert_eq!(app.schema("right").state, State::Ready);
    assert!(!scenario.has_line("right sleep"));
    app.stop();
}

fn r6_a_driver_that_no_schema_needs_sleeps(executor: Executor) {
    let scenario = Scenario::new();
    let alarm = switch(false);
    wakes_children(&scenario, "father");
    scenario.drives("left", &switch(true), 0.1);
    scenario.drives("high", &alarm, 0.3);
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until(|app| app.schema("legs").state == State::Winner && app.scenario.has_line("legs iterate"));
    alarm.store(true, SeqCst);
    app.until_line("legs sleep");
    assert_eq!(app.schema("legs").state, State::Slept);
    assert_eq!(app.schema("robot").state, State::Winner, "the roots need it");
    alarm.store(false, SeqCst);
    let before = scenario.count("legs awake");
    app.until(|app| app.scenario.count("legs awake") > before);
    app.stop();
}

fn r7_a_command_outside_authority_is_refused_and_counted(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &switch(true), 0.3);
    let acts = switch(false);
    let is_acting = Arc::clone(&acts);
    scenario.on_call("low", move |call, io| {
        if call == Call::Check && is_acting.load(SeqCst) {
            io.ready(true);
            // The schema is READY and not chosen: its command must be refused.
            let outcome = io.command(9.9);
            io.record(format!("{outcome:?}"));
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, PAIR);
    app.until_line("robot velocity 0.3");
    acts.store(true, SeqCst);
    app.until(|app| app.scenario.count("low Refused") > 5 && app.schema("low").refused > 5);
    assert_eq!(scenario.count("low Accepted"), 0);
    assert!(!scenario.has_line("robot velocity 9.9"));
    let low = app.index("low");
    let events = scenario.events();
    let reported = events.iter().filter(|event| {
        matches!(event.what(), Some(What::Refused { schema, description, .. })
        if *schema == low && description.starts_with("command `base` refused: "))
    });
    assert_eq!(reported.count(), 1, "a series of refusals is reported once");
    app.stop();
}

fn r7_a_father_without_authority_wakes_no_child(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("high", &switch(true), 0.3);
    let acts = switch(false);
    let is_acting = Arc::clone(&acts);
    scenario.on_call("father", move |call, io| {
        if call == Call::Check && is_acting.load(SeqCst) {
            io.ready(true);
            let outcome = io.wake("a");
            io.record(format!("{outcome:?}"));
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.3");
    acts.store(true, SeqCst);
    app.until(|app| app.scenario.count("father Refused") > 5 && app.schema("father").refused > 5);
    assert_eq!(scenario.count("father Accepted"), 0);
    assert!(!scenario.has_line("left awake"));
    let father = app.index("father");
    let events = scenario.events();
    let reported = events
        .iter()
        .filter(|event| matches!(event.what(), Some(What::Refused { schema, .. }) if *schema == father));
    assert_eq!(reported.count(), 1, "a series of refusals is reported once");
    app.stop();
}
