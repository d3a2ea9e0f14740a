//! Guards of commands (R18): what they refuse does not take effect, and the next candidate acts.

use std::path::Path;
use std::sync::Arc;

use jde_app::parse;
use jde_core::{Cause, State};
use jde_host::Options;
use jde_loader::SearchPath;
use jde_records::event::{Event, What};
use jde_records::{Decision, DecisionTracker};
use parking_lot::Mutex;

use crate::common::{
    Call, Executor, MS, Scenario, TestApp, c, in_languages, on_every_executor, plugins_with, text,
};

on_every_executor!(
    r18_the_next_candidate_acts_instead_of_a_refused_one,
    r18_a_refused_schema_may_try_again,
    r18_a_father_that_wakes_its_child_anew_ends_no_refusal,
    r18_without_a_state_every_command_is_refused,
    r18_a_judgement_that_panics_refuses,
    r18_a_command_in_force_ends_when_its_guard_refuses_it,
    r18_a_guard_that_does_not_run_refuses_everything,
    r18_a_forced_schema_keeps_its_authority_and_its_commands_are_refused,
    r18_a_guard_in_c_judges_as_one_in_rust_does,
    r18_a_limited_command_takes_effect_and_its_schema_stays_ready,
    r18_a_command_in_force_is_limited_by_a_new_state,
    r18_a_command_of_zero_is_judged,
    r7_no_command_exceeds_the_limits_of_its_driver,
    r18_a_longer_period_of_the_guard_does_not_lengthen_its_state,
    r18_a_state_is_as_old_as_the_oldest_value_that_it_was_made_of,
);

// A guard judges in the host's process and in microseconds, so none is in Python: the package refuses the class.
in_languages!(Lockstep, [C Cpp]:
    r18_the_next_candidate_acts_instead_of_a_refused_one,
    r18_without_a_state_every_command_is_refused,
    r18_a_judgement_that_panics_refuses,
    r18_a_limited_command_takes_effect_and_its_schema_stays_ready,
    r18_a_command_in_force_is_limited_by_a_new_state,
);

pub(crate) const TWO: &str = r#"
    roots = ["high", "low"]
    root = { guard = "eye", retry = "50ms" }
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

/// What the guard exports as its limit in each iteration; it retracts its value if there is none.
pub(crate) type Limit = Arc<Mutex<Option<f64>>>;

/// Starts the two schemas: `high` drives at 0.5 m/s and `low` at 0.1 m/s, if it is to be ready.
fn start(executor: Executor, limit: Option<f64>, low: bool) -> (Arc<Scenario>, Limit, TestApp) {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, limit);
    scenario.drives("high", &Arc::new(true.into()), 0.5);
    scenario.drives("low", &Arc::new(low.into()), 0.1);
    let app = TestApp::start(executor, &scenario, TWO);
    (scenario, limit, app)
}

pub(crate) fn guarded(scenario: &Scenario, limit: Option<f64>) -> Limit {
    let limit = Arc::new(Mutex::new(limit));
    let state = Arc::clone(&limit);
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            match *state.lock() {
                Some(limit) => io.publish(limit),
                None => io.retract(),
            }
        }
        Ok(())
    });
    limit
}

fn r18_the_next_candidate_acts_instead_of_a_refused_one(executor: Executor) {
    let (scenario, _, mut app) = start(executor, Some(0.2), true);
    app.until_line("robot velocity 0.1");
    let before = scenario.count("robot iterate");
    app.until(|app| app.scenario.count("robot iterate") > before + 20);
    assert!(
        !scenario.has_line("robot velocity 0.5"),
        "a refused command took effect"
    );
    // On a busy machine the state may be too old at times, so the robot brakes.
    assert!(
        executor != Executor::Lockstep || !scenario.has_line("robot velocity 0"),
        "the robot braked between two candidates"
    );
    let application = app.handle.application().clone();
    app.stop();
    let mut tracker = DecisionTracker::new(&application);
    let decisions: Vec<_> = scenario
        .events()
        .iter()
        .flat_map(|event| tracker.process(event))
        .collect();
    let cause = "high: command refused by the guard `eye`: 0.5 m/s, and at most 0.2 m/s are safe";
    let is_next = |decision: &Decision| decision.cause == cause && decision.choice.as_deref() == Some("low");
    let next = decisions.iter().find(|decision| is_next(decision));
    let refused = next.map(|next| next.refused.as_slice());
    let reason = "command refused by the guard `eye`: 0.5 m/s, and at most 0.2 m/s are safe";
    assert!(
        matches!(refused, Some([refused]) if refused.name == "high" && refused.reason == reason && (0.0..=0.05).contains(&refused.left_s)),
        "{decisions:#?}"
    );
}

fn r18_a_refused_schema_may_try_again(executor: Executor) {
    let (_, limit, mut app) = start(executor, Some(0.2), true);
    app.until_line("robot velocity 0.1");
    *limit.lock() = Some(1.0);
    app.until_line("robot velocity 0.5");
    app.stop();
}

