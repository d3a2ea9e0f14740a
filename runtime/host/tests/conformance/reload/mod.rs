//! Reloads: another build of a schema takes over at run time, between two iterations (R10), as an operator's
//! action (R14), and without a selection in its level.

mod counter;
mod lists;
mod names;
mod trial;

use std::path::Path;
use std::sync::Arc;

use jde_abi::raw;
use jde_app::parse;
use jde_core::{Health, State};
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_records::event::{Event, Occurrence, OperatorAction, StateChange, What};
use jde_records::reload::{CarriedMemory, Replacement};

use crate::common::{Call, Executor, Language, Scenario, TestApp, in_languages, on_every_executor, plugins};
use counter::{CANNOT_SAVE, ORIGINAL, build};

on_every_executor!(
    r10_a_new_build_takes_over_between_two_iterations_without_a_selection,
    r14_a_reload_is_reported_as_an_action_of_its_operator,
    an_incompatible_build_is_refused_with_all_reasons_and_changes_nothing,
    a_modulation_that_the_file_sets_is_required_even_at_its_default,
    a_build_starts_fresh_without_a_memory_or_on_request,
    a_schema_that_sleeps_is_reloaded_asleep,
    a_faulted_schema_returns_with_a_new_build,
    a_schema_that_is_unloaded_is_loaded_with_the_new_build,
    a_father_keeps_its_children_awake_while_another_build_takes_over,
    a_driver_releases_its_device_before_the_new_build_opens_it_and_the_command_stays_in_force,
    a_build_that_cannot_save_its_memory_stays_in_use,
    fifty_reloads_do_not_stop_the_robot,
);

in_languages!(Lockstep, [C Cpp Python]:
    a_father_keeps_its_children_awake_while_another_build_takes_over,
    a_driver_releases_its_device_before_the_new_build_opens_it_and_the_command_stays_in_force,
);

const APP: &str = r#"
    roots = ["counter", "idle"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.counter]
    type = "counter/counter"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
    speed = "2 m/s"
    restart = { back-off = "10ms", limit = 1 }
    [schemas.idle]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn start_with(executor: Executor, original: &'static raw::Plugin, body: &str) -> TestApp {
    let scenario = Scenario::new();
    scenario.on_call("idle", |_, _| Ok(()));
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(4.0);
        }
        Ok(())
    });
    let mut plugins = plugins();
    plugins.link(original).expect("its tables are valid");
    let text = crate::common::text(executor, &scenario, body).replace(
        "\"counter/counter\"",
        &format!("\"counter/counter\"\nscenario = {}", scenario.number()),
    );
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    match TestApp::run(executor, &scenario, application, &plugins, Options::default()) {
        Ok(app) => app,
        Err(error) => panic!("{error}"),
    }
}

/// Starts the application, and runs until the counter has counted some steps.
fn start(executor: Executor) -> TestApp {
    let mut app = start_with(executor, ORIGINAL, APP);
    app.until_line("counter 1 step 5");
    app
}

/// Reloads the counter with a build, and runs until the result is known.
fn reload(app: &mut TestApp, number: u32, options: ReloadOptions) -> Result<Replacement, String> {
    let counter = app.index("counter");
    let reload = app
        .operator()
        .replace(counter, &build(number), options)
        .unwrap_or_else(|reasons| panic!("{reasons:#?}"));
    app.until_reloaded(&reload)
}

/// Returns the last step of one build and the first step of another.
fn steps(app: &TestApp, old: u32, new: u32) -> (u32, u32) {
    let lines = app.scenario.lines();
    let step = |line: &String, build: u32| {
        let number = line.strip_prefix(&format!("counter {build} step "))?;
        number.parse::<u32>().ok()
    };
    let last = lines.iter().filter_map(|line| step(line, old)).max();
    let first = lines.iter().filter_map(|line| step(line, new)).min();
    (
        last.expect("the old build counted"),
        first.expect("the new build counts"),
    )
}

