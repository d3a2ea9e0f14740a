//! `jde replay --decide`: equal and different selections and values, and recordings that cannot be replayed.

use std::fs;
use std::path::Path;
use std::process::Stdio;

use crate::damaged::library;
use crate::support::{RunOutput, app, jde_with_plugins, json, output_of, root};
use jde_watchdog::Watchdog;

/// Records a drive in lockstep.
fn record(folder: &Path, options: &[&str]) -> String {
    let file = folder.join("drive.mcap").display().to_string();
    let room = app("room.toml");
    let mut run = vec!["run", &room, "--lockstep", "--record", &file];
    run.extend(options);
    let run = output_of(&mut jde_with_plugins(&run));
    assert_eq!(run.status, Some(0), "{}", run.err);
    file
}

fn replay(file: &str, options: &[&str]) -> RunOutput {
    let mut replay = vec!["replay", "--decide", file];
    replay.extend(options);
    output_of(&mut jde_with_plugins(&replay))
}

#[test]
fn r16_a_replay_with_the_same_selections_and_values_succeeds() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let same = replay(&file, &["--json"]);
    assert_eq!(same.status, Some(0), "{}", same.err);
    let verdict = json(&same.out);
    assert_eq!(
        (&verdict["different"], &verdict["lockstep"]),
        (&0.into(), &true.into())
    );
    assert!(verdict["same"].as_u64().unwrap() > 10, "{verdict}");
    assert!(
        same.err.contains(" selections and ") && same.err.contains(" values equal the recorded ones"),
        "{}",
        same.err
    );
    assert_eq!(verdict["values"]["different"], 0);
    assert!(verdict["values"]["same"].as_u64().unwrap() > 100, "{verdict}");
    assert!(!same.err.contains('\r'), "no progress line in a pipe");
    assert!(!same.err.contains("differs"), "{}", same.err);
}

#[test]
fn r18_a_replay_repeats_the_refusals_of_a_guard_with_their_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("guarded.mcap").display().to_string();
    let app = root().join("apps/guard.toml").display().to_string();
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app,
        "--lockstep",
        "--for",
        "20s",
        "--record",
        &file,
    ]));
    assert_eq!(run.status, Some(0), "{}", run.err);
    let same = replay(&file, &["--json"]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    let why = output_of(&mut jde_with_plugins(&["why", "--in", &file]));
    assert!(
        why.out.contains("command refused by the guard"),
        "{}{}",
        why.out,
        why.err
    );
}

#[test]
fn a_replay_uses_the_values_set_for_the_recorded_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &["--set", "goon.fast=0.3 m/s"]);
    let same = replay(&file, &[]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    // The application's file does not contain the value given by --set.
    let room = replay(&file, &["--app", &app("room.toml")]);
    assert!(
        room.out.contains("differs: goon.fast starts with"),
        "{}",
        room.out
    );
}

#[test]
fn a_replay_reports_the_first_selection_that_a_changed_value_alters() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let set = ["--set", "vff.ahead=0.5 m"];
    let different = replay(&file, &set);
    assert_eq!(different.status, Some(1), "{}{}", different.out, different.err);
    let output = &different.out;
    assert!(output.contains("differs: vff.ahead starts with 0.5"), "{output}");
    for part in [
        "then ",
        "now ",
        "saw laser (value ",
        " values differ from the recorded ones",
    ] {
        assert!(output.contains(part), "`{part}` is not in:\n{output}");
    }
    let verdict = json(&replay(&file, &[&set[..], &["--json"]].concat()).out);
    let first = &verdict["first"][0];
    assert!(first["recorded"]["reason"].is_string() || first["replayed"]["reason"].is_string());
    assert!(verdict["different"].as_u64().unwrap() > 0);
    // Everything before the first difference is equal.
    let time = first["time_s"].as_f64().unwrap();
    let until = format!("{}ms", (time * 1e3).floor() - 1.0);
    let same = replay(&file, &[&set[..], &["--to", &until]].concat());
    assert_eq!(same.status, Some(0), "{}", same.out);
}

#[test]
fn a_reader_that_stops_does_not_turn_a_difference_into_success() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let _watchdog = Watchdog::for_test();
    let mut command = jde_with_plugins(&["replay", "--decide", &file, "--set", "vff.ahead=0.5 m"]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    // The output may end before the verdict is known, or after it.
    assert!(matches!(output.status.code(), Some(1 | 141)), "{output:?}");
}

