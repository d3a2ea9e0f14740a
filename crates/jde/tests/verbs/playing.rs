//! `jde replay` as a user sees it: a recording that tools can read like a running application.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use serde_json::Value;

use crate::attached::{Place, schema};
use crate::support::{jde, jde_with_plugins, root, said};

/// Records half a minute of the demonstration.
fn record(folder: &Path) -> PathBuf {
    let file = folder.join("drive.mcap");
    let name = file.to_str().expect("a name in UTF-8");
    let run = [
        "run",
        "safe-navigation",
        "--lockstep",
        "--for",
        "30s",
        "--record",
        name,
    ];
    let said = said(jde_with_plugins(&run).current_dir(root()));
    assert!(file.is_file(), "{said:?}");
    file
}

fn position(place: &Place) -> f64 {
    place.json(&["get", "replay.position"])["value"]
        .as_f64()
        .expect("a number")
}

#[test]
fn a_recording_is_looked_into_and_steered() {
    let place = Place::new();
    let file = record(place.folder());
    let _replay = place.replay(&file, &["--paused", "--from", "19s"]);
    assert_eq!(place.apps(), ["safe-navigation"]);
    place.until(&["get", "replay.position"], |now| now["value"] == 19.0);
    let ps = place.json(&["ps"]);
    assert_eq!(schema(&ps, "example")["state"], "winner");
    assert_eq!(schema(&ps, "goon")["period"], 75_000_000);
    let pose = place.json(&["get", "pioneer.odometry.pose.pose.position.x"]);
    assert!(pose["value"].is_number(), "{pose}");
    // Playback is paused. A step moves to the next takeover and no further.
    place.told(&["set", "replay.step", "true"]);
    let stepped = place.until(&["get", "replay.position"], |now| now["value"] != 19.0);
    assert!(stepped["value"].as_f64() > Some(19.0), "{stepped}");
    let why = place.json(&["why", "at", &format!("{}s", position(&place))]);
    assert_eq!(why["decision"]["changed"], true);
    // Back, and on at another speed.
    place.told(&["set", "replay.position", "5"]);
    place.until(&["get", "replay.position"], |now| now["value"] == 5.0);
    place.told(&["set", "replay.speed", "20"]);
    place.told(&["set", "replay.paused", "false"]);
    place.until(&["get", "replay.position"], |now| {
        now["value"].as_f64() > Some(15.0)
    });
}

#[test]
fn what_was_done_cannot_be_changed() {
    let place = Place::new();
    let file = record(place.folder());
    let _replay = place.replay(&file, &["--paused"]);
    for (args, why) in [
        (&["stop", "goon"][..], "this is a recording"),
        (&["set", "goon.fast", "1"], "this is a recording"),
        (&["set", "replay.speed", "1000"], "0.01 to 100"),
        (&["set", "replay.position", "31"], "not 31"),
        (&["set", "replay.sped", "1"], "did you mean `replay.speed`?"),
    ] {
        let said = place.says(args);
        assert_eq!(said.status, Some(2), "{args:?}: {said:?}");
        assert!(said.err.contains(why), "{args:?}: {said:?}");
    }
}

#[test]
fn it_plays_to_its_end_and_up_to_where_it_is_damaged() {
    let place = Place::new();
    let file = record(place.folder());
    let whole = place.told(&["replay", file.to_str().unwrap(), "--plain", "--speed", "100x"]);
    assert!(whole.contains("playing") && whole.contains("30.0 s"), "{whole}");
    let half = std::fs::metadata(&file).unwrap().len() / 2;
    std::fs::File::options()
        .write(true)
        .open(&file)
        .unwrap()
        .set_len(half)
        .unwrap();
    let cut = place.told(&["replay", file.to_str().unwrap(), "--plain", "--speed", "100x"]);
    assert!(cut.contains("it ends too soon, at byte"), "{cut}");
    std::fs::write(&file, "no recording").unwrap();
    let none = place.says(&["replay", file.to_str().unwrap(), "--plain"]);
    assert_eq!(none.status, Some(2));
    assert!(none.err.contains("is no MCAP file"), "{none:?}");
}

#[test]
fn whoever_watches_sees_the_values_of_then() {
    let place = Place::new();
    let file = record(place.folder());
    let _replay = place.replay(&file, &["--loop"]);
    let told = place.told(&["watch", "pioneer.odometry", "--count", "3", "--json"]);
    for line in told.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        assert!(
            line["value"]["pose"]["pose"]["position"]["x"].is_number(),
            "{line}"
        );
        assert!(line["time_s"].as_f64() <= Some(30.0), "{line}");
    }
}

#[test]
fn it_ends_with_whoever_started_it_if_asked_to() {
    let place = Place::new();
    let file = record(place.folder());
    let file = file.to_str().expect("a name in UTF-8");
    let mut replay = place.command(jde(&["replay", "--plain", "--stay", "--until-eof", file]));
    let mut replay = replay
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("the executable starts");
    while place.apps().is_empty() {
        let ended = replay.try_wait().expect("it can be asked");
        assert!(ended.is_none(), "it ended at once: {ended:?}");
    }
    drop(replay.stdin.take());
    let ended = replay.wait().expect("it can be waited for");
    assert!(ended.success(), "{ended}");
}
