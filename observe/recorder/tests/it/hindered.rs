//! Recordings that the disk, or the files of others, hinder: they go on, and say what is missing.

use std::os::unix::fs::symlink;
use std::path::Path;

use jde_log::{ReadError, Recording};
use jde_recorder::{PartSize, Recorder, Trouble};
use jde_watchdog::Watchdog;

use crate::split::{Drive, SECOND, drive, read, sequences, split};
use crate::support::{options, with_troubles};

/// Creates a file that is there and that nobody can read.
fn unreadable(path: &Path) {
    symlink("/proc/self/mem", path).unwrap();
    assert!(path.is_file() && std::fs::read(path).is_err());
}

#[test]
fn a_part_that_cannot_be_deleted_is_reported_once_and_the_recording_goes_on() {
    let (folder, path, _) = drive(5, split(PartSize::Time(10 * SECOND), None));
    let first = folder.path().join("drive-001.mcap");
    let (options, troubles) = with_troubles("endless", true);
    let limited = split(PartSize::Time(10 * SECOND), Some(120_000));
    let mut next = Drive::of(Recorder::create_split(&path, options, limited).unwrap());
    // No user can delete a folder as a file.
    std::fs::remove_file(&first).unwrap();
    std::fs::create_dir(&first).unwrap();
    next.record(45);
    let status = next.recorder.finish();
    assert_eq!((status.lost, status.error), (0, None));
    let parts = status.parts.unwrap();
    assert_eq!((parts.count, parts.deleted), (5, 4), "{parts:?}");
    assert_eq!(parts.undeleted.keys().collect::<Vec<_>>(), [&first]);
    let troubles = troubles.lock();
    assert!(
        matches!(troubles.as_slice(), [Trouble::Undeleted { path, .. }] if *path == first),
        "{troubles:?}"
    );
    let overwriting = Drive::begin(&path, limited, true);
    assert_eq!(overwriting.recorder.finish().lost, 0);
}

#[test]
fn a_recording_goes_on_in_a_new_part_when_the_disk_accepts_one_again() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    let (inside, aside) = (folder.path().join("drives"), folder.path().join("aside"));
    let path = inside.join("drive.mcap");
    let (options, troubles) = with_troubles("endless", true);
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    let mut drive = Drive::of(Recorder::create_split(&path, options, ten_seconds).unwrap());
    drive.record(5);
    // No part can be created where a file has the name of the folder.
    std::fs::rename(&inside, &aside).unwrap();
    std::fs::write(&inside, "").unwrap();
    while troubles.lock().is_empty() {
        drive.record(1);
    }
    std::fs::remove_file(&inside).unwrap();
    std::fs::rename(&aside, &inside).unwrap();
    while drive.recorder.status().parts.unwrap().count < 2 {
        std::thread::yield_now();
    }
    drive.record(5);
    let status = drive.recorder.finish();
    let troubles = troubles.lock();
    let [Trouble::Interrupted { .. }, Trouble::Resumed(gap)] = troubles.as_slice() else {
        panic!("{troubles:?}");
    };
    let (until, lost) = (gap.until.unwrap(), gap.lost);
    assert!(gap.from <= 10 * SECOND && until > gap.from && lost > 0, "{gap:?}");
    assert_eq!((status.lost, &status.error), (lost, &None));
    assert_eq!(status.parts.unwrap().gaps, std::slice::from_ref(gap));

    let (recording, messages) = read(&path);
    assert_eq!(recording.gaps(), std::slice::from_ref(gap));
    assert_eq!(messages.len() as u64, status.written);
    let noise = sequences(&messages, "/pioneer/noise");
    assert_eq!(noise.len() as u64 + lost, drive.next - 1);
    assert_eq!(noise.last().copied().map(u64::from), Some(drive.next - 1));
    let stated = recording.metadata("jde/lost").unwrap();
    assert_eq!(stated["/pioneer/noise"], lost.to_string());
    let line = gap.to_string();
    assert!(line.starts_with("nothing is recorded from "), "{line}");
}

#[test]
fn a_recording_in_one_file_is_no_part_of_another_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let (named, path) = (
        folder.path().join("drive-001.mcap"),
        folder.path().join("drive.mcap"),
    );
    let whole = Recorder::create(&named, options("endless", true)).unwrap();
    assert_eq!(whole.finish().parts, None);
    let before = std::fs::read(&named).unwrap();
    let parts = Drive::begin(&path, split(PartSize::Time(10 * SECOND), Some(1)), true);
    let parts = parts.recorder.finish().parts.unwrap();
    assert_eq!(parts.first, folder.path().join("drive-002.mcap"));
    assert_eq!(std::fs::read(&named).unwrap(), before);
    let (recording, messages) = read(&named);
    assert_eq!((recording.first_part(), messages), (None, Vec::new()));
}

#[test]
fn files_that_cannot_be_read_are_named_and_left_out() {
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    let (folder, path, status) = drive(25, ten_seconds);
    let named = |name: &str| folder.path().join(name);
    unreadable(&named("drive-004.mcap"));
    std::fs::write(named("lost.mcap"), "").unwrap();
    for opened in [folder.path(), &named("drive-002.mcap")] {
        let (recording, messages) = read(opened);
        assert_eq!(messages.len() as u64, status.written, "{}", opened.display());
        let lines: Vec<_> = recording.left_out().lines().collect();
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].contains("drive-004.mcap is left out: "), "{lines:?}");
        assert!(
            lines[1].ends_with("lost.mcap is left out: it is no MCAP file"),
            "{lines:?}"
        );
    }
    assert_eq!(read(&path).1.len() as u64, status.written);

    // The name is in use, and the next recording has the next one.
    let mut next = Drive::begin(&path, ten_seconds, false);
    next.record(5);
    assert_eq!(
        next.recorder.finish().parts.unwrap().last,
        named("drive-005.mcap")
    );

    let alone = tempfile::tempdir().unwrap();
    let other = alone.path().join("other.mcap");
    unreadable(&other);
    for opened in [alone.path(), &other] {
        let refused = Recording::open(opened).err();
        assert!(
            matches!(&refused, Some(ReadError::File { path, .. }) if *path == other),
            "{refused:?}"
        );
    }
}
