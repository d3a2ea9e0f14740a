//! Other builds of schemas that take over at run time: between two iterations (R10), as an operator's action
//! (R14), and never at the cost of the level.

mod trial;
mod walker;

use std::path::Path;
use std::sync::Arc;

use jde_abi::raw;
use jde_app::parse;
use jde_board::value::Value;
use jde_core::{Health, State};
use jde_host::Options;
use jde_host::reload::{PendingReload, ReloadOptions};
use jde_records::event::{Event, OperatorAction};
use jde_records::reload::{CarriedMemory, Replacement};

use crate::common::{Call, Executor, Rig, Stage, on_every_executor, plugins};
use walker::{CANNOT_SAVE, ORIGINAL, build};

on_every_executor!(
    r10_a_new_build_takes_over_between_two_iterations_and_the_level_hears_nothing_of_it,
    r14_a_reload_is_told_as_the_doing_of_whoever_asked_for_it,
    what_speaks_against_a_build_is_said_all_at_once_and_nothing_is_touched,
    a_modulation_that_the_file_sets_is_needed_be_it_at_its_default,
    a_build_that_remembers_nothing_begins_anew_and_so_does_one_that_is_to,
    the_numbers_of_a_build_are_its_own,
    a_schema_that_sleeps_is_reloaded_asleep,
    a_schema_that_had_faulted_comes_back_with_a_new_build,
    a_schema_that_is_unloaded_is_loaded_with_the_new_build,
    a_father_keeps_its_children_awake_while_another_build_takes_over,
    a_driver_lets_go_of_its_device_before_the_new_one_takes_it_and_the_command_stays_in_force,
    what_cannot_be_saved_stays_where_it_is,
    fifty_builds_take_over_from_each_other_without_a_stop,
);

const APP: &str = r#"
    roots = ["walker", "idle"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.walker]
    type = "walk/walker"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
    speed = "2 m/s"
    restart = { back-off = "10ms", limit = 1 }
    [schemas.idle]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn start_with(executor: Executor, original: &'static raw::Plugin, app: &str) -> Rig {
    let stage = Stage::new();
    stage.play("idle", |_, _| Ok(()));
    stage.play("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(4.0);
        }
        Ok(())
    });
    let mut plugins = plugins();
    plugins.link(original).expect("its tables are right");
    let text = crate::common::text(executor, &stage, app).replace(
        "\"walk/walker\"",
        &format!("\"walk/walker\"\nstage = {}", stage.number()),
    );
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    match Rig::run(executor, &stage, application, &plugins, Options::default()) {
        Ok(rig) => rig,
        Err(error) => panic!("{error}"),
    }
}

/// Starts the application, and runs until the walker has taken some steps.
fn start(executor: Executor) -> Rig {
    let mut rig = start_with(executor, ORIGINAL, APP);
    rig.until_did("walker 1 step 5");
    rig
}

/// Orders a build, and runs until the result is known.
fn reload(rig: &mut Rig, number: u32, how: ReloadOptions) -> Result<Replacement, String> {
    let walker = rig.place("walker");
    let order = rig
        .operator()
        .replace(walker, &build(number), how)
        .unwrap_or_else(|reasons| panic!("{reasons:#?}"));
    outcome(rig, &order)
}

fn outcome(rig: &mut Rig, order: &PendingReload) -> Result<Replacement, String> {
    rig.until(|_| order.outcome().is_some());
    order.outcome().expect("it was there")
}

/// The last step of one build, and the first of another.
fn steps(rig: &Rig, old: u32, new: u32) -> (u32, u32) {
    let lines = rig.stage.lines();
    let step = |line: &String, build: u32| {
        let number = line.strip_prefix(&format!("walker {build} step "))?;
        number.parse::<u32>().ok()
    };
    let last = lines.iter().filter_map(|line| step(line, old)).max();
    let first = lines.iter().filter_map(|line| step(line, new)).min();
    (
        last.expect("the old one walked"),
        first.expect("the new one walks"),
    )
}

/// The events since the first `since` that affect the level.
fn level_heard(rig: &Rig, since: usize) -> Vec<Event> {
    let walker = rig.place("walker");
    let mut events = rig.stage.events().split_off(since);
    events.retain(|event| match event {
        // On a loaded machine it may be late.
        Event::HealthChanged { schema, health, .. } => {
            *schema == walker && matches!(health, Health::Faulted(_))
        }
        Event::StateChanged { schema, .. } => *schema == walker,
        Event::Decided(record) => record.changed,
        _ => false,
    });
    events
}

