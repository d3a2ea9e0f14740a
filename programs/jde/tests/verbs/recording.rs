//! `jde run --record`: the content of the file, the printed messages, and the errors.

use std::collections::BTreeSet;

use jde_log::{RecordedMessage, Recording, record};
use jde_records::event::What;
use jde_ros::cdr;
use jde_types::{LaserScan, Mission, Value};

use crate::support::{app, jde, jde_with_plugins, json, output_of};

/// Returns the messages of a topic.
fn on_topic<'m>(messages: &'m [RecordedMessage], topic: &str) -> Vec<&'m RecordedMessage> {
    let on_topic = messages.iter().filter(|message| message.channel.topic == topic);
    on_topic.collect()
}

fn value<T: Value>(message: &RecordedMessage) -> T {
    let bytes = cdr::decode(&T::describe(), &message.data).expect("the message has this type");
    T::from_bytes(&bytes).expect("the length fits the type")
}

#[test]
fn r15_r16_a_run_in_lockstep_is_recorded_completely() {
    let folder = tempfile::tempdir().unwrap();
    let (file, decisions) = (
        folder.path().join("deep/run.mcap"),
        folder.path().join("decisions"),
    );
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app("room.toml"),
        "--lockstep",
        "--json",
        "--record",
        file.to_str().unwrap(),
        "--decisions",
        decisions.to_str().unwrap(),
    ]));
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(
        run.err.contains("run.mcap: ") && run.err.contains("nothing lost"),
        "{}",
        run.err
    );
    let summary = json(&run.out);

    let recording = Recording::open(&file).unwrap();
    assert_eq!(recording.damage(), None);
    let messages: Vec<RecordedMessage> = recording.messages().unwrap().map(Result::unwrap).collect();
    assert_eq!(summary["recording"]["kept"], messages.len());
    assert_eq!(summary["recording"]["lost"], 0);
    let start: u64 = recording.metadata("jde").unwrap()["start_ns"].parse().unwrap();

    let decided: Vec<u8> = on_topic(&messages, "/jde/decisions")
        .iter()
        .flat_map(|message| [record::read(message).unwrap().to_json().as_slice(), b"\n"].concat())
        .collect();
    assert_eq!(
        decided,
        std::fs::read(&decisions).unwrap(),
        "the same decisions, in their order"
    );

    let scans = on_topic(&messages, "/pioneer/laser");
    assert_eq!(scans[0].channel.type_name, "sensor_msgs/msg/LaserScan");
    for (index, message) in scans.iter().enumerate() {
        assert_eq!(
            message.sequence as usize,
            index + 1,
            "from the first value on, without a gap"
        );
        let scan: LaserScan = value(message);
        assert_eq!(scan.ranges.len(), 180);
        let stamp = std::time::Duration::from(scan.header.stamp);
        assert_eq!(u128::from(message.log_time - start), stamp.as_nanos());
    }
    let missions = on_topic(&messages, "/guide/mission");
    let last: Mission = value(missions.last().unwrap());
    assert_eq!(summary["reached"], last.reached);
    let ended = record::read(on_topic(&messages, "/jde/events").last().unwrap());
    assert!(ended.is_some_and(|record| matches!(record.what(), Some(What::Ended { .. }))));
    assert!(!on_topic(&messages, "/jde/states").is_empty());
}

#[test]
fn record_only_selects_variables_by_pattern() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let record = |only: &[&str]| {
        let app = app("room.toml");
        let mut args = vec![
            "run",
            &app,
            "--lockstep",
            "--for",
            "1s",
            "--record",
            file.to_str().unwrap(),
        ];
        args.extend(["--overwrite", "--record-only"]);
        args.extend(only);
        output_of(&mut jde_with_plugins(&args))
    };
    record(&["*.laser", "guide.mission"]);
    let recording = Recording::open(&file).unwrap();
    let topics: BTreeSet<&str> = recording
        .channels()
        .map(|channel| channel.topic.as_str())
        .filter(|topic| !topic.starts_with("/jde/"))
        .collect();
    assert_eq!(topics, BTreeSet::from(["/guide/mission", "/pioneer/laser"]));

    let unknown = record(&["pioneer.lasr"]);
    assert_eq!(unknown.status, Some(2));
    assert!(
        unknown.err.contains("did you mean `pioneer.laser`?"),
        "{}",
        unknown.err
    );
}

