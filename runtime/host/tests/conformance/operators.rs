//! An operator's actions are reported as such, and undone when the operator releases them (R14).

use std::sync::Arc;

use jde_board::value::Value;
use jde_core::{SchemaId, State};
use jde_host::OperatorHandle;
use jde_records::event::{Event, Occurrence, OperatorAction, What};
use jde_records::snapshot::SchemaView;
use jde_types::Twist;

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r14_a_schema_that_is_stopped_sleeps_until_it_is_released,
    r14_a_father_may_wake_a_child_that_is_stopped,
    r14_a_schema_that_is_forced_wins_until_it_is_released,
    r14_a_child_that_is_played_is_awake_until_it_is_released,
    r14_a_release_restores_the_period,
    r14_a_release_restores_a_modulation_unless_a_father_has_written_it_since,
    r14_a_release_undoes_nothing_of_other_operators,
    r14_a_lease_that_ends_leaves_a_lasting_stop,
    r14_a_lease_ends_no_stop_of_others,
    r14_the_value_of_a_lease_gives_way_to_the_one_before,
    r14_a_stop_names_the_awake_schemas_that_lose_a_value,
    r14_after_a_stop_of_everything_sensors_are_awake_and_commands_neutral,
    r14_requests_about_unknown_items_are_refused_with_a_reason,
);

const APP: &str = r#"
    roots = ["high", "father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.father]
    type = "test/motor"
    gain = 0.5
    children = { a = "left" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn hold_text(view: &SchemaView) -> Option<String> {
    let hold = view.operator.as_ref()?;
    Some(format!("{} by {}", hold.kind.word(), hold.by))
}

fn start(executor: Executor, high: bool) -> TestApp {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(high.into()), 0.3);
    scenario.drives("left", &Arc::new(true.into()), 0.1);
    scenario.on_call("father", |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    let first = if high { "high iterate" } else { "father iterate" };
    app.until_line(first);
    app
}

fn r14_a_schema_that_is_stopped_sleeps_until_it_is_released(executor: Executor) {
    let mut app = start(executor, true);
    let high = app.index("high");
    app.operator().hold_asleep(high).expect("it can be stopped");
    app.until_line("high sleep");
    app.until_line("father iterate");
    let view = app.schema("high");
    assert_eq!(
        (view.state, hold_text(&view).as_deref()),
        (State::Slept, Some("stopped by ana@laptop"))
    );
    assert!(app.scenario.has_event(|event| matches!(event.what(), Some(What::Operator { by, action: OperatorAction::Stop { .. }, .. }) if by == "ana@laptop"
    )));
    let before = app.scenario.count("high iterate");
    app.operator().release(high).expect("it can be released");
    app.until(|app| app.scenario.count("high iterate") > before);
    assert_eq!(app.schema("high").operator, None);
    app.stop();
}

fn r14_a_father_may_wake_a_child_that_is_stopped(executor: Executor) {
    let mut app = start(executor, false);
    app.scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => drop(io.wake("a")),
            _ => {}
        }
        Ok(())
    });
    app.until_line("left iterate");
    let left = app.index("left");
    app.operator().hold_asleep(left).expect("it can be stopped");
    app.until_line("left sleep");
    let before = app.scenario.count("father iterate");
    app.until(|app| app.scenario.count("father iterate") > before + 3);
    assert_eq!(app.schema("father").refused, 0);
    assert!(
        !app.scenario
            .has_event(|event| matches!(event.what(), Some(What::Refused { .. })))
    );
    let before = app.scenario.count("left iterate");
    app.operator().release(left).expect("it can be released");
    app.until(|app| app.scenario.count("left iterate") > before);
    app.stop();
}

fn r14_a_schema_that_is_forced_wins_until_it_is_released(executor: Executor) {
    let mut app = start(executor, false);
    let high = app.index("high");
    app.operator().force(high).expect("it can be forced");
    app.until_line("robot velocity 0.3");
    assert_eq!(app.winner("roots").as_deref(), Some("high"));
    assert_eq!(
        hold_text(&app.schema("high")).as_deref(),
        Some("forced by ana@laptop")
    );
    app.operator().release(high).expect("it can be released");
    app.until(|app| app.winner("roots").as_deref() == Some("father"));
    assert_eq!(app.schema("high").operator, None);
    app.stop();
}

