//! Which schema wins, which may command, and which sleep (R1, R3, R5, R6, R7, R13).

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, Mutex, OnceLock};

use jde_board::Variable;
use jde_core::{Case, State};
use jde_host::Options;
use jde_records::event::{Event, Observer};

use crate::common::{Call, Executor, Rig, Stage, on_every_executor};

on_every_executor!(
    r1_within_a_reign_only_its_winner_commands,
    r3_one_alone_wins_without_anybody_being_asked,
    r3_r13_the_first_root_wins_a_collision,
    r13_the_roots_have_a_policy_like_any_group,
    r13_levels_of_roots_have_a_winner_each,
    r5_children_sleep_before_the_new_winner_acts,
    r5_awake_siblings_are_left_alone,
    r6_a_driver_sleeps_when_nobody_needs_it,
    r7_a_command_outside_authority_is_refused_and_counted,
    r7_a_father_without_authority_wakes_nobody,
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
fn leads(stage: &Stage, name: &str) {
    stage.play(name, |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
}

/// Records the sequence number of one command at which each reign begins.
struct Reigns {
    variable: Arc<OnceLock<Arc<Variable>>>,
    begins: Arc<Mutex<Vec<(u64, u32)>>>,
}

impl Observer for Reigns {
    fn on_event(&mut self, event: &Event) {
        if let (
            Event::StateChanged {
                schema,
                to: State::Winner,
                ..
            },
            Some(variable),
        ) = (event, self.variable.get())
        {
            // The previous winner has lost its authority by now, and this one does not have it yet.
            self.begins
                .lock()
                .unwrap()
                .push((variable.newest(), *schema as u32));
        }
    }
}

fn r1_within_a_reign_only_its_winner_commands(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &switch(true), 0.1);
    let checks = AtomicU64::new(0);
    stage.play("high", move |call, io| {
        match call {
            Call::Check => io.ready(checks.fetch_add(1, SeqCst) % 4 < 2),
            // Five commands in a row, to provoke a late one.
            Call::Iterate => (0..5).for_each(|_| {
                io.command(0.3);
            }),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let (variable, begins) = (Arc::default(), Arc::default());
    let reigns = Reigns {
        variable: Arc::clone(&variable),
        begins: Arc::clone(&begins),
    };
    let options = Options {
        observers: vec![Box::new(reigns)],
        ..Options::default()
    };
    let body = PAIR.replace("\"test/motor\"", "\"test/motor\"\n period = \"1ms\"");
    let mut rig = Rig::start_with(executor, &stage, &body, options);
    let [high, low] = ["high", "low"].map(|name| rig.place(name) as u32);
    let command = rig.handle.board().get("robot.velocity").expect("a command");
    let commands: Arc<Mutex<Vec<(u64, u32)>>> = Arc::default();
    let (heard, reads) = (Arc::clone(&commands), Mutex::new(command.reader("test")));
    let watch = command.watch(move || {
        let mut reader = reads.lock().unwrap();
        let stamp = reader.latch().expect("it was published").stamp;
        reader.release();
        heard.lock().unwrap().push((stamp.sequence, stamp.writer));
    });
    assert!(variable.set(command).is_ok());
    rig.until(|_| begins.lock().unwrap().len() > 100);
    rig.stop();
    drop(watch);

    let begins = begins.lock().unwrap();
    let mut judged = 0;
    for (sequence, writer) in commands.lock().unwrap().iter().copied() {
        // A value with the number at which a reign begins was published before that reign.
        let Some((_, reigning)) = begins.iter().rfind(|(begin, _)| *begin < sequence) else {
            continue;
        };
        if writer == high || writer == low {
            assert_eq!(writer, *reigning, "command {sequence}, reigns {begins:?}");
            judged += 1;
        }
    }
    assert!(judged > 50, "{judged} commands");
}

fn r3_one_alone_wins_without_anybody_being_asked(executor: Executor) {
    let stage = Stage::new();
    stage.drives("low", &switch(true), 0.1);
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.1");
    assert_eq!(rig.winner("roots").as_deref(), Some("low"));
    let low = rig.place("low");
    assert!(stage.told(|event| matches!(event, Event::Decided(record)
        if record.case == Case::Alone && record.choice.map(|id| id.index()) == Some(low))));
    assert!(!stage.did("high iterate"));
    rig.stop();
}

fn r3_r13_the_first_root_wins_a_collision(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &switch(true), 0.3);
    stage.drives("low", &switch(true), 0.1);
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until(|rig| {
        rig.stage
            .told(|event| matches!(event, Event::Decided(record) if record.case == Case::Collision))
    });
    rig.until_did("robot velocity 0.3");
    assert_eq!(rig.winner("roots").as_deref(), Some("high"));
    // After the end of its last iteration.
    rig.until(|rig| rig.see("low").state == State::Ready);
    rig.stop();
}

fn r13_the_roots_have_a_policy_like_any_group(executor: Executor) {
    let stage = Stage::new();
    for (name, urgency) in [("high", 1.0), ("low", 2.0)] {
        stage.play(name, move |call, io| {
            if call == Call::Check {
                io.ready(jde_schema::Precondition::from(true).urgency(urgency));
            }
            Ok(())
        });
    }
    let body = format!("root = {{ policy = \"urgency\" }}\n{PAIR}");
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| rig.winner("roots").as_deref() == Some("low") && rig.see("high").state == State::Ready);
    rig.until_did("low iterate");
    rig.stop();
}

fn r13_levels_of_roots_have_a_winner_each(executor: Executor) {
    let stage = Stage::new();
    let (high, low) = (switch(false), switch(true));
    stage.drives("high", &high, 0.1);
    stage.drives("low", &low, 0.2);
    stage.drives("other", &switch(true), 0.3);
    let levels = r#"
        roots.one = { members = ["high", "low"], policy = "priority" }
        roots.two = { members = ["other"] }
        [schemas.legs]
        type = "test/robot"
        [schemas.other]
        type = "test/motor"
        actuators = { base = "legs.velocity" }"#;
    let body = PAIR.replace(r#"roots = ["high", "low"]"#, levels);
    let mut rig = Rig::start(executor, &stage, &body);
    let wins = |rig: &Rig, one: &str| {
        rig.winner("roots/one").as_deref() == Some(one) && rig.winner("roots/two").as_deref() == Some("other")
    };
    rig.until(|rig| wins(rig, "low") && rig.see("low").authority && rig.see("other").authority);
    high.store(true, SeqCst);
    stage.stir();
    rig.until(|rig| wins(rig, "high"));
    assert_eq!(
        rig.group("roots/two").switches,
        1,
        "the other level has nothing to do with it"
    );
    rig.stop();
    assert_eq!(stage.count("other sleep"), 1, "it was awake all the time");
}

fn r5_children_sleep_before_the_new_winner_acts(executor: Executor) {
    let stage = Stage::new();
    let alarm = switch(false);
    leads(&stage, "father");
    stage.drives("left", &switch(true), 0.1);
    stage.drives("right", &switch(true), 0.2);
    let (ready, seen) = (Arc::clone(&alarm), Arc::new(Mutex::new(Vec::new())));
    let sees = Arc::clone(&seen);
    stage.play("high", move |call, io| {
        if call == Call::Check {
            io.ready(ready.load(SeqCst));
        }
        if let (Call::Iterate, Some(handle)) = (call, io.stage.handle()) {
            let schemas = handle.snapshot().schemas.into_iter();
            sees.lock().unwrap().push(
                schemas
                    .map(|view| (view.name, view.state, view.authority))
                    .collect::<Vec<_>>(),
            );
            io.command(0.3);
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.1");
    alarm.store(true, SeqCst);
    rig.until_did("robot velocity 0.3");
    let first = seen.lock().unwrap()[0].clone();
    let state = |name: &str| first.iter().find(|(other, ..)| other == name).cloned().unwrap();
    assert_eq!(state("left"), ("left".into(), State::Slept, false));
    assert_eq!(state("right"), ("right".into(), State::Slept, false));
    assert!(matches!(
        state("father"),
        (_, State::Ready | State::Checking, false)
    ));
    assert_eq!(state("high"), ("high".into(), State::Winner, true));
    rig.until_did("left sleep");
    rig.until_did("right sleep");
    rig.stop();
}

fn r5_awake_siblings_are_left_alone(executor: Executor) {
    let stage = Stage::new();
    let alarm = switch(false);
    leads(&stage, "father");
    stage.drives("left", &alarm, 0.1);
    stage.drives("right", &switch(true), 0.2);
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.2");
    alarm.store(true, SeqCst);
    rig.until_did("robot velocity 0.1");
    assert_eq!(rig.see("right").state, State::Ready);
    assert!(!stage.did("right sleep"));
    rig.stop();
}

fn r6_a_driver_sleeps_when_nobody_needs_it(executor: Executor) {
    let stage = Stage::new();
    let alarm = switch(false);
    leads(&stage, "father");
    stage.drives("left", &switch(true), 0.1);
    stage.drives("high", &alarm, 0.3);
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until(|rig| rig.see("legs").state == State::Winner && rig.stage.did("legs iterate"));
    alarm.store(true, SeqCst);
    rig.until_did("legs sleep");
    assert_eq!(rig.see("legs").state, State::Slept);
    assert_eq!(rig.see("robot").state, State::Winner, "the roots need it");
    alarm.store(false, SeqCst);
    let before = stage.count("legs awake");
    rig.until(|rig| rig.stage.count("legs awake") > before);
    rig.stop();
}

fn r7_a_command_outside_authority_is_refused_and_counted(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &switch(true), 0.3);
    let gate = switch(false);
    let open = Arc::clone(&gate);
    stage.play("low", move |call, io| {
        if call == Call::Check && open.load(SeqCst) {
            io.ready(true);
            // READY and not chosen: its command must be refused.
            let outcome = io.command(9.9);
            io.say(format!("{outcome:?}"));
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, PAIR);
    rig.until_did("robot velocity 0.3");
    gate.store(true, SeqCst);
    rig.until(|rig| rig.stage.count("low Refused") > 5 && rig.see("low").refused > 5);
    assert_eq!(stage.count("low Accepted"), 0);
    assert!(!stage.did("robot velocity 9.9"));
    let low = rig.place("low");
    let told = stage.events();
    let told = told.iter().filter(|event| {
        matches!(event, Event::Refused { schema, description, .. }
        if *schema == low && description.starts_with("command `base` refused: "))
    });
    assert_eq!(told.count(), 1, "a row of refusals is told once");
    rig.stop();
}

fn r7_a_father_without_authority_wakes_nobody(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &switch(true), 0.3);
    let gate = switch(false);
    let open = Arc::clone(&gate);
    stage.play("father", move |call, io| {
        if call == Call::Check && open.load(SeqCst) {
            io.ready(true);
            let outcome = io.wake("a");
            io.say(format!("{outcome:?}"));
        }
        Ok(())
    });
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.3");
    gate.store(true, SeqCst);
    rig.until(|rig| rig.stage.count("father Refused") > 5 && rig.see("father").refused > 5);
    assert_eq!(stage.count("father Accepted"), 0);
    assert!(!stage.did("left awake"));
    let father = rig.place("father");
    let events = stage.events();
    let told = events
        .iter()
        .filter(|event| matches!(event, Event::Refused { schema, .. } if *schema == father));
    assert_eq!(told.count(), 1, "a row of refusals is told once");
    rig.stop();
}