#[test]
fn a_file_that_cannot_be_written_is_reported_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    std::fs::write(&file, "precious").unwrap();
    let record = |file: &str| {
        let app = app("room.toml");
        output_of(&mut jde_with_plugins(&[
            "run",
            &app,
            "--lockstep",
            "--record",
            file,
        ]))
    };
    let exists = record(file.to_str().unwrap());
    assert_eq!(exists.status, Some(2));
    assert!(
        exists.err.contains("exists already") && exists.err.contains("--overwrite"),
        "{}",
        exists.err
    );
    assert_eq!(std::fs::read(&file).unwrap(), b"precious");
    let full = record("/dev/full");
    assert_eq!((full.status, full.out.as_str()), (Some(1), ""), "{}", full.err);
    assert!(full.err.contains("/dev/full: No space left"), "{}", full.err);
}

#[test]
fn r16_conditions_give_the_same_files_in_each_run_in_lockstep() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str| {
        let file = folder.path().join(name);
        let run = output_of(&mut jde_with_plugins(&[
            "run",
            &app("room.toml"),
            "--lockstep",
            "--json",
            "--record",
            file.to_str().unwrap(),
            "--record-only",
            "*.laser",
            "*.period",
            // A condition reads this variable, although it is not recorded.
            "--when",
            "guide.mission.reached >= 1u",
            "--when",
            "pioneer.laser.ranges.exists(r, r < 0.9)",
            "--when",
            "goon.won and clearance < 1.2 and time > 1",
            "--before",
            "2s",
            "--after",
            "1s",
        ]));
        assert_eq!(run.status, Some(0), "{}", run.err);
        run
    };
    let first = run("a/drive.mcap");
    assert!(
        first.err.contains("guide.mission.reached >= 1u at "),
        "{}",
        first.err
    );
    let summary = json(&first.out);
    let files = summary["recording"]["files"].as_array().unwrap();
    assert!(!files.is_empty());
    for (index, file) in files.iter().enumerate() {
        let path = folder.path().join(format!("a/drive-{:03}.mcap", index + 1));
        let recording = Recording::open(&path).unwrap();
        assert_eq!(recording.damage(), None);
        let messages: Vec<RecordedMessage> = recording.messages().unwrap().map(Result::unwrap).collect();
        assert_eq!(file["kept"], messages.len());
        assert_eq!(file["lost"], 0);
        let start: u64 = recording.metadata("jde").unwrap()["start_ns"].parse().unwrap();
        let fired = (file["time_s"].as_f64().unwrap() * 1e9).round() as u64;
        assert!(messages[0].log_time - start >= fired.saturating_sub(2_000_000_000));
        assert!(on_topic(&messages, "/guide/mission").is_empty());
        assert_eq!(
            on_topic(&messages, "/goon/period").len(),
            1,
            "written once, before the start"
        );
        assert!(!on_topic(&messages, "/pioneer/laser").is_empty());
    }
    let again = json(&run("b/drive.mcap").out);
    let recorded_files = |summary: &serde_json::Value| {
        let files = summary["recording"]["files"].as_array().unwrap().clone();
        let file = |file: &serde_json::Value| {
            (
                file["reason"].clone(),
                file["time_s"].clone(),
                file["kept"].clone(),
            )
        };
        files.iter().map(file).collect::<Vec<_>>()
    };
    assert_eq!(recorded_files(&summary), recorded_files(&again));
}