/// Returns the events after the first `since` that affect the level.
fn level_events(app: &TestApp, since: usize) -> Vec<Event> {
    let counter = app.index("counter");
    let mut events = app.scenario.events().split_off(since);
    events.retain(|event| match event {
        // On a busy machine the schema may overrun.
        Event::Other(Occurrence {
            what: What::HealthChanged { schema, health, .. },
            ..
        }) => *schema == counter && matches!(health, Health::Faulted(_)),
        Event::State(StateChange { schema, .. }) => *schema == counter,
        Event::Decision(record) => record.changed,
        _ => false,
    });
    events
}

fn rollback_reasons(app: &TestApp) -> Vec<String> {
    let events = app.scenario.events().into_iter();
    let reasons = events.filter_map(|event| match event {
        Event::Other(Occurrence {
            what: What::ReloadRolledBack { reason, .. },
            ..
        }) => Some(reason),
        _ => None,
    });
    reasons.collect()
}

fn r10_a_new_build_takes_over_between_two_iterations_without_a_selection(executor: Executor) {
    let mut app = start(executor);
    let before = app.scenario.events().len();
    let takeover = reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried.map(|carried| carried.version), Some(1));
    assert!(takeover.gap.is_some(), "{takeover:?}");
    assert_eq!(takeover.notes, [""; 0]);
    let lines = app.scenario.lines().len();
    app.until(|app| app.scenario.lines().len() > lines + 5);
    let (last, first) = steps(&app, 1, 2);
    assert_eq!(first, last + 1, "the count continues");
    let order: Vec<_> = [
        "counter 1 save",
        "counter 1 sleep",
        "counter 2 awake",
        "counter 2 restore",
    ]
    .iter()
    .map(|line| app.scenario.first(line))
    .collect();
    assert!(order.is_sorted(), "{:#?}", app.scenario.lines());
    assert!(app.scenario.last(&format!("counter 1 step {last}")) < order[0]);
    assert_eq!(
        level_events(&app, before).len(),
        0,
        "{:#?}",
        level_events(&app, before)
    );
    assert!(
        !app.scenario.has_line("robot velocity 0"),
        "the robot never stopped"
    );
    assert_eq!(app.schema("counter").state, State::Winner);
    assert!(app.schema("counter").authority);
    assert_eq!(
        app.handle.value::<f64>("counter.speed"),
        Ok(Some(2.0)),
        "variables stay"
    );
    app.stop();
}

fn r14_a_reload_is_reported_as_an_action_of_its_operator(executor: Executor) {
    let mut app = start(executor);
    let counter = app.index("counter");
    assert_eq!(app.schema("counter").reload, None);
    let takeover = reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    let requested = |event: &Event| {
        matches!(event.what(), Some(What::Operator { by, action: OperatorAction::Reload { schema, .. }, .. })
            if by == "ana@laptop" && *schema == counter)
    };
    assert_eq!(app.scenario.count_events(requested), 1);
    let reloaded = |event: &Event| matches!(event.what(), Some(What::Reloaded { takeover: reported, .. }) if *reported == takeover);
    assert_eq!(app.scenario.count_events(reloaded), 1);
    let view = app.schema("counter").reload.expect("it was reloaded");
    assert_eq!((view.reloads, view.on_trial, view.undone), (1, true, None));
    app.stop();
}

fn an_incompatible_build_is_refused_with_all_reasons_and_changes_nothing(executor: Executor) {
    let mut app = start(executor);
    let counter = app.index("counter");
    let before = app.scenario.events().len();
    let operator = app.operator();
    let reasons = |number| match operator.replace(counter, &build(number), ReloadOptions::default()) {
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
        ["the plugin has no type `counter` any more, only other"]
    );
    assert_eq!(
        reasons(14),
        [
            "the import `input` is gone, and the application binds it to eye.out",
            "the modulation `speed` is gone, and the application sets it",
        ]
    );
    let lines = app.scenario.lines().len();
    app.until(|app| app.scenario.lines().len() > lines + 5);
    assert_eq!(level_events(&app, before).len(), 0);
    assert!(!app.scenario.has_line("counter 1 save"));
    assert_eq!(app.schema("counter").reload, None);
    app.stop();
}