const ANEW: &str = r#"
    roots = ["father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.father]
    type = "test/motor"
    children = { a = "left" }
    groups.base = { guard = "eye", retry = "1000s" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn r18_a_father_that_wakes_its_child_anew_ends_no_refusal(executor: Executor) {
    let scenario = Scenario::new();
    guarded(&scenario, Some(0.2));
    scenario.drives("left", &Arc::new(true.into()), 0.5);
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.sleep("a");
                io.wake("a");
            }
            _ => {}
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, ANEW);
    app.until(|app| app.schema("left").refused > 0);
    let before = scenario.count("father iterate");
    app.until(|app| app.scenario.count("father iterate") > before + 10);
    let refused = app
        .scenario
        .count_events(|event| matches!(event.what(), Some(What::Refused { .. })));
    assert_eq!(refused, 1, "it tried again before its retry");
    app.stop();
}

fn r18_without_a_state_every_command_is_refused(executor: Executor) {
    let (scenario, limit, mut app) = start(executor, None, false);
    app.until(|app| app.schema("high").refused > 1);
    assert!(!scenario.has_line("robot velocity 0.5"));
    *limit.lock() = Some(1.0);
    app.until_line("robot velocity 0.5");
    app.stop();
}

fn r18_a_judgement_that_panics_refuses(executor: Executor) {
    let (scenario, _, mut app) = start(executor, Some(f64::NAN), false);
    let panicked = |event: &Event| {
        matches!(event.what(), Some(What::Refused { description, .. })
            if description.contains("the judgement failed: ") && description.contains("a limit is a number"))
    };
    app.until(|app| app.scenario.has_event(panicked));
    app.stop();
    assert!(!scenario.has_line("robot velocity 0.5"));
}

fn r18_a_command_in_force_ends_when_its_guard_refuses_it(executor: Executor) {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, Some(1.0));
    commands_once(&scenario, 0.5);
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("robot velocity 0.5");
    *limit.lock() = Some(0.2);
    app.until_line("robot velocity 0");
    let refused =
        |event: &Event| matches!(event, Event::Decision(record) if matches!(record.cause, Cause::Refused(_)));
    app.until(|app| app.scenario.has_event(refused));
    app.stop();
}

fn r18_a_guard_that_does_not_run_refuses_everything(executor: Executor) {
    let (_, _, mut app) = start(executor, Some(1.0), false);
    app.until_line("robot velocity 0.5");
    app.operator()
        .hold_asleep(app.index("eye"))
        .expect("the guard stops");
    app.until_line("robot velocity 0");
    let ended = |event: &Event| matches!(event.what(), Some(What::Refused { description, .. }) if description.contains("the guard has no state"));
    app.until(|app| app.scenario.has_event(ended));
    assert_eq!(app.schema("eye").state, State::Slept);
    app.stop();
}

fn r18_a_forced_schema_keeps_its_authority_and_its_commands_are_refused(executor: Executor) {
    let (scenario, _, mut app) = start(executor, Some(0.2), true);
    app.until_line("robot velocity 0.1");
    app.operator().force(app.index("high")).expect("it is forced");
    app.until(|app| app.winner("roots").as_deref() == Some("high"));
    let now = app.handle.now();
    app.until(|app| app.handle.now() > now + 200 * MS);
    assert_eq!(app.winner("roots").as_deref(), Some("high"));
    assert!(!scenario.has_line("robot velocity 0.5"));
    app.stop();
}

fn r18_a_guard_in_c_judges_as_one_in_rust_does(executor: Executor) {
    let folder = tempfile::tempdir().expect("a folder");
    c::build("limit.c", &[], &folder.path().join("liblimit.so"));
    let mut path = SearchPath::default();
    path.push(folder.path(), "of this test");
    let plugins = plugins_with(path);
    let scenario = Scenario::new();
    scenario.drives("high", &Arc::new(true.into()), 0.5);
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    let text = text(executor, &scenario, &TWO.replace("test/eye", "limit/limit"));
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let mut app = TestApp::run(executor, &scenario, application, &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    app.until_line("robot velocity 0.1");
    let refused = |event: &Event| matches!(event.what(), Some(What::Refused { description, .. }) if description.ends_with("by the guard `eye`: at most 0.2 m/s"));
    app.until(|app| app.scenario.has_event(refused));
    app.stop();
    assert!(!scenario.has_line("robot velocity 0.5"));
}

fn limited(event: &Event) -> bool {
    matches!(event.what(), Some(What::Limited { description, .. })
        if description == "command limited by the guard `eye`: 0.5 m/s, and at most 0.35 m/s are safe")
}

fn r18_a_limited_command_takes_effect_and_its_schema_stays_ready(executor: Executor) {
    let (scenario, _, mut app) = start(executor, Some(0.35), true);
    app.until_line("robot velocity 0.35");
    let before = scenario.count("robot iterate");
    app.until(|app| app.scenario.count("robot iterate") > before + 20);
    assert!(!scenario.has_line("robot velocity 0.5"));
    // On a busy machine the state may be too old at times, so the schema is refused.
    if executor == Executor::Lockstep {
        assert_eq!(app.winner("roots").as_deref(), Some("high"));
        assert_eq!(app.schema("high").refused, 0);
        assert_eq!(scenario.count_events(limited), 1, "it is said once");
    }
    app.stop();
}

fn r18_a_command_in_force_is_limited_by_a_new_state(executor: Executor) {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, Some(1.0));
    commands_once(&scenario, 0.5);
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until_line("robot velocity 0.5");
    *limit.lock() = Some(0.35);
    app.until_line("robot velocity 0.35");
    app.stop();
}