fn r14_a_child_that_is_played_is_awake_until_it_is_released(executor: Executor) {
    let mut app = start(executor, false);
    let left = app.index("left");
    app.operator().play(left).expect("it can be played");
    app.until_line("robot velocity 0.1");
    assert_eq!(
        hold_text(&app.schema("left")).as_deref(),
        Some("played by ana@laptop")
    );
    app.operator().release(left).expect("it can be released");
    app.until_line("left sleep");
    app.until_line("robot velocity 0");
    let view = app.schema("left");
    assert_eq!((view.state, view.operator), (State::Slept, None));
    app.stop();
}

fn r14_a_release_restores_the_period(executor: Executor) {
    let mut app = start(executor, false);
    let father = app.index("father");
    app.operator().set_period(father, 3 * MS).expect("a period");
    app.operator().set_period(father, 2 * MS).expect("a period");
    app.until(|app| app.schema("father").period == 2 * MS);
    assert_eq!(
        hold_text(&app.schema("father")).as_deref(),
        Some("re-timed by ana@laptop")
    );
    assert!(app.scenario.has_event(
        |event| matches!(event.what(), Some(What::Operator { action: OperatorAction::Period { period, .. }, .. })
        if *period == 2 * MS)
    ));
    app.operator().release(father).expect("it can be released");
    app.until(|app| app.schema("father").period == 10 * MS);
    assert_eq!(app.schema("father").operator, None);
    app.stop();
}

fn r14_a_release_restores_a_modulation_unless_a_father_has_written_it_since(executor: Executor) {
    let mut app = start(executor, false);
    let [father, left] = ["father", "left"].map(|name| app.index(name));
    let gain = |app: &TestApp, name: &str| {
        app.handle
            .value::<f64>(&format!("{name}.gain"))
            .expect("a modulation")
    };
    app.operator()
        .modulate(father, "gain", &Value::Float(0.75))
        .expect("a modulation");
    assert_eq!(gain(&app, "father"), Some(0.75));
    assert_eq!(
        hold_text(&app.schema("father")).as_deref(),
        Some("modulated by ana@laptop")
    );
    app.operator().release(father).expect("it can be released");
    assert_eq!(gain(&app, "father"), Some(0.5));
    assert_eq!(app.schema("father").operator, None);

    app.operator()
        .modulate(left, "gain", &Value::Float(0.75))
        .expect("a modulation");
    app.scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.modulate_a(0.9);
            }
            _ => {}
        }
        Ok(())
    });
    app.until(|app| gain(app, "left") == Some(0.9));
    assert_eq!(app.schema("left").operator, None);
    app.operator().release(left).expect("it can be released");
    assert_eq!(gain(&app, "left"), Some(0.9));
    app.stop();
}