fn a_modulation_that_the_file_sets_is_required_even_at_its_default(executor: Executor) {
    let reasons = |body: &str| {
        let mut app = start_with(executor, ORIGINAL, body);
        app.until_line("counter 1 step 1");
        let counter = app.index("counter");
        let refused = app
            .operator()
            .replace(counter, &build(14), ReloadOptions::default());
        app.stop();
        refused.err().unwrap_or_default().join("; ")
    };
    let default = reasons(&APP.replace("2 m/s", "1 m/s"));
    assert!(
        default.contains("`speed` is gone, and the application sets it"),
        "{default}"
    );
    let unset = reasons(&APP.replace("speed = \"2 m/s\"", ""));
    assert!(!unset.contains("speed"), "{unset}");
}

fn a_build_starts_fresh_without_a_memory_or_on_request(executor: Executor) {
    let mut app = start(executor);
    let takeover = reload(&mut app, 11, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried, None);
    app.until_line("counter 11 step 1");
    let takeover = reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.carried, None, "the previous build saves nothing");
    app.until_line("counter 2 step 1");
    let fresh = ReloadOptions {
        fresh: true,
        ..ReloadOptions::default()
    };
    let takeover = reload(&mut app, 1, fresh).expect("it fits");
    assert_eq!(takeover.carried, None);
    app.until(|app| app.scenario.count("counter 1 step 1") == 2);
    app.stop();
}

fn a_schema_that_sleeps_is_reloaded_asleep(executor: Executor) {
    let mut app = start(executor);
    let counter = app.index("counter");
    let operator = app.operator();
    operator.hold_asleep(counter).expect("it can be stopped");
    app.until_line("counter 1 sleep");
    let takeover = reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    assert_eq!(takeover.gap, None);
    assert!(takeover.carried.is_some());
    assert!(!app.scenario.has_line("counter 2 awake"));
    operator.release(counter).expect("it can be released");
    app.until_line("counter 2 awake");
    let lines = app.scenario.lines().len();
    app.until(|app| {
        app.scenario.lines()[lines..]
            .iter()
            .any(|line| line.starts_with("counter 2 step"))
    });
    let (last, first) = steps(&app, 1, 2);
    assert_eq!(first, last + 1);
    app.stop();
}

fn a_faulted_schema_returns_with_a_new_build(executor: Executor) {
    let mut app = start(executor);
    let options = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut app, 3, options).expect("it fits");
    // The schema is restarted once and fails again.
    app.until(|app| app.schema("counter").faults == 2);
    app.until(|app| app.scenario.count("counter 3 drop") == 2);
    assert_eq!(app.schema("counter").state, State::Slept);
    reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    app.until_line("counter 2 step 1");
    assert!(!matches!(app.schema("counter").health, Health::Faulted(_)));
    app.stop();
}

fn a_schema_that_is_unloaded_is_loaded_with_the_new_build(executor: Executor) {
    let mut app = start(executor);
    let counter = app.index("counter");
    let operator = app.operator();
    operator.unload(counter).expect("a motor schema");
    app.until_line("counter 1 drop");
    reload(&mut app, 2, ReloadOptions::default()).expect("it fits");
    assert!(
        app.scenario
            .lines()
            .iter()
            .all(|line| !line.starts_with("counter 2"))
    );
    operator.load(counter).expect("it is at rest");
    app.until_line("counter 2 step 1");
    app.stop();
}

fn a_father_keeps_its_children_awake_while_another_build_takes_over(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => drop(io.wake("a")),
            // A father that goes to sleep puts its child to sleep.
            Call::Sleep => drop(io.sleep("a")),
            _ => {}
        }
        Ok(())
    });
    scenario.drives("child", &Arc::new(true.into()), 0.5);
    let mut app = TestApp::start(
        executor,
        &scenario,
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
    app.until_line("robot velocity 0.5");
    let (father, child) = (app.index("father"), app.index("child"));
    let build = Language::of_test().build();
    let reload = app
        .operator()
        .replace(father, &build, ReloadOptions::default())
        .expect("it is the same build");
    app.until_reloaded(&reload).expect("it takes over");
    let iterated = app.scenario.count("child iterate");
    app.until(|app| app.scenario.count("child iterate") > iterated + 5);
    assert_eq!(app.scenario.count("father awake"), 2);
    assert_eq!(app.scenario.count("child awake"), 1);
    let changed = |event: &Event| matches!(event, Event::State(StateChange { schema, to: State::Slept, .. }) if *schema == child);
    assert!(!app.scenario.has_event(changed));
    assert!(!app.scenario.has_line("robot velocity 0"));
    app.stop();
}

