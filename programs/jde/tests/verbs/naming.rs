//! Names of applications and of imports from other applications, the time range of selections, and recordings
//! by another process.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, UNIX_EPOCH};

use jde_core::Case;
use jde_recorder::{Origin, Recorder, RecorderOptions};
use jde_records::{DecidedBy, Decision, RunRecord};
use serde_json::Value;

use crate::attached::{Sandbox, navigation, schema};
use crate::support::{RunOutput, jde, jde_with_plugins, output_of, pair, signal};

/// Writes an application whose listener imports from the talker of `robot3`.
fn importer(sandbox: &Sandbox) -> String {
    let file = sandbox.folder().join("importer.toml");
    let text = "name = \"importer\"\nroots = [\"listener\"]\n\n[schemas.listener]\ntype = \"pair/listener\"\n\
                imports = { count = \"robot3:talker.count\" }\n";
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

fn refused(sandbox: &Sandbox, args: &[&str]) -> RunOutput {
    let output = sandbox.run(args);
    assert_eq!(output.status, Some(2), "jde {args:?}: {output:?}");
    output
}

#[test]
fn get_finds_an_imported_variable_in_the_importer_while_its_source_does_not_run() {
    let sandbox = Sandbox::new();
    let _importer = sandbox.start(&importer(&sandbox), &[]);
    let get = |args: &[&str]| sandbox.json(&[&["get"], args].concat())["application"].clone();
    assert_eq!(
        get(&["robot3:talker.count"]),
        "importer",
        "only one application runs"
    );
    let misspelled = refused(&sandbox, &["get", "robot3:talker.cuont"]);
    assert!(
        misspelled.err.contains("did you mean `robot3:talker.count`?"),
        "{misspelled:?}"
    );
    let _robot = sandbox.start(&pair(), &["--name", "robot3"]);
    assert_eq!(get(&["robot3:talker.count", "--app", "importer"]), "importer");
    assert_eq!(get(&["robot3:talker.count"]), "robot3", "the source has priority");
    assert_eq!(get(&["robot3:talker.period", "--app", "importer"]), "robot3");
    let listed = sandbox.run_ok(&["vars", "robot3:*", "--app", "importer"]);
    assert!(listed.contains("robot3:talker.count"), "{listed}");
    assert!(!listed.contains("listener"), "{listed}");
}

#[test]
fn a_verb_for_running_applications_that_gets_a_file_names_the_verbs_for_recordings() {
    let sandbox = Sandbox::new();
    let file = sandbox.folder().join("drive.mcap");
    fs::write(&file, "").unwrap();
    let file = file.display().to_string();
    for verb in ["events", "ps", "why"] {
        let output = refused(&sandbox, &[verb, &file]);
        let advice = format!("use `jde info {file}`, `jde report {file}` or `jde why --in {file}`");
        assert!(output.err.contains(&advice), "{verb}: {output:?}");
    }
}

#[test]
fn an_application_cannot_have_the_name_of_one_that_it_imports_from() {
    let sandbox = Sandbox::new();
    let file = importer(&sandbox);
    let run = ["run", &file, "--plain", "--for", "300ms"];
    let renamed =
        output_of(&mut sandbox.command(jde_with_plugins(&[&run[..], &["--name", "robot3"]].concat())));
    assert_eq!(renamed.status, Some(2), "{renamed:?}");
    assert!(
        renamed
            .err
            .contains("imports from another application called `robot3`"),
        "{renamed:?}"
    );
    // Conditions may also name an import.
    let recording = sandbox.folder().join("import.mcap");
    let recording = recording.to_str().unwrap();
    let options = ["--record", recording, "--when", "robot3:talker.count > 3u"];
    let recorded = output_of(&mut sandbox.command(jde_with_plugins(&[&run[..], &options].concat())));
    assert_eq!(recorded.status, Some(0), "{recorded:?}");
}

#[test]
fn a_verb_for_one_application_refuses_two() {
    let sandbox = Sandbox::new();
    let _first = sandbox.start(&pair(), &["--name", "a"]);
    let _second = sandbox.start(&pair(), &["--name", "b"]);
    let file = sandbox.folder().join("both.mcap");
    let file = file.to_str().unwrap();
    for args in [
        &["record", file, "a:talker.*", "b:talker.*"][..],
        &["vars", "a:talker.*", "b:talker.*"],
        &["events", "a", "--app", "b", "--once"],
        &["ps", "a", "--app", "b"],
        &["why", "a:listener", "from", "b:talker"],
    ] {
        let output = refused(&sandbox, args);
        assert!(output.err.contains("application"), "{args:?}: {output:?}");
    }
    assert!(!PathBuf::from(file).exists());
    sandbox.run_ok(&["events", "a", "--app", "a", "--once"]);
}

#[test]
fn why_refuses_a_time_after_the_end_of_the_data() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    for question in [&["why", "at", "99999s"][..], &["why", "goon", "at", "99999s"]] {
        let output = sandbox.run(question);
        assert_eq!(output.status, Some(1), "{output:?}");
        assert!(
            output
                .err
                .contains("99999 s is after the known selections, which end at"),
            "{output:?}"
        );
    }
    let file = sandbox.folder().join("drive.mcap");
    let file = file.to_str().unwrap();
    sandbox.run_ok(&["record", file, "goon.*", "--for", "200ms"]);
    let output = sandbox.run(&["why", "at", "99999s", "--in", file]);
    assert_eq!(output.status, Some(1), "{output:?}");
    assert!(output.err.contains("is after the known selections"), "{output:?}");
}

