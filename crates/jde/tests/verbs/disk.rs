//! Recordings on disks that fail or fill up: the error is reported, the loss counted, and the exit status
//! set. The disk is a library that is loaded before the system's (`tests/c/disk.c`), so that the tests need
//! no root.

use std::path::Path;
use std::process::Command;

use jde_log::Recording;

use crate::support::{Said, app, jde_with_plugins, json, said};

/// Records a run on a disk that behaves as `how` states, an environment variable and its value.
fn record(folder: &Path, how: (&str, &str), more: &[&str]) -> Said {
    let disk = folder.join("disk.so");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/c/disk.c");
    let made = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-o"])
        .args([&disk, Path::new(source)])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let (app, file) = (app("room.toml"), folder.join("drive.mcap"));
    let mut args = vec!["run", &app, "--lockstep", "--json", "--record"];
    args.push(file.to_str().expect("a path of a test"));
    args.extend(more);
    said(jde_with_plugins(&args).env("LD_PRELOAD", &disk).env(how.0, how.1))
}

/// Checks that the disk's error was reported, the loss counted, and the exit status set although the mission
/// is done.
fn is_told(run: &Said, words: &str) {
    assert_eq!(run.status, Some(1), "{}", run.err);
    assert!(run.err.contains(words), "{}", run.err);
    assert!(run.err.contains("ends too soon"), "{}", run.err);
    assert!(!run.err.contains("nothing lost"), "{}", run.err);
    let summary = json(&run.out);
    assert_eq!(summary["outcome"], "done");
    let recording = &summary["recording"];
    assert!(recording["lost"].as_u64() > Some(0), "{recording}");
    assert!(
        recording["trouble"]
            .as_str()
            .is_some_and(|trouble| trouble.contains(words)),
        "{recording}"
    );
}

#[test]
fn a_disk_that_could_not_keep_what_it_took_is_told_once_and_believed() {
    for more in [
        &[][..],
        &["--when", "operator", "--when", "guide.mission.reached >= 1u"],
    ] {
        let folder = tempfile::tempdir().unwrap();
        // The only sync of such a short run, or the first of several.
        let run = record(folder.path(), ("DISK_BAD_SYNC", "1"), more);
        is_told(&run, "Input/output error");
    }
}

#[test]
fn a_disk_that_fills_is_told_counted_and_in_the_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), ("DISK_ROOM", "60000"), &[]);
    is_told(&run, "No space left");
    let recording = Recording::open(&folder.path().join("drive.mcap")).unwrap();
    assert!(recording.damage().is_some());
    let read = recording.messages().unwrap().map(Result::unwrap).count() as u64;
    assert!(json(&run.out)["recording"]["kept"].as_u64() <= Some(read));
}

#[test]
fn a_disk_that_does_its_work_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), ("DISK_BAD_SYNC", "0"), &[]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(run.err.contains("nothing lost"), "{}", run.err);
}
