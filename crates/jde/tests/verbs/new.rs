//! The project that `jde new` writes builds, passes its own test and runs, outside this repository.

use std::path::Path;
use std::process::Command;

use crate::support::{jde, jde_with_plugins, said};

fn cargo(folder: &Path, verb: &str) {
    let output = Command::new(env!("CARGO"))
        .args([verb, "--offline"])
        .current_dir(folder)
        .env_remove("CARGO_TARGET_DIR")
        .output()
        .expect("cargo starts");
    assert!(
        output.status.success(),
        "cargo {verb}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn make(kind: &str, name: &str, folder: &Path) -> String {
    let made = said(&mut jde(&["new", kind, name, "--path", folder.to_str().unwrap()]));
    assert_eq!(made.status, Some(0), "{}", made.err);
    made.out
}

#[test]
fn a_new_schema_builds_passes_its_test_and_drives() {
    let folder = tempfile::tempdir().unwrap();
    let next = make("schema", "follow-wall", folder.path());
    assert!(
        next.contains("cargo build") && next.contains("run app.toml"),
        "{next}"
    );
    let own = folder.path().join("follow-wall");
    cargo(&own, "build");
    cargo(&own, "test");
    let run = said(
        jde_with_plugins(&["run", "app.toml", "--lockstep", "--for", "30s", "--json"]).current_dir(&own),
    );
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(run.err.contains("nobody -> follow-wall"), "{}", run.err);
    let summary: serde_json::Value = serde_json::from_str(run.out.trim()).unwrap();
    let clearance = summary["min_clearance_m"].as_f64().unwrap();
    assert!(
        summary["collisions"] == 0 && clearance < 0.6,
        "it came near the wall and not to it: {summary}"
    );
}

#[test]
fn a_new_driver_builds_passes_its_test_and_moves() {
    let folder = tempfile::tempdir().unwrap();
    make("driver", "gripper", folder.path());
    let own = folder.path().join("gripper");
    cargo(&own, "build");
    cargo(&own, "test");
    let args = [
        "run",
        "app.toml",
        "--lockstep",
        "--for",
        "5s",
        "--log",
        "exercise=info",
    ];
    let run = said(jde_with_plugins(&args).current_dir(&own));
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(
        run.err.contains("closes at 0.0") && run.err.contains("opens at 0.0"),
        "{}",
        run.err
    );
}

#[test]
fn a_new_application_is_checked_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    make("app", "patrol", folder.path());
    let own = folder.path().join("patrol");
    let check = said(jde_with_plugins(&["check", "app.toml"]).current_dir(&own));
    assert_eq!(check.status, Some(0), "{}", check.err);
    let run = said(jde_with_plugins(&["run", "app.toml", "--lockstep", "--seed", "1"]).current_dir(&own));
    assert_eq!(run.status, Some(0), "{}\n{}", run.out, run.err);
    assert!(
        run.out.contains("4 of 4 targets") && run.out.contains("no collision"),
        "{}",
        run.out
    );
}

#[test]
fn a_folder_that_is_there_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("patrol");
    std::fs::create_dir(&own).unwrap();
    let made = said(&mut jde(&[
        "new",
        "app",
        "patrol",
        "--path",
        folder.path().to_str().unwrap(),
    ]));
    assert_eq!(made.status, Some(2));
    assert!(made.err.contains("is there already"), "{}", made.err);
    assert_eq!(std::fs::read_dir(&own).unwrap().count(), 0);
}