fn undone(rig: &Rig) -> Vec<String> {
    let events = rig.stage.events().into_iter();
    let reasons = events.filter_map(|event| match event {
        Event::ReloadRolledBack { reason, .. } => Some(reason),
        _ => None,
    });
    reasons.collect()
}

fn r10_a_new_build_takes_over_between_two_iterations_and_the_level_hears_nothing_of_it(executor: Executor) {
    let mut rig = start(executor);
    let before = rig.stage.events().len();
    let takeover = reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried.map(|carried| carried.version), Some(1));
    assert!(takeover.gap.is_some(), "{takeover:?}");
    assert_eq!(takeover.notes, [""; 0]);
    let steps_then = rig.stage.lines().len();
    rig.until(|rig| rig.stage.lines().len() > steps_then + 5);
    let (last, first) = steps(&rig, 1, 2);
    assert_eq!(first, last + 1, "it goes on counting");
    let order: Vec<_> = [
        "walker 1 save",
        "walker 1 sleep",
        "walker 2 awake",
        "walker 2 restore",
    ]
    .iter()
    .map(|line| rig.stage.first(line))
    .collect();
    assert!(order.is_sorted(), "{:#?}", rig.stage.lines());
    assert!(rig.stage.last(&format!("walker 1 step {last}")) < order[0]);
    assert_eq!(
        level_heard(&rig, before).len(),
        0,
        "{:#?}",
        level_heard(&rig, before)
    );
    assert!(!rig.stage.did("robot velocity 0"), "it never stopped");
    assert_eq!(rig.see("walker").state, State::Winner);
    assert!(rig.see("walker").authority);
    assert_eq!(
        rig.handle.value::<f64>("walker.speed"),
        Ok(Some(2.0)),
        "variables stay"
    );
    rig.stop();
}

fn r14_a_reload_is_told_as_the_doing_of_whoever_asked_for_it(executor: Executor) {
    let mut rig = start(executor);
    let walker = rig.place("walker");
    assert_eq!(rig.see("walker").reload, None);
    let takeover = reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    let told = |event: &Event| {
        matches!(event, Event::Operator { by, action: OperatorAction::Reload { schema, .. }, .. }
            if by == "ana@laptop" && *schema == walker)
    };
    assert_eq!(rig.stage.count_events(told), 1);
    let reloaded =
        |event: &Event| matches!(event, Event::Reloaded { takeover: told, .. } if *told == takeover);
    assert_eq!(rig.stage.count_events(reloaded), 1);
    let view = rig.see("walker").reload.expect("it was reloaded");
    assert_eq!((view.reloads, view.on_trial, view.undone), (1, true, None));
    rig.stop();
}

fn what_speaks_against_a_build_is_said_all_at_once_and_nothing_is_touched(executor: Executor) {
    let mut rig = start(executor);
    let walker = rig.place("walker");
    let before = rig.stage.events().len();
    let operator = rig.operator();
    let reasons = |number| match operator.replace(walker, &build(number), ReloadOptions::default()) {
        Ok(_) => panic!("it does not fit"),
        Err(reasons) => reasons,
    };
    assert_eq!(
        reasons(10),
        [
            "the child `leg` is not optional, and no schema has its role in the application",
            "the import `input` is a std_msgs/msg/UInt32 now, and was a std_msgs/msg/Float64",
            "the modulation `speed` is in `rad/s` now, and was in `m/s`",
            "the import `more` is new and not optional, and the application does not bind it",
        ]
    );
    assert_eq!(
        reasons(12),
        ["the plugin has no type `walker` any more, only runner"]
    );
    assert_eq!(
        reasons(14),
        [
            "the import `input` is gone, and the application binds it to eye.out",
            "the modulation `speed` is gone, and the application sets it",
        ]
    );
    let lines = rig.stage.lines().len();
    rig.until(|rig| rig.stage.lines().len() > lines + 5);
    assert_eq!(level_heard(&rig, before).len(), 0);
    assert!(!rig.stage.did("walker 1 save"));
    assert_eq!(rig.see("walker").reload, None);
    rig.stop();
}

fn a_modulation_that_the_file_sets_is_needed_be_it_at_its_default(executor: Executor) {
    let gone = |app: &str| {
        let mut rig = start_with(executor, ORIGINAL, app);
        rig.until_did("walker 1 step 1");
        let walker = rig.place("walker");
        let reasons = rig
            .operator()
            .replace(walker, &build(14), ReloadOptions::default());
        rig.stop();
        reasons.err().unwrap_or_default().join("; ")
    };
    let default = gone(&APP.replace("2 m/s", "1 m/s"));
    assert!(
        default.contains("`speed` is gone, and the application sets it"),
        "{default}"
    );
    let unset = gone(&APP.replace("speed = \"2 m/s\"", ""));
    assert!(!unset.contains("speed"), "{unset}");
}

