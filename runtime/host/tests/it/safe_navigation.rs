//! The example of section 5 of the buffer as it is delivered: its application, its plugins and its world, in
//! lockstep.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_app::Application;
use jde_host::{Lockstep, Options};
use jde_loader::Plugins;
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::{Event, Occurrence, Outcome, What};
use jde_types::{Mission, Truth};
use parking_lot::Mutex;

use crate::delivered::{self, ROOT, SECOND};

/// The result of a drive.
struct Drive {
    outcome: Outcome,
    mission: Mission,
    truth: Truth,
    /// For each report of a stalled mission: the time since which it made no progress, ns.
    stalled: Vec<u64>,
    decisions: Vec<u8>,
}

fn plugins() -> Plugins {
    delivered::plugins()
}

fn file() -> PathBuf {
    Path::new(ROOT).join("apps/safe-navigation.toml")
}

/// Loads the application as it is delivered.
fn application(plugins: &Plugins) -> Application {
    jde_app::load(&file(), &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Returns the application with only its types, wiring, groups, world and route: all other modulations have
/// the values of 2007.
fn unmodulated(plugins: &Plugins) -> Application {
    let text = std::fs::read_to_string(file()).expect("the application exists");
    let mut table: toml::Table = text.parse().expect("it is TOML");
    table["mission"] = toml::from_str::<toml::Table>("from = \"example.mission\"\nstalls = \"30s\"")
        .expect("it is a table")
        .into();
    let schemas = table["schemas"].as_table_mut().expect("it has schemas");
    let kept = [
        "type",
        "world",
        "imports",
        "actuators",
        "children",
        "groups",
        "route",
    ];
    for (_, schema) in schemas.iter_mut() {
        let schema = schema.as_table_mut().expect("a schema is a table");
        schema.retain(|key, _| kept.contains(&key));
    }
    let text = toml::to_string(&table).expect("it is still TOML");
    jde_app::parse(&text, &file(), &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

fn drive(mut application: Application, plugins: &Plugins, seed: u64, limit: u64) -> Drive {
    application.seed = seed;
    let decisions = Arc::new(Mutex::new(Some(DecisionWriter::new(&application, Vec::new()))));
    let recorder = Arc::clone(&decisions);
    let stalled = Arc::new(Mutex::new(Vec::new()));
    let stall_recorder = Arc::clone(&stalled);
    let observe = move |event: &Event| {
        if let Event::Other(Occurrence {
            time,
            what: What::Stalled { since, .. },
        }) = event
        {
            assert!(time - since >= 30 * SECOND);
            stall_recorder.lock().push(*since);
        }
        if let Some(decisions) = &mut *recorder.lock() {
            decisions.process(event);
        }
    };
    let options = Options {
        observers: vec![Box::new(observe)],
        limit: Some(limit),
        ..Options::default()
    };
    let mut running =
        Lockstep::start(application, plugins, options).unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let outcome = running.run_until(limit).expect("it ends within its limit");
    drop(running);
    let decisions = decisions.lock().take();
    let stalled = stalled.lock().clone();
    Drive {
        outcome,
        stalled,
        mission: handle
            .value("example.mission")
            .expect("it is exported")
            .expect("it was written"),
        truth: handle
            .value("pioneer.truth")
            .expect("it is exported")
            .expect("it was written"),
        decisions: decisions
            .expect("taken once")
            .finish()
            .expect("writing to memory succeeds"),
    }
}

#[test]
fn the_robot_reaches_all_its_targets_and_touches_nothing() {
    let plugins = plugins();
    for seed in 1..=5 {
        let Drive {
            outcome,
            mission,
            truth,
            ..
        } = drive(application(&plugins), &plugins, seed, 600 * SECOND);
        assert_eq!(outcome, Outcome::Done, "seed {seed}");
        assert_eq!(
            (mission.state, mission.reached, mission.total),
            (Mission::DONE, 8, 8)
        );
        assert_eq!(truth.collisions, 0, "seed {seed}");
        assert!(
            truth.min_clearance > 0.05,
            "seed {seed}: {} m",
            truth.min_clearance
        );
    }
}

#[test]
fn r16_equal_seeds_give_equal_runs_and_another_seed_another_run() {
    let plugins = plugins();
    let run = |seed| drive(application(&plugins), &plugins, seed, 60 * SECOND);
    let (first, again, other) = (run(1), run(1), run(2));
    assert!(first.decisions.len() > 1000, "{} bytes", first.decisions.len());
    assert!(
        first.decisions == again.decisions,
        "the same seed made other decisions"
    );
    assert_eq!(first.truth, again.truth);
    assert!(
        first.decisions != other.decisions,
        "another seed made no difference"
    );
    assert_ne!(first.truth.pose, other.truth.pose);
}

/// Shows why the application sets modulations: the areas of 2007, 2 m wide and 3 m ahead, are wider than a
/// door.
#[test]
fn with_the_parameters_of_2007_the_robot_touches_nothing_and_fails_at_the_door() {
    let plugins = plugins();
    let drive = drive(unmodulated(&plugins), &plugins, 1, 120 * SECOND);
    assert_eq!(drive.outcome, Outcome::Failed);
    assert_eq!((drive.mission.state, drive.mission.reached), (Mission::FAILED, 0));
    assert_eq!(drive.mission.note.as_str(), "1 target was out of reach");
    assert!(!drive.stalled.is_empty(), "no stall was reported before the end");
    assert_eq!(drive.truth.collisions, 0);
}