/// `high` commands once; the command is in force for 1000 s.
pub(crate) fn commands_once(scenario: &Scenario, speed: f64) {
    let mut commanded = false;
    scenario.on_call("high", move |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        if call == Call::Iterate && !commanded {
            commanded = io.command(speed).accepted();
        }
        Ok(())
    });
}

fn r18_a_command_of_zero_is_judged(executor: Executor) {
    let scenario = Scenario::new();
    guarded(&scenario, Some(-0.5));
    scenario.drives("high", &Arc::new(true.into()), 0.0);
    let mut app = TestApp::start(executor, &scenario, TWO);
    let zero = |event: &Event| matches!(event.what(), Some(What::Refused { description, .. }) if description.contains(": 0 m/s"));
    app.until(|app| app.scenario.has_event(zero));
    app.stop();
}

fn r7_no_command_exceeds_the_limits_of_its_driver(executor: Executor) {
    let scenario = Scenario::new();
    guarded(&scenario, Some(0.5));
    scenario.drives("high", &Arc::new(true.into()), 1e30);
    let text = TWO.replace(
        "type = \"test/robot\"",
        "type = \"test/robot\"\nvelocity_limits = { linear = { x = 0.45 } }",
    );
    let mut app = TestApp::start(executor, &scenario, &text);
    app.until_line("robot velocity 0.45");
    let said = |event: &Event| matches!(event.what(), Some(What::Limited { description, .. }) if description == "command limited by `robot.velocity_limits`");
    app.until(|app| app.scenario.has_event(said));
    app.stop();
}

fn r18_a_longer_period_of_the_guard_does_not_lengthen_its_state(executor: Executor) {
    let (_, _, mut app) = start(executor, Some(1.0), false);
    app.until_line("robot velocity 0.5");
    app.operator()
        .set_period(app.index("eye"), 20_000 * MS)
        .expect("the period changes");
    app.until_line("robot velocity 0");
    let old = |event: &Event| matches!(event.what(), Some(What::Refused { description, .. }) if description.contains("the state of the guard is"));
    app.until(|app| app.scenario.has_event(old));
    app.stop();
}

fn r18_a_state_is_as_old_as_the_oldest_value_that_it_was_made_of(executor: Executor) {
    let scenario = Scenario::new();
    let text = TWO.replace(
        "[schemas.high]",
        "imports = { input = \"slow.out\" }\n[schemas.slow]\ntype = \"test/eye\"\nperiod = \"100s\"\n[schemas.high]",
    );
    scenario.on_call("slow", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    // It reads the value once more in each iteration, and exports its state as new.
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate && io.input().is_some() {
            io.publish(1.0);
        }
        Ok(())
    });
    scenario.drives("high", &Arc::new(true.into()), 0.5);
    let mut app = TestApp::start(executor, &scenario, &text);
    app.until_line("robot velocity 0.5");
    let board = app.handle.clone();
    let age = |name: &str| {
        let variable = board.board().find(name).expect("an export");
        variable.status(board.now()).age.expect("a value")
    };
    let before = scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > before + 3);
    let (source, state) = (age("slow.out"), age("eye.out"));
    assert!(state >= source, "{state} ns old, made of what is {source} ns old");
    app.stop();
}

#[test]
fn r18_a_driver_gets_a_turn_at_once_when_its_command_is_refused() {
    let scenario = Scenario::new();
    let limit = guarded(&scenario, Some(1.0));
    commands_once(&scenario, 0.5);
    let text = TWO.replace("type = \"test/robot\"", "type = \"test/robot\"\nperiod = \"10s\"");
    let mut app = TestApp::start(Executor::Lockstep, &scenario, &text);
    app.until_line("robot velocity 0.5");
    let before = app.handle.now();
    *limit.lock() = Some(0.2);
    app.until_line("robot velocity 0");
    let stopped = app.handle.now() - before;
    assert!(
        stopped <= 10 * MS,
        "a period of the guard, and it took {stopped} ns"
    );
    app.stop();
}