fn a_build_that_remembers_nothing_begins_anew_and_so_does_one_that_is_to(executor: Executor) {
    let mut rig = start(executor);
    let takeover = reload(&mut rig, 11, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried, None);
    rig.until_did("walker 11 step 1");
    let takeover = reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried, None, "the one before hands nothing on");
    rig.until_did("walker 2 step 1");
    let fresh = ReloadOptions {
        fresh: true,
        ..ReloadOptions::default()
    };
    let takeover = reload(&mut rig, 1, fresh).expect("it fits");
    assert_eq!(takeover.carried, None);
    rig.until(|rig| rig.stage.count("walker 1 step 1") == 2);
    rig.stop();
}

fn the_numbers_of_a_build_are_its_own(executor: Executor) {
    let mut rig = start(executor);
    let takeover = reload(&mut rig, 13, ReloadOptions::default()).expect("it fits");
    assert_eq!(
        takeover.notes,
        [
            "the child `leg` is new: no schema has its role until the application restarts",
            "the export `steps` is new: no schema reads it until the application restarts",
            "the modulation `speed` has a new default; the running value is kept (`jde set` changes it)",
            "the modulation `more` is new: it has its default until the application restarts",
            "the import `nothing` is new: it stays unbound until the application restarts",
        ]
    );
    rig.until_did("walker 13 sees (2.0, 7.0, false, Some(4.0), false)");
    rig.until_did("robot velocity 0.25");
    let walker = rig.place("walker");
    let operator = rig.operator();
    operator
        .modulate(walker, "speed", &Value::Float(6.0))
        .expect("a modulation");
    rig.until_did("walker 13 sees (6.0, 7.0, false, Some(4.0), false)");
    assert!(rig.handle.board().find("walker.steps").is_none());
    rig.stop();
}

fn a_schema_that_sleeps_is_reloaded_asleep(executor: Executor) {
    let mut rig = start(executor);
    let walker = rig.place("walker");
    let operator = rig.operator();
    operator.hold_asleep(walker).expect("it can be stopped");
    rig.until_did("walker 1 sleep");
    let takeover = reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.gap, None);
    assert!(takeover.carried.is_some());
    assert!(!rig.stage.did("walker 2 awake"));
    operator.release(walker).expect("it can be released");
    rig.until_did("walker 2 awake");
    let lines = rig.stage.lines().len();
    rig.until(|rig| {
        rig.stage.lines()[lines..]
            .iter()
            .any(|line| line.starts_with("walker 2 step"))
    });
    let (last, first) = steps(&rig, 1, 2);
    assert_eq!(first, last + 1);
    rig.stop();
}

fn a_schema_that_had_faulted_comes_back_with_a_new_build(executor: Executor) {
    let mut rig = start(executor);
    let how = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut rig, 3, how).expect("it fits");
    // It may be restarted once, and fails again.
    rig.until(|rig| rig.see("walker").faults == 2);
    rig.until(|rig| rig.stage.count("walker 3 drop") == 2);
    assert_eq!(rig.see("walker").state, State::Slept);
    reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    rig.until_did("walker 2 step 1");
    assert!(!matches!(rig.see("walker").health, Health::Faulted(_)));
    rig.stop();
}

fn a_schema_that_is_unloaded_is_loaded_with_the_new_build(executor: Executor) {
    let mut rig = start(executor);
    let walker = rig.place("walker");
    let operator = rig.operator();
    operator.unload(walker).expect("a motor schema");
    rig.until_did("walker 1 drop");
    reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    assert!(rig.stage.lines().iter().all(|line| !line.starts_with("walker 2")));
    operator.load(walker).expect("it is at rest");
    rig.until_did("walker 2 step 1");
    rig.stop();
}

