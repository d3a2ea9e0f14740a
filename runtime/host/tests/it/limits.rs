//! The limits on modulations (R8) are the same for files, options, fathers and operators. They hold for
//! numbers, booleans and choices, and for modulations that are read at awakening only.

use std::path::Path;

use jde_abi::raw;
use jde_app::{Override, parse};
use jde_board::value::Value;
use jde_core::SchemaId;
use jde_host::{Lockstep, Options};
use jde_loader::{Plugins, SearchPath};
use jde_schema::prelude::*;
use jde_types::Value as _;

/// The first instance of each application.
const FIRST: SchemaId = SchemaId(0);

/// How fast to drive.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
#[repr(u8)]
enum Gait {
    Slow,
    VeryFast,
}

/// Exports the values of its modulations.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Doer {
    /// The highest speed.
    #[modulation(default = 0.5, unit = "m/s", min = 0.0, max = 1.0)]
    fast: Modulation<f64>,
    /// On or off.
    #[modulation(default = false)]
    on: Modulation<bool>,
    /// The manner of driving.
    #[modulation(default = Gait::Slow)]
    gait: Modulation<Gait>,
    /// A value that is read at awakening only.
    #[modulation(default = 1.0, min = 0.0, fixed)]
    place: Modulation<f64>,
    /// The values of all modulations, as text.
    #[export]
    done: Export<Text<64>>,
}

impl Schema for Doer {
    fn iterate(&mut self, cx: &Context) -> Result {
        let (fast, on, gait) = (self.fast.get(cx), self.on.get(cx), self.gait.get(cx));
        let done = format!("{fast} {on} {gait:?} {}", self.place.get(cx));
        self.done.write(cx, Text::truncated(&done));
        Ok(())
    }
}

/// Sets valid and invalid modulations of its child and exports the outcomes.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Father {
    #[child(group = "base")]
    doer: Child,
    #[modulates(child = "doer", name = "fast")]
    fast: Modulates<f64>,
    #[modulates(child = "doer", name = "gait")]
    gait: Modulates<u8>,
    #[modulates(child = "doer", name = "on")]
    on: Modulates<bool>,
    #[modulates(child = "doer", name = "period")]
    period: Modulates<f64>,
    #[export]
    outcomes: Export<Text<128>>,
}

impl Schema for Father {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.doer.wake(cx);
        let outcomes = [
            self.fast.set(cx, 0.25),
            self.fast.set(cx, -1.0),
            self.fast.set(cx, 1.5),
            self.fast.set(cx, f64::NAN),
            self.gait.set(cx, 1),
            self.gait.set(cx, 2),
            self.on.set(cx, true),
            self.period.set(cx, -1.0),
        ];
        self.outcomes.write(cx, Text::truncated(&format!("{outcomes:?}")));
        Ok(())
    }
}

static LIMITS: raw::Plugin = jde_schema::plugin!("limits", "Limits.", [Doer, Father]);

const ALONE: &str = "roots = [\"doer\"]\n[schemas.doer]\ntype = \"limits/doer\"\n";

fn plugins() -> Plugins {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&LIMITS).expect("it is valid");
    plugins
}

fn start(text: &str, options: &[Override]) -> Result<Lockstep, String> {
    let plugins = plugins();
    let application =
        parse(text, Path::new("app.toml"), options, &plugins).map_err(|faults| faults.to_string())?;
    Lockstep::start(application, &plugins, Options::default()).map_err(|error| error.to_string())
}

fn text<const N: usize>(lockstep: &Lockstep, variable: &str) -> String {
    let mut reader = lockstep
        .handle()
        .board()
        .get(variable)
        .expect("it is declared")
        .reader("test");
    let bytes = reader.latch(0).expect("it has a value").bytes;
    Text::<N>::from_bytes(bytes).expect("a text").as_str().to_owned()
}

#[track_caller]
fn assert_refused(lines: &str, expected: &str) {
    match start(&format!("{ALONE}{lines}"), &[]) {
        Ok(_) => panic!("accepted instead of refused with: {expected}"),
        Err(error) => assert!(error.contains(expected), "{error}"),
    }
}

#[test]
fn r8_files_set_booleans_and_choices_by_name() {
    let mut lockstep = start(
        &format!("{ALONE}on = true\ngait = \"very-fast\"\nfast = 1\n"),
        &[],
    )
    .expect("it starts");
    lockstep.run_until(20_000_000);
    assert_eq!(text::<64>(&lockstep, "doer.done"), "1 true VeryFast 1");
    assert_refused(
        "gait = \"fast\"",
        "`gait` of schema `doer` is `fast`, which is not a choice",
    );
    assert_refused("gait = 1", "one of slow, very-fast");
    assert_refused("on = 1", "true or false");
    assert_refused("fast = -0.1", "is -0.1 m/s, and at least 0 m/s is allowed");
    assert_refused("fast = nan", "");
}

