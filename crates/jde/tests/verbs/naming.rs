//! The names of applications, the times for which data is known, and recordings from outside: real processes.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, UNIX_EPOCH};

use jde_log::{Options, Origin, Recorder};
use jde_records::{Decision, EventRecord, RunRecord};
use serde_json::Value;

use crate::attached::{Place, navigation, schema};
use crate::support::{Said, jde, jde_with_plugins, pair, said};

/// Writes an application whose listener imports from the talker of `robot3`.
fn importer(place: &Place) -> String {
    let file = place.folder().join("importer.toml");
    let text = "name = \"importer\"\nroots = [\"listener\"]\n\n[schemas.listener]\ntype = \"pair/listener\"\n\
                imports = { count = \"robot3:talker.count\" }\n";
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

fn refused(place: &Place, args: &[&str]) -> Said {
    let said = place.says(args);
    assert_eq!(said.status, Some(2), "jde {args:?}: {said:?}");
    said
}

#[test]
fn what_is_imported_is_found_by_its_name_before_the_application_it_comes_from() {
    let place = Place::new();
    let _importer = place.start(&importer(&place), &[]);
    let get = |args: &[&str]| place.json(&[&["get"], args].concat())["application"].clone();
    assert_eq!(
        get(&["robot3:talker.count"]),
        "importer",
        "the only one that runs"
    );
    let slip = refused(&place, &["get", "robot3:talker.cuont"]);
    assert!(
        slip.err.contains("did you mean `robot3:talker.count`?"),
        "{slip:?}"
    );
    let _robot = place.start(&pair(), &["--name", "robot3"]);
    assert_eq!(get(&["robot3:talker.count", "--app", "importer"]), "importer");
    assert_eq!(get(&["robot3:talker.count"]), "robot3", "none of two is meant");
    assert_eq!(get(&["robot3:talker.period", "--app", "importer"]), "robot3");
    let listed = place.told(&["vars", "robot3:*", "--app", "importer"]);
    assert!(listed.contains("robot3:talker.count"), "{listed}");
    assert!(!listed.contains("listener"), "{listed}");
}

#[test]
fn an_application_is_not_called_as_the_one_it_imports_from() {
    let place = Place::new();
    let file = importer(&place);
    let run = ["run", &file, "--plain", "--for", "300ms"];
    let called = said(&mut place.command(jde_with_plugins(&[&run[..], &["--name", "robot3"]].concat())));
    assert_eq!(called.status, Some(2), "{called:?}");
    assert!(
        called
            .err
            .contains("imports from another application called `robot3`"),
        "{called:?}"
    );
    // Conditions may also name an import.
    let recording = place.folder().join("heard.mcap");
    let recording = recording.to_str().unwrap();
    let more = ["--record", recording, "--when", "robot3:talker.count > 3u"];
    let recorded = said(&mut place.command(jde_with_plugins(&[&run[..], &more].concat())));
    assert_eq!(recorded.status, Some(0), "{recorded:?}");
}

#[test]
fn a_verb_for_one_application_takes_no_two() {
    let place = Place::new();
    let _first = place.start(&pair(), &["--name", "a"]);
    let _second = place.start(&pair(), &["--name", "b"]);
    let file = place.folder().join("both.mcap");
    let file = file.to_str().unwrap();
    for args in [
        &["record", file, "a:talker.*", "b:talker.*"][..],
        &["vars", "a:talker.*", "b:talker.*"],
        &["events", "a", "--app", "b", "--once"],
        &["ps", "a", "--app", "b"],
        &["why", "a:listener", "from", "b:talker"],
    ] {
        let said = refused(&place, args);
        assert!(said.err.contains("application"), "{args:?}: {said:?}");
    }
    assert!(!PathBuf::from(file).exists());
    place.told(&["events", "a", "--app", "a", "--once"]);
}

#[test]
fn of_times_that_are_not_known_nothing_is_told() {
    let place = Place::new();
    let _robot = navigation(&place);
    place.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    for question in [&["why", "at", "99999s"][..], &["why", "goon", "at", "99999s"]] {
        let said = place.says(question);
        assert_eq!(said.status, Some(1), "{said:?}");
        assert!(
            said.err
                .contains("99999 s lies beyond what is known, which ends at"),
            "{said:?}"
        );
    }
    let file = place.folder().join("drive.mcap");
    let file = file.to_str().unwrap();
    place.told(&["record", file, "goon.*", "--for", "200ms"]);
    let said = place.says(&["why", "at", "99999s", "--in", file]);
    assert_eq!(said.status, Some(1), "{said:?}");
    assert!(said.err.contains("lies beyond what is known"), "{said:?}");
}

#[test]
fn a_recording_is_known_from_its_beginning_on_and_not_from_its_first_selection() {
    let place = Place::new();
    let file = place.folder().join("quiet.mcap");
    let options = Options {
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
        on_error: Box::new(|trouble| panic!("{trouble}")),
    };
    let recorder = Recorder::create(&file, options).unwrap();
    recorder.push_record(RunRecord::Event(EventRecord {
        time_s: 1.0,
        kind: "operator".to_owned(),
        schema: None,
        by: None,
        text: "plays".to_owned(),
        touched: None,
    }));
    recorder.push_record(RunRecord::Decision(Decision {
        number: 1,
        time_s: 5.0,
        group: "roots".to_owned(),
        case: "alone".to_owned(),
        candidates: Vec::new(),
        before: None,
        choice: Some("listener".to_owned()),
        decider: "nobody".to_owned(),
        reason: "the only one ready".to_owned(),
        cause: "it became ready".to_owned(),
        changed: true,
        takeover_us: None,
    }));
    recorder.finish();
    for (time, answer) in [
        ("0.2s", "0.2 s lies before what is known, which begins at 1.00 s"),
        ("3s", "no takeover like that was made"),
    ] {
        let said = place.says(&["why", "at", time, "--in", file.to_str().unwrap()]);
        assert_eq!(said.status, Some(1), "{said:?}");
        assert!(said.err.contains(answer), "{said:?}");
    }
}

#[test]
fn periods_have_one_range_wherever_they_are_given() {
    let place = Place::new();
    let _robot = place.start(&pair(), &[]);
    for args in [
        &["period", "talker", "8766h"][..],
        &["period", "talker", "99us"],
        &["set", "talker.period", "8766h"],
        &["set", "talker.period=31557600"],
        &["check", "pair", "--set", "talker.period=31557600s"],
    ] {
        let said = said(&mut place.command(jde_with_plugins(args)));
        assert_eq!(said.status, Some(2), "{args:?}: {said:?}");
        assert!(said.err.contains("from 100 us to a day"), "{args:?}: {said:?}");
    }
    place.told(&["set", "talker.period", "0.05"]);
    assert_eq!(place.json(&["get", "talker.period"])["value"], 0.05);
}

fn recorded(file: &str) -> Value {
    let info = said(&mut jde(&["info", file, "--json"]));
    assert_eq!(info.status, Some(0), "{info:?}");
    serde_json::from_str(&info.out).unwrap()
}

#[test]
fn a_recording_from_outside_begins_when_it_began() {
    let place = Place::new();
    let _robot = navigation(&place);
    place.until(&["ps"], |now| now["time"].as_u64() > Some(1_500_000_000));
    let file = place.folder().join("late.mcap");
    let file = file.to_str().unwrap();
    place.told(&["record", file, "pioneer.*", "--for", "500ms"]);
    let info = recorded(file);
    let at = |key: &str| info[key].as_u64().unwrap();
    let late = at("first_ns") - at("application_start_ns");
    assert!(late >= 1_500_000_000, "it begins {late} ns after the start");
    let words = place.told(&["info", file]);
    assert!(words.contains(" s after its start"), "{words}");
    // Playback begins at the recording's beginning, not at the application's start, which it does not
    // contain.
    let playing = place.replay(file.as_ref(), &["--paused", "--name", "later"]);
    let position = place.json(&["get", "replay.position", "--app", "later"]);
    assert!(position["value"].as_f64() >= Some(1.5), "{position}");
    let start = place.says(&["set", "replay.position", "0", "--app", "later"]);
    assert!(start.err.contains("` takes "), "{start:?}");
    drop(playing);
    // The recording contains earlier selections too, with their times.
    let why = place.told(&["why", "goon", "--in", file]);
    assert!(why.contains("example/base at "), "{why}");
}

#[test]
fn r14_a_recording_from_outside_waits_for_its_moment() {
    let place = Place::new();
    let _robot = navigation(&place);
    let file = place.folder().join("drive.mcap");
    let name = file.to_str().expect("UTF-8");
    let wrong = refused(&place, &["record", name, "--when", "goon.fst > 0.1"]);
    assert!(wrong.err.contains("goon.fast"), "{wrong:?}");
    // An action before the recording is not a moment to record.
    place.told(&["set", "goon.fast", "0.35"]);
    let mut record = place.command(jde(&["record"]));
    record
        .arg(&file)
        .args(["pioneer.laser", "--when", "operator", "--after", "100ms"]);
    record.args(["--when", "goon.fast < 0.3"]);
    let mut recording = record
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut words = BufReader::new(recording.stderr.take().unwrap());
    let mut line = String::new();
    words.read_line(&mut line).unwrap();
    assert!(line.contains("when a condition comes true"), "{line}");
    place.told(&["set", "goon.fast", "0.25"]);
    let first = place.folder().join("drive-001.mcap");
    let whole = || first.exists() && recorded(first.to_str().unwrap())["damage"].is_null();
    while !whole() {
        assert!(recording.try_wait().unwrap().is_none(), "it goes on");
    }
    let interrupt = Command::new("kill")
        .args(["-INT", &recording.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    let mut out = String::new();
    recording.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    assert_eq!(recording.wait().unwrap().code(), Some(0), "{out}");
    assert!(
        out.contains("drive-001.mcap") && out.contains(" and 1 more"),
        "{out}"
    );
    let info = recorded(first.to_str().unwrap());
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