#[test]
fn a_replay_reports_a_different_command_although_the_selections_are_equal() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    // The selections are the same as in the recording. Only the speed that goon commands differs.
    let set = ["--set", "goon.fast=0.39 m/s"];
    let different = replay(&file, &set);
    assert_eq!(different.status, Some(1), "{}{}", different.out, different.err);
    let equal = " values differ from the recorded ones, and ";
    assert!(
        different.out.contains(equal) && different.out.contains(" selections equal them, until "),
        "{}",
        different.out
    );
    let verdict = json(&replay(&file, &[&set[..], &["--json"]].concat()).out);
    assert_eq!(verdict["different"], 0, "{verdict}");
    let first = &verdict["values"]["first"][0];
    assert_eq!(
        (&first["schema"], &first["variable"], &first["field"]),
        (&"goon".into(), &"pioneer.velocity".into(), &"linear.x".into())
    );
    let number = |side: &str| first[side].as_str().unwrap().parse::<f64>().unwrap();
    assert!(number("then") != number("now"), "{first}");
    for side in ["then", "now"] {
        let line = format!("{side:<5} linear.x = {}", first[side].as_str().unwrap());
        assert!(
            different.out.contains(&line),
            "`{line}` is not in:\n{}",
            different.out
        );
    }
    let tolerant = replay(
        &file,
        &[&set[..], &["--tolerance", "geometry_msgs/msg/Twist=0.5"]].concat(),
    );
    assert_eq!(tolerant.status, Some(0), "{}{}", tolerant.out, tolerant.err);
    let other = replay(&file, &["--tolerance", "geometry_msgs/msg/Twits=0.5"]);
    assert_eq!(other.status, Some(2), "{}", other.err);
    assert!(
        other.err.contains("did you mean `geometry_msgs/msg/Twist`?"),
        "{}",
        other.err
    );
}

#[test]
fn a_truncated_recording_is_replayed_up_to_the_damage() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let same = replay(&file, &[]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    assert!(same.out.contains("damaged: it ends too soon"), "{}", same.out);
}

#[test]
fn a_replay_reports_why_a_recording_cannot_be_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &["--record-only", "*.odometry"]);
    let incomplete = replay(&file, &[]);
    assert_eq!(incomplete.status, Some(2), "{}", incomplete.err);
    assert!(
        incomplete
            .err
            .contains(".laser` is not in it, and schemas import it"),
        "{}",
        incomplete.err
    );

    let other = folder.path().join("app.toml");
    let text = fs::read_to_string(app("room.toml"))
        .unwrap()
        .replace("\"goon\"", "\"gone\"");
    fs::write(&other, text).unwrap();
    let missing = replay(&file, &["--app", other.to_str().unwrap()]);
    assert_eq!(missing.status, Some(3), "{}", missing.err);
    assert!(
        missing.err.contains("there is no plugin `gone`"),
        "{}",
        missing.err
    );

    let none = replay("nowhere.mcap", &[]);
    assert_eq!(none.status, Some(2), "{}", none.err);
    assert!(
        none.err.contains("nowhere.mcap: there is no such file"),
        "{}",
        none.err
    );

    let text = folder.path().join("text.mcap");
    fs::write(&text, "no recording").unwrap();
    let other = replay(text.to_str().unwrap(), &[]);
    assert_eq!(other.status, Some(2), "{}", other.err);
    assert!(
        other.err.contains("is no MCAP file and no bag of ROS 2"),
        "{}",
        other.err
    );
}

/// A recording names folders in three ways, and all may come from an untrusted source.
#[test]
fn a_replay_loads_plugins_from_the_folders_of_a_recording_only_with_trust() {
    let home = tempfile::tempdir().unwrap();
    let apps = home.path().join("apps");
    fs::create_dir_all(apps.join("lib")).unwrap();
    let world = app("room-world.toml");
    let text = fs::read_to_string(app("room.toml")).unwrap();
    let text = format!("plugins = [\"lib\"]\n{text}").replace("\"room-world.toml\"", &format!("\"{world}\""));
    let application = apps.join("room.toml");
    fs::write(&application, text).unwrap();
    let file = home.path().join("drive.mcap").display().to_string();
    let run = [
        "run",
        application.to_str().unwrap(),
        "--lockstep",
        "--record",
        &file,
    ];
    let run = output_of(&mut jde_with_plugins(&run));
    assert_eq!(run.status, Some(0), "{}", run.err);

    // Each of the folders now contains a library that creates the file `mark` when it is loaded.
    let mark = home.path().join("mark");
    let create_mark = format!("fclose(fopen(\"{}\", \"w\"));", mark.display());
    for folder in [apps.join("lib"), apps.clone(), home.path().to_owned()] {
        library(&folder, "goon", &create_mark);
    }
    let replay = |options: &[&str]| {
        let mut args = vec!["replay", "--decide", &file];
        args.extend(options);
        output_of(jde_with_plugins(&args).current_dir(home.path()))
    };
    let same = replay(&[]);
    assert_eq!(same.status, Some(0), "{same:?}");
    assert!(
        same.out.contains("not trusted: plugins were not searched for in"),
        "{same:?}"
    );
    assert!(!mark.exists());

    let trusted = replay(&["--trust"]);
    assert_eq!(
        trusted.status,
        Some(2),
        "the other plugin lacks the type: {trusted:?}"
    );
    assert!(mark.exists());

    fs::remove_file(&mark).unwrap();
    fs::rename(&apps, home.path().join("moved")).unwrap();
    for options in [&[][..], &["--trust"]] {
        let same = replay(options);
        assert_eq!(same.status, Some(0), "{same:?}");
        assert!(!mark.exists(), "the working directory is not searched");
    }
}
