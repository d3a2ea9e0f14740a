//! `jde replay`: tools read a recording as if it were a running application.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use serde_json::Value;

use crate::attached::{Sandbox, schema};
use crate::support::{jde, jde_with_plugins, output_of, root};
use crate::terminal::Terminal;

/// Records half a minute of the demonstration.
fn record(folder: &Path) -> PathBuf {
    let file = folder.join("drive.mcap");
    let name = file.to_str().expect("the path is UTF-8");
    let run = [
        "run",
        "safe-navigation",
        "--lockstep",
        "--for",
        "30s",
        "--record",
        name,
    ];
    let output = output_of(jde_with_plugins(&run).current_dir(root()));
    assert!(file.is_file(), "{output:?}");
    file
}

fn position(sandbox: &Sandbox) -> f64 {
    sandbox.json(&["get", "replay.position"])["value"]
        .as_f64()
        .expect("a number")
}

#[test]
fn tools_read_a_recording_and_control_its_playback() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let _replay = sandbox.replay(&file, &["--paused", "--from", "19s"]);
    assert_eq!(sandbox.apps(), ["safe-navigation"]);
    sandbox.until(&["get", "replay.position"], |now| now["value"] == 19.0);
    let ps = sandbox.json(&["ps"]);
    assert_eq!(schema(&ps, "example")["state"], "winner");
    assert_eq!(schema(&ps, "goon")["period"], 75_000_000);
    let pose = sandbox.json(&["get", "pioneer.odometry.pose.pose.position.x"]);
    assert!(pose["value"].is_number(), "{pose}");
    // A step moves to the next takeover.
    sandbox.run_ok(&["set", "replay.step", "true"]);
    let stepped = sandbox.until(&["get", "replay.position"], |now| now["value"] != 19.0);
    assert!(stepped["value"].as_f64() > Some(19.0), "{stepped}");
    let why = sandbox.json(&["why", "at", &format!("{}s", position(&sandbox))]);
    assert_eq!(why["decision"]["changed"], true);
    sandbox.run_ok(&["set", "replay.position", "5"]);
    sandbox.until(&["get", "replay.position"], |now| now["value"] == 5.0);
    sandbox.run_ok(&["set", "replay.speed", "20"]);
    sandbox.run_ok(&["set", "replay.paused", "false"]);
    sandbox.until(&["get", "replay.position"], |now| {
        now["value"].as_f64() > Some(15.0)
    });
}

#[test]
fn schemas_in_a_recording_cannot_be_operated() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let _replay = sandbox.replay(&file, &["--paused"]);
    for (args, reason) in [
        (&["stop", "goon"][..], "this is a recording"),
        (&["set", "goon.fast", "1"], "this is a recording"),
        (&["set", "replay.speed", "1000"], "0.01 to 100"),
        (&["set", "replay.position", "31"], "not 31"),
        (&["set", "replay.sped", "1"], "did you mean `replay.speed`?"),
    ] {
        let output = sandbox.run(args);
        assert_eq!(output.status, Some(2), "{args:?}: {output:?}");
        assert!(output.err.contains(reason), "{args:?}: {output:?}");
    }
}

#[test]
fn playback_ends_at_the_end_or_at_the_damage_of_a_recording() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let whole = sandbox.run_ok(&["replay", file.to_str().unwrap(), "--plain", "--speed", "100x"]);
    assert!(whole.contains("playing") && whole.contains("30.0 s"), "{whole}");
    let half = std::fs::metadata(&file).unwrap().len() / 2;
    std::fs::File::options()
        .write(true)
        .open(&file)
        .unwrap()
        .set_len(half)
        .unwrap();
    let cut = sandbox.run_ok(&["replay", file.to_str().unwrap(), "--plain", "--speed", "100x"]);
    assert!(cut.contains("it ends too soon, at byte"), "{cut}");
    std::fs::write(&file, "no recording").unwrap();
    let none = sandbox.run(&["replay", file.to_str().unwrap(), "--plain"]);
    assert_eq!(none.status, Some(2));
    assert!(
        none.err.contains("is no MCAP file and no bag of ROS 2"),
        "{none:?}"
    );
}

#[test]
fn watch_prints_the_recorded_values() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let _replay = sandbox.replay(&file, &["--loop"]);
    let output = sandbox.run_ok(&["watch", "pioneer.odometry", "--count", "3", "--json"]);
    for line in output.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        assert!(
            line["value"]["pose"]["pose"]["position"]["x"].is_number(),
            "{line}"
        );
        assert!(line["time_s"].as_f64() <= Some(30.0), "{line}");
    }
}

#[test]
fn until_eof_ends_the_replay_when_standard_input_is_closed() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let file = file.to_str().expect("the path is UTF-8");
    let mut replay = sandbox.command(jde(&["replay", "--plain", "--stay", "--until-eof", file]));
    let mut replay = replay
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("the executable starts");
    while sandbox.apps().is_empty() {
        let ended = replay.try_wait().expect("the process can be polled");
        assert!(ended.is_none(), "the process ended early: {ended:?}");
    }
    drop(replay.stdin.take());
    let ended = replay.wait().expect("the process ends");
    assert!(ended.success(), "{ended}");
}

#[test]
fn the_screen_shows_every_schema_with_its_state_and_the_keys() {
    let sandbox = Sandbox::new();
    let file = record(sandbox.folder());
    let command = format!(
        "{} replay {} --paused --from 3s",
        env!("CARGO_BIN_EXE_jde"),
        file.display()
    );
    let mut terminal = Terminal::start(&sandbox, [24, 80], &command);
    // Blanks are not drawn, so each is one word.
    for word in ["perception", "pioneer", "running", "goon"] {
        terminal.wait_for(|shown| shown.contains(word));
    }
    terminal.type_keys(b"?");
    terminal.wait_for(|shown| shown.contains("twice"));
    terminal.type_keys(b"xq");
    let (status, shown) = terminal.finish();
    assert_eq!(status, Some(0), "{shown}");
}
