//! The example of section 5 of the paper as it is delivered: its application, its plugins and its world, in
//! lockstep.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use jde_app::Application;
use jde_host::{Lockstep, Options};
use jde_loader::Plugins;
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::{Event, Outcome};
use jde_types::{Mission, Truth};

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

/// The application with only its types, wiring, groups, world and route: all other modulations have the
/// values of 2007.
fn unmodulated(plugins: &Plugins) -> Application {
    let text = std::fs::read_to_string(file()).expect("the application is there");
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
    let text = toml::to_string(&table).expect("it is TOML still");
    jde_app::parse(&text, &file(), &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

fn drive(mut application: Application, plugins: &Plugins, seed: u64, limit: u64) -> Drive {
    application.seed = seed;
    let decisions = Arc::new(Mutex::new(Some(DecisionWriter::new(&application, Vec::new()))));
    let ear = Arc::clone(&decisions);
    let stalled = Arc::new(Mutex::new(Vec::new()));
    let stalls = Arc::clone(&stalled);
    let hear = move |event: &Event| {
        if let Event::Stalled { time, since, .. } = event {
            assert!(time - since >= 30 * SECOND);
            stalls.lock().expect("nobody panicked").push(*since);
        }
        if let Some(decisions) = &mut *ear.lock().expect("nobody panicked") {
            decisions.on_event(event);
        }
    };
    let options = Options {
        observers: vec![Box::new(hear)],
        limit: Some(limit),
        ..Options::default()
    };
    let mut running =
        Lockstep::start(application, plugins, options).unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let outcome = running.run_until(limit).expect("it ends by its limit");
    drop(running);
    let decisions = decisions.lock().expect("nobody panicked").take();
    let stalled = stalled.lock().expect("nobody panicked").clone();
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
        decisions: decisions.expect("taken once").finish().expect("memory takes all"),
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
fn r16_one_seed_gives_one_run_to_the_bit_and_another_seed_another() {
    let plugins = plugins();
    let run = |seed| drive(application(&plugins), &plugins, seed, 60 * SECOND);
    let (first, again, other) = (run(1), run(1), run(2));
    assert!(first.decisions.len() > 1000, "{} bytes", first.decisions.len());
    assert!(
        first.decisions == again.decisions,
        "the same seed decided otherwise"
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
fn with_the_numbers_of_2007_it_touches_nothing_does_not_pass_a_door_and_says_so() {
    let plugins = plugins();
    let drive = drive(unmodulated(&plugins), &plugins, 1, 120 * SECOND);
    assert_eq!(drive.outcome, Outcome::Failed);
    assert_eq!((drive.mission.state, drive.mission.reached), (Mission::FAILED, 0));
    assert_eq!(drive.mission.note.as_str(), "1 target was out of reach");
    assert!(!drive.stalled.is_empty(), "nobody was told before");
    assert_eq!(drive.truth.collisions, 0);
}