fn a_driver_releases_its_device_before_the_new_build_opens_it_and_the_command_stays_in_force(
    executor: Executor,
) {
    let mut app = start(executor);
    let before = app.scenario.events().len();
    let command = "robot velocity 0.5";
    app.until_line(command);
    let robot = app.index("robot");
    let build = Language::of_test().build();
    let reload = app
        .operator()
        .replace(robot, &build, ReloadOptions::default())
        .expect("it is the same build");
    app.until_reloaded(&reload).expect("it takes over");
    // The new instance does not know the earlier commands, so it records the command in force.
    app.until(|app| app.scenario.count(command) == 2);
    let order = [
        app.scenario.first(command),
        app.scenario.first("robot sleep"),
        app.scenario.last("robot awake"),
        app.scenario.last(command),
    ];
    assert!(order.is_sorted(), "{:#?}", app.scenario.lines());
    assert_eq!(app.scenario.count("robot awake"), 2);
    assert!(!app.scenario.has_line("robot velocity 0"), "no group braked");
    let events = level_events(&app, before);
    assert!(events.is_empty(), "the counter is WINNER throughout: {events:#?}");
    app.stop();
}

fn a_build_that_cannot_save_its_memory_stays_in_use(executor: Executor) {
    let mut app = start_with(executor, CANNOT_SAVE, APP);
    app.until_line("counter 9 step 5");
    let refused = reload(&mut app, 2, ReloadOptions::default()).expect_err("it cannot be saved");
    assert!(
        refused.starts_with("the present build cannot save what it remembers: panicked"),
        "{refused}"
    );
    assert_eq!(app.schema("counter").faults, 0);
    let fresh = ReloadOptions {
        fresh: true,
        ..ReloadOptions::default()
    };
    reload(&mut app, 2, fresh).expect("it starts fresh");
    app.until_line("counter 2 step 1");
    app.stop();
}

fn fifty_reloads_do_not_stop_the_robot(executor: Executor) {
    let mut app = start(executor);
    let before = app.scenario.events().len();
    for round in 0..50 {
        let number = 2 - round % 2;
        let takeover = reload(&mut app, number, ReloadOptions::default()).expect("it fits");
        assert_eq!(
            takeover.carried.map(|CarriedMemory { version, .. }| version),
            Some(3 - number)
        );
        let lines = app.scenario.lines().len();
        let step = format!("counter {number} step");
        app.until(|app| {
            app.scenario.lines()[lines..]
                .iter()
                .any(|line| line.starts_with(&step))
        });
    }
    assert_eq!(
        level_events(&app, before).len(),
        0,
        "{:#?}",
        level_events(&app, before)
    );
    assert!(
        !app.scenario.has_line("robot velocity 0"),
        "the robot never stopped"
    );
    let view = app.schema("counter").reload.expect("it was reloaded");
    assert_eq!(view.reloads, 50);
    // All instances have ended except two: the current one and the previous one, which is kept for a rollback.
    let drops = app.scenario.count("counter 1 drop") + app.scenario.count("counter 2 drop");
    assert_eq!(drops, 49);
    let lines = app.scenario.lines().into_iter();
    let steps_counted: Vec<u32> = lines
        .filter_map(|line| line.rsplit_once(" step ")?.1.parse().ok())
        .collect();
    assert_eq!(
        steps_counted,
        (1..=steps_counted.len() as u32).collect::<Vec<_>>(),
        "the count continues"
    );
    app.stop();
}