fn r14_a_release_undoes_nothing_of_other_operators(executor: Executor) {
    let mut app = start(executor, true);
    let (ana, bob) = (app.operator(), app.handle.operator("bob@base"));
    let high = app.index("high");
    let current = |app: &TestApp| hold_text(&app.schema("high"));
    let gain = |app: &TestApp| app.handle.value::<f64>("high.gain").expect("a modulation");
    let before = gain(&app);
    ana.modulate(high, "gain", &Value::Float(0.75))
        .expect("a modulation");
    bob.hold_asleep(high).expect("it can be stopped");
    bob.set_period(high, 20 * MS).expect("a period");
    assert_eq!(current(&app).as_deref(), Some("stopped by bob@base"));

    ana.release_own(high).expect("it has holds");
    assert_eq!(gain(&app), before);
    assert_eq!(current(&app).as_deref(), Some("stopped by bob@base"));
    let count_actions = |app: &TestApp, operator: &str| {
        app.scenario
            .count_events(|event| matches!(event.what(), Some(What::Operator { by, .. }) if by == operator))
    };
    assert_eq!(count_actions(&app, "ana@laptop"), 2);
    ana.release_own(high)
        .expect("a release without holds is accepted");
    assert_eq!(
        count_actions(&app, "ana@laptop"),
        2,
        "nothing was undone, so nothing is reported"
    );

    // An operator that overwrites another's value takes it over, and a release restores the value before both.
    ana.modulate(high, "gain", &Value::Float(0.25))
        .expect("a modulation");
    bob.modulate(high, "gain", &Value::Float(0.5))
        .expect("a modulation");
    ana.release_own(high)
        .expect("a release without holds is accepted");
    assert_eq!(gain(&app), Some(0.5));
    let iterated = app.scenario.count("high iterate");
    bob.release_own(high).expect("it has holds");
    assert_eq!((gain(&app), current(&app)), (before, None));
    app.until(|app| app.scenario.count("high iterate") > iterated);
    app.stop();
}

fn r14_a_lease_that_ends_leaves_a_lasting_stop(executor: Executor) {
    let mut app = start(executor, true);
    let high = app.index("high");
    let (ana, lease) = (app.operator(), app.operator().under_lease());
    ana.hold_asleep(high).expect("it can be stopped");
    lease.hold_asleep(high).expect("it can be stopped");
    app.until_line("high sleep");
    let all = |app: &TestApp| app.schema("high").held_by();
    assert_eq!(
        all(&app).as_deref(),
        Some("stopped by ana@laptop, stopped by ana@laptop")
    );
    lease.release_own(high).expect("it has holds");
    assert_eq!(app.schema("high").state, State::Slept);
    assert_eq!(all(&app).as_deref(), Some("stopped by ana@laptop"));
    // The other way round.
    lease.hold_asleep(high).expect("it can be stopped");
    app.handle.operator("bob").stop_all().expect("it runs");
    ana.release_all().expect("it runs");
    let before = app.scenario.count("high iterate");
    ana.play(high).expect("a deliberate play ends every stop");
    app.until(|app| app.scenario.count("high iterate") > before);
    assert_eq!(all(&app).as_deref(), Some("played by ana@laptop"));
    app.stop();
}

fn r14_a_lease_ends_no_stop_of_others(executor: Executor) {
    let mut app = start(executor, true);
    let high = app.index("high");
    let lease = app.handle.operator("bob").under_lease();
    let refused = |end: &str| {
        Err(format!(
            "`high` is stopped by ana@laptop, and an action with a lease does not end that: {end}"
        ))
    };
    app.operator().hold_asleep(high).expect("it can be stopped");
    let one = refused("`jde release high` ends that");
    assert_eq!([lease.play(high), lease.force(high)], [one.clone(), one]);
    app.operator().release(high).expect("it can be released");
    app.operator().stop_all().expect("it runs");
    let all = refused("`jde release --all` lets everything go on");
    assert_eq!([lease.play(high), lease.force(high)], [all.clone(), all]);
    lease.release_own(high).expect("it holds nothing");
    app.until_line("high sleep");
    assert_eq!(app.schema("high").state, State::Slept);
    let before = app.scenario.count("high iterate");
    app.operator().release_all().expect("it runs");
    app.until(|app| app.scenario.count("high iterate") > before);
    app.stop();
}

fn r14_the_value_of_a_lease_gives_way_to_the_one_before(executor: Executor) {
    let app = start(executor, true);
    let high = app.index("high");
    let gain = |app: &TestApp| app.handle.value::<f64>("high.gain").expect("a modulation");
    let initial = gain(&app);
    let (ana, lease) = (app.operator(), app.handle.operator("bob").under_lease());
    let write = |operator: &OperatorHandle, value| {
        operator
            .modulate(high, "gain", &Value::Float(value))
            .expect("a modulation");
    };
    write(&ana, 0.25);
    write(&lease, 0.5);
    assert_eq!(gain(&app), Some(0.5));
    lease.release_own(high).expect("it has holds");
    assert_eq!(gain(&app), Some(0.25), "ana's value is in force again");
    // The end of the one that is not in force changes nothing.
    write(&lease, 0.5);
    write(&ana, 0.75);
    lease.release_own(high).expect("it has holds");
    assert_eq!(gain(&app), Some(0.75));
    ana.release_own(high).expect("it has holds");
    assert_eq!((gain(&app), app.schema("high").held_by()), (initial, None));
    app.stop();
}