#[test]
fn the_time_range_of_a_recording_begins_at_its_first_message() {
    let sandbox = Sandbox::new();
    let file = sandbox.folder().join("quiet.mcap");
    let options = RecorderOptions {
        origin: Origin {
            application: "quiet".to_owned(),
            seed: 0,
            started: UNIX_EPOCH + Duration::from_secs(1000),
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite: false,
        lossless: true,
        on_trouble: Box::new(|error| panic!("{error}")),
    };
    let recorder = Recorder::create(&file, options).unwrap();
    recorder.push_record(RunRecord::retracted(1_000_000_000, "nothing"));
    recorder.push_record(RunRecord::Decision(Decision {
        number: 1,
        time_s: 5.0,
        group: "roots".to_owned(),
        case: Case::Alone,
        candidates: Vec::new(),
        before: None,
        choice: Some("listener".to_owned()),
        decider: DecidedBy::Nobody,
        reason: "the only one ready".to_owned(),
        cause: "it became ready".to_owned(),
        changed: true,
        takeover_us: None,
        refused: Vec::new(),
    }));
    recorder.finish();
    for (time, error) in [
        (
            "0.2s",
            "0.2 s is before the known selections, which begin at 1.00 s",
        ),
        ("3s", "there was no such takeover"),
    ] {
        let output = sandbox.run(&["why", "at", time, "--in", file.to_str().unwrap()]);
        assert_eq!(output.status, Some(1), "{output:?}");
        assert!(output.err.contains(error), "{output:?}");
    }
}

#[test]
fn every_verb_checks_periods_against_the_same_range() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start(&pair(), &[]);
    for args in [
        &["period", "talker", "8766h"][..],
        &["period", "talker", "99us"],
        &["set", "talker.period", "8766h"],
        &["set", "talker.period=31557600s"],
        &["check", "pair", "--set", "talker.period=31557600s"],
    ] {
        let output = output_of(&mut sandbox.command(jde_with_plugins(args)));
        assert_eq!(output.status, Some(2), "{args:?}: {output:?}");
        assert!(
            output.err.contains("from 100 us to a day"),
            "{args:?}: {output:?}"
        );
    }
    let bare = sandbox.run(&["set", "talker.period", "0.05"]);
    assert_eq!(bare.status, Some(2), "{bare:?}");
    assert!(bare.err.contains("needs a unit"), "{bare:?}");
    for verb in [&["set", "talker.period", "75s"][..], &["period", "talker", "75s"]] {
        let far = sandbox.run(verb);
        assert_eq!(far.status, Some(0), "{far:?}");
        assert!(far.err.contains("check the unit"), "{far:?}");
    }
    let set = sandbox.run_ok(&["set", "talker.period", "20Hz"]);
    assert!(set.contains("talker.period is now 50 ms"), "{set}");
    assert_eq!(sandbox.json(&["get", "talker.period"])["value"], 0.05);
}

#[test]
fn an_unknown_schema_gets_the_names_of_those_that_exist() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start(&pair(), &[]);
    for verb in ["stop", "play", "release", "reload"] {
        let output = refused(&sandbox, &[verb, "nobody"]);
        assert!(output.err.contains("there are: "), "{verb}: {output:?}");
    }
}

#[test]
fn r14_a_release_of_what_nobody_holds_says_so_and_is_no_event() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start(&pair(), &[]);
    let released = || sandbox.run_ok(&["events", "--once"]).matches("release").count();
    let before = released();
    let said = sandbox.run_ok(&["release", "talker"]);
    assert!(said.contains("was held by nobody"), "{said}");
    assert_eq!(released(), before);
    sandbox.run_ok(&["stop", "talker"]);
    let said = sandbox.run_ok(&["release", "talker"]);
    assert!(said.contains("is released"), "{said}");
    while released() == before {}
}

