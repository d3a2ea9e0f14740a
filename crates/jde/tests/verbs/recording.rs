//! `jde run --record` as a user meets it: what is in the file, what is said of it, and what is refused.

use std::collections::BTreeSet;

use jde_log::{Message, Recording};
use jde_ros::cdr;
use jde_types::{LaserScan, Mission, Value};

use crate::support::{app, jde_with_plugins, json, said};

/// The messages of a topic.
fn of<'m>(messages: &'m [Message], topic: &str) -> Vec<&'m Message> {
    let of_topic = messages.iter().filter(|message| message.channel.topic == topic);
    of_topic.collect()
}

fn value<T: Value>(message: &Message) -> T {
    let bytes = cdr::decode(&T::describe(), &message.data).expect("the message is of that type");
    T::from_bytes(&bytes).expect("as many bytes as the type has")
}

#[test]
fn r15_r16_a_run_in_lockstep_is_recorded_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (file, decisions) = (
        folder.path().join("deep/run.mcap"),
        folder.path().join("decisions"),
    );
    let run = said(&mut jde_with_plugins(&[
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
    let messages: Vec<Message> = recording.messages().unwrap().map(Result::unwrap).collect();
    assert_eq!(summary["recording"]["kept"], messages.len());
    assert_eq!(summary["recording"]["lost"], 0);
    let start: u64 = recording.metadata("jde").unwrap()["start_ns"].parse().unwrap();

    let decided: Vec<u8> = of(&messages, "/jde/decisions")
        .iter()
        .flat_map(|message| [message.data.as_slice(), b"\n"].concat())
        .collect();
    assert_eq!(
        decided,
        std::fs::read(&decisions).unwrap(),
        "the same decisions, in their order"
    );

    let scans = of(&messages, "/pioneer/laser");
    assert_eq!(scans[0].channel.type_name, "sensor_msgs/msg/LaserScan");
    for (place, message) in scans.iter().enumerate() {
        assert_eq!(
            message.sequence as usize,
            place + 1,
            "from the first value on, without a gap"
        );
        let scan: LaserScan = value(message);
        assert_eq!(scan.ranges.len(), 180);
        let stamp = std::time::Duration::from(scan.header.stamp);
        assert_eq!(u128::from(message.log_time - start), stamp.as_nanos());
    }
    let missions = of(&messages, "/guide/mission");
    let last: Mission = value(missions.last().unwrap());
    assert_eq!(summary["reached"], last.reached);
    let ended: serde_json::Value =
        serde_json::from_slice(&of(&messages, "/jde/events").last().unwrap().data).unwrap();
    assert_eq!(ended["kind"], "ended");
    assert!(!of(&messages, "/jde/states").is_empty());
}

#[test]
fn patterns_choose_the_variables() {
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
        said(&mut jde_with_plugins(&args))
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
fn what_cannot_be_recorded_is_said_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    std::fs::write(&file, "precious").unwrap();
    let record = |file: &str| {
        let app = app("room.toml");
        said(&mut jde_with_plugins(&[
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
