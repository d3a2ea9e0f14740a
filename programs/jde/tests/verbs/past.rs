//! `--in FILE --at TIME`: verbs for running applications ask a recording as it was at a time.

use std::path::Path;

use serde_json::Value;

use crate::support::{RunOutput, jde, jde_with_plugins, json, output_of, root};

/// Records twenty seconds of a robot whose commands a guard refuses again and again.
fn record(folder: &Path) -> String {
    let file = folder.join("guarded.mcap").display().to_string();
    let app = root().join("apps/guard.toml").display().to_string();
    let run = ["run", &app, "--lockstep", "--for", "20s", "--record", &file];
    let run = output_of(&mut jde_with_plugins(&run));
    assert_eq!(run.status, Some(0), "{}", run.err);
    file
}

/// Asks a recording by a verb, in a folder of its own for what runs.
fn ask(file: &str, folder: &Path, words: &[&str]) -> RunOutput {
    let words: Vec<_> = words.iter().copied().chain(["--in", file]).collect();
    let asked = output_of(jde(&words).env("JDE_RUNTIME_DIR", folder.join("run")));
    assert_eq!(asked.status, Some(0), "{}{}", asked.out, asked.err);
    asked
}

#[test]
fn a_recording_is_asked_as_it_was_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path());
    let ask = |words: &[&str]| ask(&file, folder.path(), words);
    let pose = |at: &[&str]| {
        let words: Vec<_> = ["get", "pioneer.truth", "--json"]
            .iter()
            .chain(at)
            .copied()
            .collect();
        let got = json(&ask(&words).out);
        (
            got["time_s"].as_f64().unwrap(),
            got["value"]["pose"]["x"].as_f64().unwrap(),
        )
    };
    let [early, late] = [pose(&["--at", "2s"]), pose(&["--at", "15s"])];
    assert!(early.0 <= 2.0 && early.0 > 1.8, "{early:?}");
    assert!(late.0 <= 15.0 && late.0 > 14.8 && late.1 != early.1, "{late:?}");
    assert!(pose(&[]).0 > 19.8, "without a time, at the end");
    let ps = json(&ask(&["ps", "--json", "--at", "2s"]).out);
    let names = |schemas: &Value| {
        let names = schemas.as_array().unwrap().iter();
        names
            .map(|schema| schema["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert!(names(&ps["schemas"]).contains(&"reckless".to_owned()), "{ps}");
    let events = |at: &str| {
        let all = ["events", "--all", "--last", "1000", "--at", at];
        ask(&all).out.lines().count()
    };
    assert!(
        events("15s") > events("2s"),
        "there are more events until a later time"
    );
    let wrong = ["get", "pioneer.truth", "--in", &file, "--at", "tcp/robot"];
    let wrong = output_of(&mut jde(&wrong));
    assert!(
        wrong.status == Some(2) && wrong.err.contains("--at is one time"),
        "{}",
        wrong.err
    );
}

#[test]
fn r15_a_refused_candidate_is_not_ready_because_of_its_guard() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path());
    let why = ask(&file, folder.path(), &["why", "nobody"]).out;
    assert!(why.contains("command refused by the guard `guard`"), "{why}");
    assert!(why.contains("not ready for 0."), "{why}");
    assert!(!why.contains("its precondition did not hold"), "{why}");
}