#[test]
fn an_invalid_condition_is_reported_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.mcap");
    for (condition, error) in [
        (
            "pioneer.lasr.range_max > 1.0",
            "column 1: no variable is called `pioneer.lasr`; did you mean `pioneer.laser`?",
        ),
        (
            "conflict:guide/bas",
            "column 10: no group is called `guide/bas`; did you mean `guide/base`?",
        ),
        ("goon.period >", "column 14: mismatched input the end"),
    ] {
        let refused = output_of(&mut jde_with_plugins(&[
            "run",
            &app("room.toml"),
            "--lockstep",
            "--record",
            file.to_str().unwrap(),
            "--when",
            condition,
        ]));
        assert_eq!(refused.status, Some(2), "{}", refused.err);
        assert!(refused.err.contains(error), "{}", refused.err);
        assert!(refused.err.contains("chatter>N"), "{}", refused.err);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn info_describes_complete_and_damaged_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.mcap");
    let name = file.to_str().unwrap();
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app("room.toml"),
        "--lockstep",
        "--json",
        "--seed",
        "7",
        "--record",
        name,
    ]));
    let kept = json(&run.out)["recording"]["kept"].clone();
    let complete = output_of(&mut jde(&["info", name]));
    assert_eq!((complete.status, complete.err.as_str()), (Some(0), ""));
    for part in [
        "drive.mcap: room, ",
        "seed 7",
        "with room.toml",
        "/pioneer/laser ",
        "sensor_msgs/msg/LaserScan",
        " Hz ",
        "guide/base: ",
        " switches",
    ] {
        assert!(complete.out.contains(part), "{part}: {}", complete.out);
    }
    let info = json(&output_of(&mut jde(&["info", name, "--json"])).out);
    assert_eq!(
        (&info["application"], &info["seed"], &info["messages"]),
        (&"room".into(), &7.into(), &kept)
    );
    assert_eq!(info["damage"], serde_json::Value::Null);

    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let cut = output_of(&mut jde(&["info", name]));
    assert_eq!(cut.status, Some(0));
    assert!(
        cut.out.contains("damaged at byte ") && cut.out.contains("it can be read up to "),
        "{}",
        cut.out
    );
    std::fs::write(&file, "no recording").unwrap();
    let none = output_of(&mut jde(&["info", name]));
    assert_eq!((none.status, none.out.as_str()), (Some(2), ""));
    assert!(
        none.err.contains("is no MCAP file and no bag of ROS 2"),
        "{}",
        none.err
    );
}

#[test]
fn r19_a_recording_shows_the_end_of_a_value_by_its_validity() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let eye =
        "\n[schemas.eye]\ntype = \"fault/eye\"\nperiod = \"50ms\"\nimports = { input = \"pioneer.laser\" }\n";
    let room = std::fs::read_to_string(app("room.toml")).unwrap();
    let room = room.replace("roots   = [", "roots   = [\"watch\", ");
    let watch = "\n[schemas.watch]\ntype = \"stop\"\nimports = { laser = \"eye.laser\" }\nactuators = { base = \"pioneer.velocity\" }\n";
    write("app.toml", format!("{room}{eye}{watch}"));
    write(
        "room-world.toml",
        std::fs::read_to_string(app("room-world.toml")).unwrap(),
    );
    let steps = "application = \"app.toml\"\nfor = \"3s\"\nmission = \"ignored\"\n\
                 [[steps]]\nat = \"1s\"\nset = { \"eye.trouble\" = \"silence\" }\n";
    write("silent.toml", steps.to_owned());
    let run = output_of(
        jde_with_plugins(&[
            "experiment",
            "silent.toml",
            "--drive",
            "0",
            "--record",
            "run.mcap",
        ])
        .current_dir(&folder),
    );
    assert_eq!(run.status, Some(0), "{}", run.err);
    let recording = Recording::open(&folder.path().join("run.mcap")).unwrap();
    let messages: Vec<RecordedMessage> = recording.messages().unwrap().map(Result::unwrap).collect();
    let last = on_topic(&messages, "/eye/laser").last().unwrap().log_time;
    let ends = on_topic(&messages, "/jde/events").into_iter().filter(|message| {
        record::read(message).is_some_and(|record| record.retracted_variable() == Some("eye.laser"))
    });
    let ends: Vec<u64> = ends.map(|end| end.log_time - last).collect();
    // Three periods of the eye, and the first instant at which the value has ended.
    assert_eq!(ends, [150_000_001]);
}