const SEEING: &str = r#"
    roots = ["high"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.high]
    type = "test/motor"
    imports = { input = "eye.out" }
    actuators = { base = "robot.velocity" }
"#;

fn start_seeing(executor: Executor) -> TestApp {
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(true.into()), 0.3);
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, SEEING);
    app.until_line("robot velocity 0.3");
    app
}

fn r14_a_stop_names_the_awake_schemas_that_lose_a_value(executor: Executor) {
    let app = start_seeing(executor);
    let [eye, high] = ["eye", "high"].map(|name| app.index(name));
    let losses = app.operator().stop(eye, false);
    assert_eq!(losses.as_deref(), Ok("high loses its input"));
    let again = app.operator().stop(eye, false);
    assert_eq!(again.as_deref(), Ok(""), "it is lost already");
    let lost = |event: &Event| match event {
        Event::Other(Occurrence {
            what: What::Operator { losses, .. },
            ..
        }) => losses.iter().any(|loss| loss.reader == high),
        _ => false,
    };
    assert_eq!(app.scenario.count_events(lost), 1);
    app.stop();
}

fn r14_after_a_stop_of_everything_sensors_are_awake_and_commands_neutral(executor: Executor) {
    let mut app = start_seeing(executor);
    app.operator().stop_all().expect("it runs");
    let seen = app.scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > seen + 3);
    assert_eq!(app.handle.value("robot.velocity"), Ok(Some(Twist::ZERO)));
    let states = ["high", "eye"].map(|name| app.schema(name).state);
    assert_eq!(states, [State::Slept, State::Winner]);
    // Its device is needed by nobody, once it is unloaded.
    let eye = app.index("eye");
    app.operator().unload(eye).expect("it can be unloaded");
    app.until_line("eye drop");
    app.operator().load(eye).expect("it is unloaded");
    let seen = app.scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > seen);
    app.operator().unload(app.index("high")).expect("a motor schema");
    app.until(|app| app.schema("eye").state == State::Slept);
    app.stop();
}

fn r14_requests_about_unknown_items_are_refused_with_a_reason(executor: Executor) {
    let app = start(executor, false);
    let operator = app.operator();
    let unknown = Err(String::from(
        "there is no schema number 99; the application has 4",
    ));
    let absent = SchemaId(99);
    assert_eq!(operator.set_period(absent, MS), unknown);
    assert_eq!(operator.modulate(absent, "gain", &Value::Float(1.0)), unknown);
    for refused in [
        operator.play(absent),
        operator.hold_asleep(absent),
        operator.force(absent),
        operator.release(absent),
    ] {
        assert!(refused.expect_err("there is none").contains("99"));
    }
    let father = app.index("father");
    assert_eq!(
        operator.set_period(father, 1),
        Err(String::from(
            "a period of 0.000000001 s is shorter than 100 us; give one from 100 us to a day"
        ))
    );
    let message = operator
        .modulate(father, "gian", &Value::Float(1.0))
        .expect_err("there is none");
    assert!(message.contains("gain"), "{message}");
    let message = operator
        .modulate(father, "gain", &Value::Float(f64::NAN))
        .expect_err("not finite");
    assert!(message.starts_with("`father.gain` stays as it is: "), "{message}");
    let message = operator
        .modulate(father, "mission", &Value::Float(1.0))
        .expect_err("an export");
    assert_eq!(
        message,
        "`father.mission` is not a modulation; only modulations can be set"
    );
    let robot = app.index("robot");
    assert!(operator.force(robot).is_err(), "a driver does not compete");
    app.stop();
}
