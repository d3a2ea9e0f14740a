//! Recordings on disks that fail or fill up: `jde run` reports the error, counts the lost messages and sets
//! the exit status. A preloaded library simulates the disk (`tests/c/disk.c`), so the tests need no root.

use std::path::Path;
use std::process::Command;

use jde_log::Recording;

use crate::support::{RunOutput, app, jde_with_plugins, json, output_of};

/// Records a run on a disk that an environment variable and its value make fail.
fn record(folder: &Path, failure: (&str, &str), options: &[&str]) -> RunOutput {
    let disk = folder.join("disk.so");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/c/disk.c");
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-o"])
        .args([&disk, Path::new(source)])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
    let (app, file) = (app("room.toml"), folder.join("drive.mcap"));
    let mut args = vec!["run", &app, "--lockstep", "--json", "--record"];
    args.push(file.to_str().expect("the path is UTF-8"));
    args.extend(options);
    output_of(
        jde_with_plugins(&args)
            .env("LD_PRELOAD", &disk)
            .env(failure.0, failure.1),
    )
}

/// Checks the reported error, the count of lost messages, and the exit status of a run that completes its
/// mission.
fn check_loss_is_reported(run: &RunOutput, error: &str) {
    assert_eq!(run.status, Some(1), "{}", run.err);
    assert!(run.err.contains(error), "{}", run.err);
    // It goes on if the disk accepts a new file before the run ends.
    let said = ["ends too soon", "goes on; nothing is recorded from"];
    assert!(said.iter().any(|said| run.err.contains(said)), "{}", run.err);
    assert!(!run.err.contains("nothing lost"), "{}", run.err);
    let summary = json(&run.out);
    assert_eq!(summary["outcome"], "done");
    let recording = &summary["recording"];
    assert!(recording["lost"].as_u64() > Some(0), "{recording}");
    let reasons = [&recording["trouble"], &recording["parts"]["gaps"][0]["reason"]];
    assert!(
        reasons
            .iter()
            .any(|reason| reason.as_str().is_some_and(|reason| reason.contains(error))),
        "{recording}"
    );
}

#[test]
fn a_failed_sync_makes_the_run_fail() {
    for options in [
        &[][..],
        &["--when", "operator", "--when", "guide.mission.reached >= 1u"],
    ] {
        let folder = tempfile::tempdir().unwrap();
        // The only sync of such a short run, or the first of several.
        let run = record(folder.path(), ("DISK_BAD_SYNC", "1"), options);
        check_loss_is_reported(&run, "Input/output error");
    }
}

#[test]
fn a_full_disk_makes_the_run_fail_and_lost_messages_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), ("DISK_ROOM", "60000"), &[]);
    check_loss_is_reported(&run, "No space left");
    let recording = Recording::open(&folder.path().join("drive.mcap")).unwrap();
    assert!(recording.damage().is_some());
    let read = recording.messages().unwrap().map(Result::unwrap).count() as u64;
    assert!(json(&run.out)["recording"]["kept"].as_u64() <= Some(read));
}

#[test]
fn a_disk_without_failures_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), ("DISK_BAD_SYNC", "0"), &[]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(run.err.contains("nothing lost"), "{}", run.err);
}