/// The walker leads a motor schema of the test plugin.
fn a_father_keeps_its_children_awake_while_another_build_takes_over(executor: Executor) {
    let stage = Stage::new();
    stage.play("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
            }
            // A sleeping father leads no child.
            Call::Sleep => {
                io.child("a").sleep(io.cx());
            }
            Call::Awake | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    stage.drives("child", &Arc::new(true.into()), 0.5);
    let mut rig = Rig::start(
        executor,
        &stage,
        r#"
        roots = ["father"]
        [schemas.robot]
        type = "test/robot"
        [schemas.father]
        type = "test/motor"
        children = { a = "child" }
        [schemas.child]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#,
    );
    rig.until_did("robot velocity 0.5");
    let (father, child) = (rig.place("father"), rig.place("child"));
    let plugin = crate::common::plugins();
    let again = plugin.load("test", &[]).expect("it is linked in");
    let order = rig
        .operator()
        .replace(father, &again, ReloadOptions::default())
        .expect("it is the same");
    outcome(&mut rig, &order).expect("it takes over");
    let iterated = rig.stage.count("child iterate");
    rig.until(|rig| rig.stage.count("child iterate") > iterated + 5);
    assert_eq!(rig.stage.count("father awake"), 2);
    assert_eq!(rig.stage.count("child awake"), 1);
    let changed = |event: &Event| matches!(event, Event::StateChanged { schema, to: State::Slept, .. } if *schema == child);
    assert!(!rig.stage.told(changed));
    assert!(!rig.stage.did("robot velocity 0"));
    rig.stop();
}

fn a_driver_lets_go_of_its_device_before_the_new_one_takes_it_and_the_command_stays_in_force(
    executor: Executor,
) {
    let mut rig = start(executor);
    let before = rig.stage.events().len();
    let commanded = "robot velocity 0.5";
    rig.until_did(commanded);
    let robot = rig.place("robot");
    let again = plugins().load("test", &[]).expect("it is linked in");
    let order = rig
        .operator()
        .replace(robot, &again, ReloadOptions::default())
        .expect("it is the same");
    outcome(&mut rig, &order).expect("it takes over");
    // The new instance does not know the earlier commands, so it records what it finds in force.
    rig.until(|rig| rig.stage.count(commanded) == 2);
    let order = [
        rig.stage.first(commanded),
        rig.stage.first("robot sleep"),
        rig.stage.last("robot awake"),
        rig.stage.last(commanded),
    ];
    assert!(order.is_sorted(), "{:#?}", rig.stage.lines());
    assert_eq!(rig.stage.count("robot awake"), 2);
    assert!(!rig.stage.did("robot velocity 0"), "nobody braked");
    let heard = level_heard(&rig, before);
    assert!(heard.is_empty(), "the walker is WINNER throughout: {heard:#?}");
    rig.stop();
}

fn what_cannot_be_saved_stays_where_it_is(executor: Executor) {
    let mut rig = start_with(executor, CANNOT_SAVE, APP);
    rig.until_did("walker 9 step 5");
    let refused = reload(&mut rig, 2, ReloadOptions::default()).expect_err("it cannot be saved");
    assert!(
        refused.starts_with("the present build cannot save what it remembers: panicked"),
        "{refused}"
    );
    assert_eq!(rig.see("walker").faults, 0);
    let fresh = ReloadOptions {
        fresh: true,
        ..ReloadOptions::default()
    };
    reload(&mut rig, 2, fresh).expect("it begins anew");
    rig.until_did("walker 2 step 1");
    rig.stop();
}

fn fifty_builds_take_over_from_each_other_without_a_stop(executor: Executor) {
    let mut rig = start(executor);
    let before = rig.stage.events().len();
    for round in 0..50 {
        let number = 2 - round % 2;
        let takeover = reload(&mut rig, number, ReloadOptions::default()).expect("it fits");
        assert_eq!(
            takeover.carried.map(|CarriedMemory { version, .. }| version),
            Some(3 - number)
        );
        let lines = rig.stage.lines().len();
        let step = format!("walker {number} step");
        rig.until(|rig| {
            rig.stage.lines()[lines..]
                .iter()
                .any(|line| line.starts_with(&step))
        });
    }
    assert_eq!(
        level_heard(&rig, before).len(),
        0,
        "{:#?}",
        level_heard(&rig, before)
    );
    assert!(!rig.stage.did("robot velocity 0"), "it never stopped");
    let view = rig.see("walker").reload.expect("it was reloaded");
    assert_eq!(view.reloads, 50);
    // All instances have ended except two: the one that runs, and the one to go back to.
    let drops = rig.stage.count("walker 1 drop") + rig.stage.count("walker 2 drop");
    assert_eq!(drops, 49);
    let lines = rig.stage.lines().into_iter();
    let walked: Vec<u32> = lines
        .filter_map(|line| line.rsplit_once(" step ")?.1.parse().ok())
        .collect();
    assert_eq!(
        walked,
        (1..=walked.len() as u32).collect::<Vec<_>>(),
        "it counts on"
    );
    rig.stop();
}
