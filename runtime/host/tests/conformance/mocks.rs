//! Schemas whose functions a mock replaces: a father without its children, a child without its robot.

use jde_abi::describe::Plugin;
use jde_abi::inspect::Problem;
use jde_app::{Catalogue, Inspection, Unusable, load};
use jde_board::value::Value;
use jde_core::State;
use jde_host::{Mock, MockCatalogue, Options};
use jde_types::Value as _;
use std::path::PathBuf;
use std::sync::Arc;

use crate::common::{Call, Executor, MS, Scenario, TestApp, on_every_executor, plugins};

on_every_executor!(
    a_father_is_tried_without_its_children,
    a_child_is_tried_without_its_father_and_its_robot,
    r1_a_mock_competes_with_its_siblings_by_its_readiness,
    a_mock_that_was_unloaded_continues_after_a_load,
    a_program_sets_the_command_of_a_mock_while_it_runs,
);

const APP: &str = r#"
    roots = ["father"]
    [schemas.robot]
    type = "test/robot"
    [schemas.eye]
    type = "test/eye"
    [schemas.father]
    type = "test/motor"
    imports = { input = "eye.out" }
    children = { a = "left", b = "right" }
    [schemas.left]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
    [schemas.right]
    type = "test/motor"
    actuators = { base = "robot.velocity" }
"#;

fn forward(speed: f64) -> Option<Value> {
    let x = Value::Map(vec![("x".to_owned(), Value::Float(speed))]);
    Some(Value::Map(vec![("linear".to_owned(), x)]))
}

fn start(executor: Executor, scenario: &Arc<Scenario>, mocks: Vec<(&str, Mock)>) -> TestApp {
    let mocks = mocks.into_iter().map(|(name, mock)| (name.to_owned(), mock));
    let options = Options {
        mocks: mocks.collect(),
        ..Options::default()
    };
    TestApp::start_with(executor, scenario, APP, options)
}

fn a_father_is_tried_without_its_children(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                let seen = io.input().map(|(value, _)| value);
                io.record(format!("read {seen:?}"));
                io.wake("a");
            }
            _ => {}
        }
        Ok(())
    });
    let (mut eye, mut left) = (Mock::default(), Mock::default());
    eye.set("out", 0, Some(Value::Float(1.5)));
    left.set("base", 0, forward(0.4));
    let mut app = start(executor, &scenario, vec![("eye", eye), ("left", left)]);
    app.until_line("father read Some(1.5)");
    app.until_line("robot velocity 0.4");
    assert_eq!(app.winner("father/base").as_deref(), Some("left"));
    for mocked in ["eye", "left"] {
        assert!(
            !app.scenario.has_line(&format!("{mocked} awake")),
            "{mocked} is not called"
        );
    }
    app.stop();
}

fn a_child_is_tried_without_its_father_and_its_robot(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("left", &Arc::new(true.into()), 0.3);
    let mocks = vec![("father", Mock::default()), ("robot", Mock::default())];
    let mut app = start(executor, &scenario, mocks);
    app.until_line("left iterate");
    let commanded = |app: &TestApp| {
        let command: Option<jde_types::Twist> = app.handle.value("robot.velocity").expect("a command");
        command.is_some_and(|twist| twist.linear.x == 0.3)
    };
    app.until(commanded);
    assert_eq!(app.schema("father").state, State::Winner);
    // A mocked father wakes all its children, one after another.
    app.until(|app| app.schema("right").state != State::Slept);
    app.stop();
}

fn r1_a_mock_competes_with_its_siblings_by_its_readiness(executor: Executor) {
    let scenario = Scenario::new();
    scenario.drives("right", &Arc::new(true.into()), 0.1);
    let mut left = Mock::default();
    // Again and again, since a busy machine may miss a turn.
    for turn in 0..1000 {
        left.set_ready(turn * 100 * MS, turn % 2 == 1, 0.0);
    }
    left.set("base", 0, forward(0.4));
    let mut app = start(
        executor,
        &scenario,
        vec![("father", Mock::default()), ("left", left)],
    );
    for speed in ["0.1", "0.4", "0.1"] {
        let before = app.scenario.count(&format!("robot velocity {speed}"));
        app.until(|app| app.scenario.count(&format!("robot velocity {speed}")) > before);
    }
    app.stop();
}

fn a_mock_that_was_unloaded_continues_after_a_load(executor: Executor) {
    let scenario = Scenario::new();
    let mut left = Mock::default();
    left.set("base", 0, forward(0.4));
    let mut app = start(
        executor,
        &scenario,
        vec![("father", Mock::default()), ("left", left)],
    );
    app.until_line("robot velocity 0.4");
    let left = app.index("left");
    app.operator().unload(left).expect("a motor schema");
    app.until_line("robot velocity 0");
    let before = app.scenario.count("robot velocity 0.4");
    app.operator().load(left).expect("it is unloaded");
    app.until(|app| app.scenario.count("robot velocity 0.4") > before);
    app.stop();
}