#[test]
fn r8_a_father_writes_within_the_limits_of_its_child() {
    let app = "roots = [\"father\"]\n[schemas.father]\ntype = \"limits/father\"\nchildren = { doer = \"doer\" }\n\
               [schemas.doer]\ntype = \"limits/doer\"\n";
    let mut lockstep = start(app, &[]).expect("it starts");
    lockstep.run_until(50_000_000);
    assert_eq!(
        text::<128>(&lockstep, "father.outcomes"),
        "[Accepted, OutOfRange, OutOfRange, NotFinite, Accepted, OutOfRange, Accepted, OutOfRange]"
    );
    assert_eq!(text::<64>(&lockstep, "doer.done"), "0.25 true VeryFast 1");
    let snapshot = lockstep.handle().snapshot();
    for schema in &snapshot.schemas {
        assert_eq!(schema.faults, 0, "a refused write is not a fault");
    }
    assert!(
        snapshot.schemas.iter().any(|schema| schema.refused > 0),
        "refusals are counted"
    );
}

#[test]
fn r8_an_operator_writes_within_the_limits_and_by_name() {
    let mut lockstep = start(ALONE, &[]).expect("it starts");
    lockstep.run_until(20_000_000);
    let handle = lockstep.handle();
    let ana = handle.operator("ana@laptop");
    let error = |name: &str, value: Value| ana.modulate(FIRST, name, &value).expect_err("it is refused");
    assert_eq!(
        error("fast", Value::Float(-1.0)),
        "`doer.fast` is -1 m/s, and at least 0 m/s is allowed"
    );
    assert!(error("gait", Value::UInt(2)).contains("one of slow, very-fast is allowed"));
    assert!(
        error("fast", Value::Float(f64::NAN)).contains("`doer.fast` stays as it is: the value is not finite")
    );
    ana.modulate(FIRST, "gait", &Value::Text(String::from("very-fast")))
        .expect("a choice");
    ana.modulate(FIRST, "on", &Value::Bool(true)).expect("a boolean");
    lockstep.run_until(40_000_000);
    assert_eq!(text::<64>(&lockstep, "doer.done"), "0.5 true VeryFast 1");
}

#[test]
fn r8_a_fixed_modulation_is_read_at_awakening_and_stays_until_the_schema_sleeps() {
    let mut lockstep = start(ALONE, &[]).expect("it starts");
    lockstep.run_until(20_000_000);
    let handle = lockstep.handle();
    let ana = handle.operator("ana@laptop");
    ana.modulate(FIRST, "place", &Value::Float(2.0))
        .expect("a fixed modulation may be written at any time");
    ana.modulate(FIRST, "fast", &Value::Float(0.75))
        .expect("in range");
    lockstep.run_until(60_000_000);
    assert_eq!(text::<64>(&lockstep, "doer.done"), "0.75 false Slow 1");
    ana.hold_asleep(FIRST).expect("it can be stopped");
    lockstep.run_until(80_000_000);
    ana.play(FIRST).expect("it can be played");
    lockstep.run_until(120_000_000);
    assert_eq!(text::<64>(&lockstep, "doer.done"), "0.75 false Slow 2");
}

#[test]
fn a_declared_budget_does_not_follow_the_period() {
    let text = format!("{ALONE}period = \"1s\"\n");
    let plugins = plugins();
    let budget = |text: &str| {
        parse(text, Path::new("app.toml"), &[], &plugins).map(|app| app.instances[FIRST].budget_ns)
    };
    assert_eq!(
        budget(&text).ok(),
        Some(1_000_000_000),
        "the default budget is the period"
    );
    let text = "roots = [\"low\"]\n[schemas.low]\ntype = \"declared/with-budget\"\nperiod = \"1s\"\n";
    static DECLARED: raw::Plugin = jde_schema::plugin!("declared", "Declares its budget.", [WithBudget]);
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&DECLARED).expect("it is valid");
    let application = parse(text, Path::new("app.toml"), &[], &plugins).expect("it is valid");
    assert_eq!(application.instances[FIRST].budget_ns, 10_000_000);
}

/// A schema whose budget equals its period.
#[derive(Describe)]
#[schema(motor, period = "10ms", budget = "10ms")]
struct WithBudget {}

impl Schema for WithBudget {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}
