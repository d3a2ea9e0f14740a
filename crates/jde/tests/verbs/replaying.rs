//! `jde replay --decide` as a user meets it: a drive that is decided as it was, one that is not, and what cannot be replayed.

use std::fs;
use std::path::Path;

use crate::support::{Said, app, jde_with_plugins, json, said};

/// Records a drive, in lockstep.
fn recorded(folder: &Path, more: &[&str]) -> String {
    let file = folder.join("drive.mcap").display().to_string();
    let room = app("room.toml");
    let mut run = vec!["run", &room, "--lockstep", "--record", &file];
    run.extend(more);
    let run = said(&mut jde_with_plugins(&run));
    assert_eq!(run.status, Some(0), "{}", run.err);
    file
}

fn replay(file: &str, more: &[&str]) -> Said {
    let mut replay = vec!["replay", "--decide", file];
    replay.extend(more);
    said(&mut jde_with_plugins(&replay))
}

#[test]
fn r16_a_drive_that_is_decided_as_it_was_is_success() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path(), &[]);
    let same = replay(&file, &["--json"]);
    assert_eq!(same.status, Some(0), "{}", same.err);
    let verdict = json(&same.out);
    assert_eq!(
        (&verdict["different"], &verdict["lockstep"]),
        (&0.into(), &true.into())
    );
    assert!(verdict["same"].as_u64().unwrap() > 10, "{verdict}");
    assert!(same.err.contains("selections are as they were"), "{}", same.err);
    assert!(!same.err.contains('\r'), "in a pipe it is plain");
    assert!(!same.err.contains("differs"), "{}", same.err);
}

#[test]
fn what_was_set_for_the_recorded_run_is_in_force_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path(), &["--set", "goon.fast=0.3 m/s"]);
    let same = replay(&file, &[]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    // The file alone does not have it.
    let room = replay(&file, &["--app", &app("room.toml")]);
    assert!(
        room.out.contains("differs: goon.fast starts with"),
        "{}",
        room.out
    );
}

#[test]
fn a_changed_constant_is_found_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path(), &[]);
    let set = ["--set", "vff.ahead=0.5 m"];
    let different = replay(&file, &set);
    assert_eq!(different.status, Some(1), "{}{}", different.out, different.err);
    let words = &different.out;
    assert!(words.contains("differs: vff.ahead starts with 0.5"), "{words}");
    for part in [
        "then ",
        "now ",
        "saw laser (value ",
        "selections are not as they were",
    ] {
        assert!(words.contains(part), "`{part}` is not in:\n{words}");
    }
    let verdict = json(&replay(&file, &[&set[..], &["--json"]].concat()).out);
    let first = &verdict["first"][0];
    assert!(first["recorded"]["reason"].is_string() || first["replayed"]["reason"].is_string());
    assert!(verdict["different"].as_u64().unwrap() > 0);
    // Nothing is compared before the first of them.
    let time = first["time_s"].as_f64().unwrap();
    let until = format!("{}ms", (time * 1e3).floor() - 1.0);
    let same = replay(&file, &[&set[..], &["--to", &until]].concat());
    assert_eq!(same.status, Some(0), "{}", same.out);
}

#[test]
fn a_recording_that_was_cut_off_is_replayed_up_to_the_damage() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path(), &[]);
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let same = replay(&file, &[]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    assert!(same.out.contains("damaged: it ends too soon"), "{}", same.out);
}

#[test]
fn what_cannot_be_replayed_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path(), &["--record-only", "*.odometry"]);
    let lacks = replay(&file, &[]);
    assert_eq!(lacks.status, Some(2), "{}", lacks.err);
    assert!(
        lacks.err.contains(".laser` is not in it, and schemas import it"),
        "{}",
        lacks.err
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
    assert!(none.err.contains("cannot read nowhere.mcap"), "{}", none.err);

    let text = folder.path().join("text.mcap");
    fs::write(&text, "no recording").unwrap();
    let other = replay(text.to_str().unwrap(), &[]);
    assert_eq!(other.status, Some(2), "{}", other.err);
    assert!(other.err.contains("is no MCAP file"), "{}", other.err);
}