/// Returns the JSON of `jde info`.
fn info(file: &str) -> Value {
    let info = output_of(&mut jde(&["info", file, "--json"]));
    assert_eq!(info.status, Some(0), "{info:?}");
    serde_json::from_str(&info.out).unwrap()
}

#[test]
fn a_recording_by_another_process_begins_after_the_start_of_the_application() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| now["time"].as_u64() > Some(1_500_000_000));
    let file = sandbox.folder().join("late.mcap");
    let file = file.to_str().unwrap();
    sandbox.run_ok(&["record", file, "pioneer.*", "--for", "500ms"]);
    let info = self::info(file);
    let at = |key: &str| info[key].as_u64().unwrap();
    let delay = at("first_ns") - at("application_start_ns");
    assert!(
        delay >= 1_500_000_000,
        "the recording begins {delay} ns after the start"
    );
    let text = sandbox.run_ok(&["info", file]);
    assert!(text.contains(" s after its start"), "{text}");
    // Playback begins with the recording, not at the start of the application, which is not recorded.
    let playing = sandbox.replay(file.as_ref(), &["--paused", "--name", "later"]);
    let position = sandbox.json(&["get", "replay.position", "--app", "later"]);
    assert!(position["value"].as_f64() >= Some(1.5), "{position}");
    let start = sandbox.run(&["set", "replay.position", "0", "--app", "later"]);
    assert!(start.err.contains("` takes "), "{start:?}");
    drop(playing);
    // The recording contains earlier selections too, with their times.
    let why = sandbox.run_ok(&["why", "goon", "--in", file]);
    assert!(why.contains("example/base at "), "{why}");
}

#[test]
fn r14_a_recording_by_another_process_starts_when_a_condition_becomes_true() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let file = sandbox.folder().join("drive.mcap");
    let name = file.to_str().expect("UTF-8");
    let wrong = refused(&sandbox, &["record", name, "--when", "goon.fst > 0.1"]);
    assert!(wrong.err.contains("goon.fast"), "{wrong:?}");
    // An action before the recording does not trigger it.
    sandbox.run_ok(&["set", "goon.fast", "0.35"]);
    let mut record = sandbox.command(jde(&["record"]));
    record
        .arg(&file)
        .args(["pioneer.laser", "--when", "operator", "--after", "100ms"]);
    record.args(["--when", "goon.fast < 0.3"]);
    let mut recording = record
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut errors = BufReader::new(recording.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.contains("when a condition becomes true"), "{line}");
    sandbox.run_ok(&["set", "goon.fast", "0.25"]);
    let first = sandbox.folder().join("drive-001.mcap");
    let is_complete = || first.exists() && info(first.to_str().unwrap())["damage"].is_null();
    while !is_complete() {
        assert!(recording.try_wait().unwrap().is_none(), "the recording continues");
    }
    signal("INT", &recording);
    let mut out = String::new();
    recording.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    assert_eq!(recording.wait().unwrap().code(), Some(0), "{out}");
    assert!(
        out.contains("drive-001.mcap") && out.contains(" and 1 more"),
        "{out}"
    );
    let info = self::info(first.to_str().unwrap());
    let reasons = info["triggers"].as_array().unwrap().iter();
    let mut reasons: Vec<_> = reasons
        .map(|cause| cause["condition"].as_str().unwrap())
        .collect();
    reasons.sort_unstable();
    assert_eq!(reasons, ["goon.fast < 0.3", "operator"]);
    let topics = info["topics"].as_array().unwrap();
    let topics: Vec<_> = topics
        .iter()
        .map(|topic| topic["topic"].as_str().unwrap())
        .collect();
    assert!(
        topics.contains(&"/pioneer/laser") && !topics.contains(&"/goon/fast"),
        "{topics:?}"
    );
}

#[test]
fn record_fails_when_its_application_is_killed() {
    let sandbox = Sandbox::new();
    let robot = sandbox.start(&pair(), &[]);
    let mut record = sandbox
        .command(jde(&["record"]))
        .arg(sandbox.folder().join("drive.mcap"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut messages = BufReader::new(record.stderr.take().unwrap());
    let mut line = String::new();
    messages.read_line(&mut line).unwrap();
    assert!(line.contains("recording"), "{line}");
    robot.signal("KILL");
    let mut errors = String::new();
    messages.read_to_string(&mut errors).unwrap();
    assert_eq!(record.wait().unwrap().code(), Some(1), "{errors}");
    assert!(errors.contains("`pair` is gone"), "{errors}");
}