fn a_program_sets_the_command_of_a_mock_while_it_runs(executor: Executor) {
    let scenario = Scenario::new();
    let mut left = Mock::default();
    let speed = left.live("base");
    let command = |x| jde_types::Twist::planar(x, 0.0);
    assert!(speed.set(command(0.4).as_bytes()).is_err(), "it has not started");
    let mut app = start(
        executor,
        &scenario,
        vec![("father", Mock::default()), ("left", left)],
    );
    for (x, line) in [(0.4, "robot velocity 0.4"), (0.2, "robot velocity 0.2")] {
        speed.set(command(x).as_bytes()).expect("a twist");
        app.until_line(line);
    }
    assert!(speed.set(&[0; 3]).is_err(), "a twist has more bytes");
    app.stop();
}

/// Runs an application whose eye is a mock in lockstep, and returns the value and its number at each of these
/// times, ns.
fn values_at<const N: usize>(eye: Mock, times: [u64; N]) -> [Option<(f64, u64)>; N] {
    let scenario = Scenario::new();
    scenario.drives("father", &Arc::new(true.into()), 0.0);
    let mut app = start(Executor::Lockstep, &scenario, vec![("eye", eye)]);
    times.map(|time| {
        app.advance(time);
        let variable = app.handle.board().get("eye.out").expect("it is an export");
        let value: Option<f64> = app.handle.value("eye.out").expect("it is an f64");
        value.map(|value| (value, variable.newest()))
    })
}

#[test]
fn a_script_is_in_force_until_its_next_entry() {
    let mut eye = Mock::default();
    // Not in the order of their times.
    eye.set("out", 60 * MS, Some(Value::Float(2.0)));
    eye.set("out", 20 * MS, Some(Value::Float(1.0)));
    eye.set("out", 80 * MS, None);
    let seen = values_at(eye, [15 * MS, 45 * MS, 75 * MS, 200 * MS]);
    assert_eq!(seen, [None, Some((1.0, 3)), Some((2.0, 6)), None]);
}

#[test]
fn a_recorded_value_is_published_once() {
    let mut eye = Mock::default();
    for (at, value) in [(20 * MS, 1.0_f64), (61 * MS, 2.0), (62 * MS, 3.0)] {
        eye.recorded("out", at, Some(value.to_ne_bytes().to_vec()));
    }
    eye.recorded("out", 150 * MS, None);
    let seen = values_at(eye, [15 * MS, 45 * MS, 100 * MS, 200 * MS]);
    assert_eq!(seen, [None, Some((1.0, 1)), Some((3.0, 2)), None]);
}

#[test]
fn a_mock_that_does_not_fit_is_refused_with_a_reason() {
    let set = |port: &str, value| {
        let mut mock = Mock::default();
        mock.set(port, 0, Some(value));
        mock
    };
    let mut short = Mock::default();
    short.recorded("out", 0, Some(vec![0; 4]));
    for (schema, mock, expected) in [
        ("ear", Mock::default(), "no such schema"),
        (
            "eye",
            set("in", Value::Float(1.0)),
            "it writes no port `in`, but out",
        ),
        ("eye", set("input", Value::Float(1.0)), "no port `input`"),
        ("eye", set("out", Value::Text("far".to_owned())), "`out`: "),
        ("eye", short, "a value of `out` is no std_msgs/msg/Float64"),
    ] {
        let options = Options {
            mocks: vec![(schema.to_owned(), mock)],
            ..Options::default()
        };
        let started = TestApp::try_start(Executor::Lockstep, &Scenario::new(), APP, options);
        let reason = started.err().expect("it does not start").to_string();
        let prefix = format!("the mock of schema `{schema}` cannot be used: ");
        assert!(
            reason.starts_with(&prefix) && reason.contains(expected),
            "{reason}"
        );
    }
}

/// A catalogue whose schemas find a problem whenever they inspect.
struct Strict<'c>(&'c dyn Catalogue);

impl Catalogue for Strict<'_> {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, Unusable> {
        let mut plugin = Plugin::clone(&*self.0.plugin(name, extra_dirs)?);
        for schema in &mut plugin.schemas {
            schema.inspects = true;
        }
        Ok(Arc::new(plugin))
    }

    fn inspect(&self, _: &Arc<Plugin>, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        Err(format!("{} is not plugged in", inspection.name))
    }

    fn type_names(&self) -> Vec<String> {
        self.0.type_names()
    }
}

#[test]
fn a_mocked_schema_inspects_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("app.toml");
    std::fs::write(&file, APP).expect("a file");
    let plugins = plugins();
    let strict = Strict(&plugins);
    let mocked = ["robot", "eye", "father", "left"].map(str::to_owned);
    let application = load(&file, &[], &MockCatalogue::new(&strict, mocked)).expect("no faults");
    let concerns = application
        .concerns
        .expect("the last schema inspects")
        .to_string();
    assert!(concerns.contains("right is not plugged in"), "{concerns}");
    assert!(!concerns.contains("robot is not plugged in"), "{concerns}");
}
