//! `--in FILE --at TIME`: verbs for running applications ask a recording as it was at a time. And why a running one
//! does not act.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use jde_recorder::{Origin, Recorder, RecorderOptions, Stamps};
use jde_records::RunRecord;
use jde_types::Value as _;
use serde_json::Value;

use crate::attached::{Sandbox, schema};
use crate::support::{RunOutput, jde, jde_with_plugins, json, output_of, pair, root};

const MILLISECOND: u64 = 1_000_000;

/// Records twenty seconds of a robot whose commands a guard refuses again and again.
fn record(folder: &Path) -> String {
    let file = folder.join("guarded.mcap").display().to_string();
    let app = root().join("apps/guard.toml").display().to_string();
    let run = ["run", &app, "--lockstep", "--for", "20s", "--record", &file];
    let run = output_of(&mut jde_with_plugins(&run));
    assert_eq!(run.status, Some(0), "{}", run.err);
    file
}

/// Records values of `talker.count`, one each millisecond, which end after 2 s, and one more after 4 s.
fn record_retracted(folder: &Path, count: u64) -> String {
    let file = folder.join("retracted.mcap");
    let options = RecorderOptions {
        origin: Origin {
            application: "retracted".to_owned(),
            seed: 0,
            started: UNIX_EPOCH,
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite: true,
        lossless: true,
        on_trouble: Box::new(|error| panic!("{error}")),
    };
    let recorder = Recorder::create(&file, options).unwrap();
    let metadata = BTreeMap::from([("variable".to_owned(), "talker.count".to_owned())]);
    let topic = recorder.topic("/talker/count", Arc::new(f64::describe()), metadata);
    let put = |number: u64, published: u64| {
        let stamps = Stamps {
            published,
            measured: published,
            sequence: number,
        };
        assert!(topic.put(&(number as f64).to_ne_bytes(), stamps));
    };
    // A recorder that retracts values needs a topic of records.
    recorder.push_record(RunRecord::retracted(0, "nothing"));
    for number in 1..=count {
        put(number, number * MILLISECOND);
    }
    topic.retract(2000 * MILLISECOND);
    put(count + 1, 4000 * MILLISECOND);
    recorder.finish();
    file.display().to_string()
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
fn r19_a_value_that_had_ended_is_not_shown() {
    let folder = tempfile::tempdir().unwrap();
    // Of a topic with few values all are kept, of others the newest are searched.
    for count in [1, 1500] {
        let file = record_retracted(folder.path(), count);
        let get = |at: &str| {
            let got = ask(&file, folder.path(), &["get", "talker.count", "--at", at]);
            got.out.trim().to_owned()
        };
        assert_eq!(get("1.6s").parse::<f64>(), Ok(count as f64));
        // The recording starts at midnight.
        assert_eq!(get("00:00:04Z"), get("4s"));
        assert_eq!(get("3s"), "no value: it has ended, or was retracted");
        assert_eq!(get("4s").parse::<f64>(), Ok((count + 1) as f64));
        let vars = ask(&file, folder.path(), &["vars", "talker.*", "--at", "3s"]);
        assert!(vars.out.contains("ended"), "{}", vars.out);
    }
}

#[test]
fn a_time_that_a_recording_does_not_cover_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = record_retracted(folder.path(), 1);
    let asked = ["get", "talker.count", "--in", &file, "--at", "99s"];
    let asked = output_of(jde(&asked).env("JDE_RUNTIME_DIR", folder.path().join("run")));
    let zone = output_of(&mut jde(&[
        "get",
        "talker.count",
        "--in",
        &file,
        "--at",
        "00:00:04",
    ]));
    assert!(zone.err.contains("write 00:00:04Z"), "{}", zone.err);
    let reason = "99 s is after the messages of the recording, which end at 4.00 s";
    assert!(
        asked.status == Some(1) && asked.err.contains(reason),
        "{}",
        asked.err
    );
}

#[test]
fn an_application_that_runs_does_not_answer_for_a_recording() {
    let sandbox = Sandbox::new();
    let file = record_retracted(sandbox.folder(), 1);
    let _robot = sandbox.start(&pair(), &["--name", "robot3"]);
    sandbox.run_ok(&["get", "robot3:talker.count"]);
    for asked in [
        ["get", "robot3:talker.count", "--in", &file],
        ["vars", "robot3:talker.count", "--in", &file],
        ["ps", "robot3", "--in", &file],
    ] {
        let asked = sandbox.run(&asked);
        assert_eq!(asked.status, Some(2), "{asked:?}");
    }
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

#[test]
fn why_names_an_import_that_never_had_a_value() {
    let sandbox = Sandbox::new();
    let text = std::fs::read_to_string(root().join("programs/jde/templates/robot/robot.toml"));
    let text = text.expect("the template exists");
    let (blind, _) = text.split_once("[[lasers]]").expect("it has a laser");
    let model = sandbox.folder().join("blind.toml");
    std::fs::write(&model, blind).expect("the folder is writable");
    let set = format!("pioneer.model={}", model.display());
    let _robot = sandbox.start("apps/safe-navigation.toml", &["--set", &set]);
    sandbox.until(&["ps"], |now| schema(now, "stop")["state"] == "winner");
    let question = ["why", "is", "goon", "not", "the", "winner"];
    let why = sandbox.json(&question);
    assert_eq!(why["without_value"][0]["variable"], "pioneer.laser", "{why}");
    let why = sandbox.run_ok(&question);
    let words = "no value    goon has no laser: pioneer.laser was never written";
    assert!(why.contains(words), "{why}");
}
