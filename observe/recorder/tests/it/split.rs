//! Split recordings: whichever part is opened, the recording contains every message once. A single part
//! contains the values in force. The total size can be limited.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_log::{ReadError, RecordedMessage, Recording, Survey, log_line};
use jde_recorder::{PartSize, Recorder, RecorderOptions, SplitOptions, Stamps, Status, Topic};
use jde_records::RunRecord;
use jde_types::Value;
use jde_watchdog::Watchdog;

use crate::support;
use tempfile::TempDir;

pub(crate) const SECOND: u64 = 1_000_000_000;

pub(crate) fn split(part_size: PartSize, keep: Option<u64>) -> SplitOptions {
    SplitOptions {
        part_size,
        max_total_bytes: keep,
    }
}

fn stamps(number: u64, published: u64) -> Stamps {
    Stamps {
        published,
        measured: published.saturating_sub(1),
        sequence: number,
    }
}

/// Records a modulation that is written once, a value that is retracted, and ten incompressible values a
/// second.
pub(crate) struct Drive {
    pub(crate) recorder: Recorder,
    noise: Topic,
    retracted: Topic,
    pub(crate) next: u64,
    state: u64,
}

impl Drive {
    pub(crate) fn begin(path: &Path, split_options: SplitOptions, overwrite: bool) -> Self {
        let options = RecorderOptions {
            overwrite,
            ..support::options("endless", true)
        };
        Self::of(Recorder::create_split(path, options, split_options).unwrap())
    }

    pub(crate) fn of(recorder: Recorder) -> Self {
        let about = |variable: &str| BTreeMap::from([("variable".to_owned(), variable.to_owned())]);
        let number = Arc::new(u64::describe());
        let once = recorder.topic("/goon/speed", Arc::clone(&number), about("goon.speed"));
        let retracted = recorder.topic("/pose/pose", number, about("pose.pose"));
        let noise = recorder.topic(
            "/pioneer/noise",
            Arc::new(<[u64; 128]>::describe()),
            about("pioneer.noise"),
        );
        assert!(once.put(&7_u64.to_ne_bytes(), stamps(0, 0)));
        assert!(retracted.put(&1_u64.to_ne_bytes(), stamps(0, 0)));
        Self {
            recorder,
            noise,
            retracted,
            next: 1,
            state: 1,
        }
    }

    pub(crate) fn record(&mut self, seconds: u64) {
        for _ in 0..seconds * 10 {
            let mut bytes = Vec::new();
            for _ in 0..128 {
                self.state = self.state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                bytes.extend(self.state.rotate_left(29).to_le_bytes());
            }
            let time = self.next * SECOND / 10;
            assert!(self.noise.put(&bytes, stamps(self.next, time)));
            self.next += 1;
            if self.next == 15 {
                // A recorder that retracts values needs a topic of records.
                self.recorder.push_record(RunRecord::retracted(time, "nothing"));
                self.retracted.retract(time);
            }
        }
    }
}

/// Records a drive in a temporary folder.
pub(crate) fn drive(seconds: u64, split_options: SplitOptions) -> (TempDir, PathBuf, Status) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let mut drive = Drive::begin(&path, split_options, false);
    drive.record(seconds);
    let status = drive.recorder.finish();
    (folder, path, status)
}

pub(crate) fn read(path: &Path) -> (Recording, Vec<RecordedMessage>) {
    let recording = Recording::open(path).unwrap();
    assert_eq!(recording.damage(), None);
    let messages = recording.messages().unwrap().map(Result::unwrap).collect();
    (recording, messages)
}

pub(crate) fn sequences(messages: &[RecordedMessage], topic: &str) -> Vec<u32> {
    let on_topic = messages.iter().filter(|message| message.channel.topic == topic);
    on_topic.map(|message| message.sequence).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let listed = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = listed
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn parts_are_one_recording_whichever_path_is_opened() {
    let (folder, path, status) = drive(65, split(PartSize::Time(10 * SECOND), None));
    let parts = status.parts.clone().unwrap();
    assert_eq!((parts.count, parts.deleted, status.lost), (7, 0, 0));
    assert_eq!(parts.last, folder.path().join("drive-007.mcap"));
    assert_eq!(names(folder.path()).len(), 7);
    for opened in [
        folder.path(),
        &path,
        &parts.first,
        &folder.path().join("drive-004.mcap"),
    ] {
        let (recording, messages) = read(opened);
        assert_eq!(messages.len() as u64, status.written, "{}", opened.display());
        assert!(messages.is_sorted_by_key(|message| message.log_time));
        assert_eq!(sequences(&messages, "/pioneer/noise"), Vec::from_iter(1..=650));
        assert_eq!(sequences(&messages, "/goon/speed"), [0]);
        let survey = Survey::of(&recording).unwrap();
        let parts = survey.parts.unwrap();
        assert_eq!((parts.files.len(), parts.first, parts.missing), (7, 1, vec![]));
        assert!(parts.files.is_sorted());
        let lengths = recording.files().map(|file| file.metadata().unwrap().len());
        assert_eq!(survey.bytes, lengths.sum::<u64>());
        assert_eq!(survey.topics.len(), recording.channels().count());
    }
    let from: Vec<_> = Recording::open(&path)
        .unwrap()
        .messages_from(40 * SECOND)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(sequences(&from, "/pioneer/noise"), Vec::from_iter(400..=650));
}

#[test]
fn a_single_part_contains_the_values_in_force_at_its_beginning() {
    let (folder, ..) = drive(35, split(PartSize::Time(10 * SECOND), None));
    let other_folder = tempfile::tempdir().unwrap();
    for (number, in_force) in [(1, 0), (2, 1), (3, 1)] {
        let name = format!("drive-{number:03}.mcap");
        let part = other_folder.path().join("part.mcap");
        std::fs::copy(folder.path().join(name), &part).unwrap();
        let (recording, messages) = read(&part);
        assert_eq!(recording.first_part(), Some(number));
        let start = messages[0].log_time;
        let speed: Vec<_> = messages
            .iter()
            .filter(|message| message.channel.topic == "/goon/speed")
            .collect();
        assert_eq!(speed.len(), 1);
        assert_eq!((speed[0].log_time, speed[0].publish_time), (start, 0));
        // The pose is retracted in the first part.
        let poses = sequences(&messages, "/pose/pose").len();
        assert_eq!(poses, if in_force == 0 { 1 } else { 0 }, "part {number}");
    }
}

#[test]
fn a_part_does_not_begin_with_a_line_of_the_log_of_the_part_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let mut drive = Drive::begin(&path, split(PartSize::Time(10 * SECOND), None), false);
    let line = log_line::message(0, 30, "goon", "a warning");
    assert!(drive.recorder.log().put_message(&line, stamps(1, 0)));
    drive.record(25);
    drive.recorder.finish();
    let other_folder = tempfile::tempdir().unwrap();
    for (name, lines) in [
        ("drive-001.mcap", 1),
        ("drive-002.mcap", 0),
        ("drive-003.mcap", 0),
    ] {
        let part = other_folder.path().join("part.mcap");
        std::fs::copy(folder.path().join(name), &part).unwrap();
        let (_, messages) = read(&part);
        assert_eq!(sequences(&messages, log_line::TOPIC).len(), lines, "{name}");
    }
}

#[test]
fn a_missing_part_is_reported_and_the_values_in_force_after_it_are_known() {
    let (folder, path, _) = drive(45, split(PartSize::Time(10 * SECOND), None));
    std::fs::remove_file(folder.path().join("drive-003.mcap")).unwrap();
    let (recording, messages) = read(&path);
    assert_eq!(recording.missing().collect::<Vec<_>>(), [3..=3]);
    assert_eq!(
        sequences(&messages, "/goon/speed"),
        [0, 0],
        "at the start and after the gap"
    );
    // A part begins with the newest value of the part before it.
    let expected = Vec::from_iter((1..200).chain(299..=450));
    assert_eq!(sequences(&messages, "/pioneer/noise"), expected);
}

#[test]
fn a_limited_recording_keeps_the_newest_parts() {
    let (megabyte, keep) = (1_000_000, 6_000_000);
    let (folder, path, status) = drive(2000, split(PartSize::Bytes(megabyte), Some(keep)));
    let parts = status.parts.unwrap();
    assert!(parts.count >= 9 && parts.deleted > 0, "{parts:?}");
    assert_eq!(names(folder.path()).len() as u64, parts.count - parts.deleted);
    let (recording, messages) = read(&path);
    let total: u64 = recording.files().map(|file| file.metadata().unwrap().len()).sum();
    assert!(total <= keep && total > keep / 2, "{total}");
    assert_eq!(u64::from(recording.first_part().unwrap()), parts.deleted + 1);
    let kept = sequences(&messages, "/pioneer/noise");
    let newest = kept.last().copied().unwrap();
    assert_eq!(newest, 20_000);
    assert_eq!(
        kept,
        Vec::from_iter(kept[0]..=newest),
        "every message is kept once"
    );
    assert_eq!(
        sequences(&messages, "/goon/speed"),
        [0],
        "the value in force is kept"
    );
}

#[test]
fn recordings_of_one_name_have_consecutive_parts_and_are_not_mixed() {
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    let (folder, path, _) = drive(25, ten_seconds);
    let mut second = Drive::begin(&path, ten_seconds, false);
    second.record(15);
    second.recorder.finish();
    assert_eq!(names(folder.path()).len(), 5);
    let count = |name: &str| read(&folder.path().join(name)).0.files().count();
    assert_eq!((count("drive-002.mcap"), count("drive-004.mcap")), (3, 2));
    assert_eq!(count("drive.mcap"), 2, "the newest recording");
    assert!(matches!(
        Recording::open(folder.path()),
        Err(ReadError::Ambiguous { count: 2, .. })
    ));

    // `ros2 bag reindex` describes the folder, and they stay two recordings.
    let description = folder.path().join("metadata.yaml");
    std::fs::write(&description, "").unwrap();
    assert!(matches!(
        Recording::open(folder.path()),
        Err(ReadError::Ambiguous { count: 2, .. })
    ));
    std::fs::remove_file(description).unwrap();

    // The limit applies to both recordings together.
    let limited = split(PartSize::Time(10 * SECOND), Some(150_000));
    let mut third = Drive::begin(&path, limited, false);
    third.record(5);
    let parts = third.recorder.finish().parts.unwrap();
    assert_eq!(parts.last, folder.path().join("drive-006.mcap"));
    assert!(parts.deleted >= 3, "{parts:?}");

    let mut overwriting = Drive::begin(&path, ten_seconds, true);
    overwriting.record(5);
    overwriting.recorder.finish();
    assert_eq!(names(folder.path()), ["drive-001.mcap"]);
}

#[test]
fn files_that_are_not_parts_are_neither_read_nor_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(folder.path().join("drive-001.mcap"), "no recording").unwrap();
    std::fs::write(folder.path().join("drive-002.mcap"), "").unwrap();
    let mut drive = Drive::begin(&path, split(PartSize::Time(10 * SECOND), Some(1)), false);
    drive.record(25);
    let parts = drive.recorder.finish().parts.unwrap();
    assert_eq!((parts.count, parts.deleted), (3, 2));
    assert_eq!(
        names(folder.path()),
        ["drive-001.mcap", "drive-002.mcap", "drive-005.mcap"]
    );
    let empty = tempfile::tempdir().unwrap();
    let refused = Recording::open(empty.path()).err();
    assert!(matches!(refused, Some(ReadError::Empty(_))), "{refused:?}");
}

#[test]
fn parts_that_another_recording_writes_are_not_deleted() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    let first = folder.path().join("drive-001.mcap");
    let mut live = Drive::begin(&path, ten_seconds, false);

    let mut bounded = Drive::begin(&path, split(PartSize::Time(10 * SECOND), Some(1)), false);
    bounded.record(25);
    let parts = bounded.recorder.finish().parts.unwrap();
    assert_eq!((parts.count, parts.deleted), (3, 2));
    assert!(parts.undeleted.keys().eq([&first]), "{parts:?}");
    assert_eq!(names(folder.path()), ["drive-001.mcap", "drive-004.mcap"]);

    let mut overwriting = Drive::begin(&path, ten_seconds, true);
    overwriting.record(5);
    let parts = overwriting.recorder.finish().parts.unwrap();
    assert!(parts.undeleted.keys().eq([&first]), "{parts:?}");
    assert_eq!(names(folder.path()), ["drive-001.mcap", "drive-002.mcap"]);

    live.record(5);
    live.recorder.finish();
    assert_eq!(
        sequences(&read(&first).1, "/pioneer/noise"),
        Vec::from_iter(1..=50)
    );
    // The part of a recording that has ended can be deleted.
    let mut overwriting = Drive::begin(&path, ten_seconds, true);
    overwriting.record(5);
    assert_eq!(
        overwriting.recorder.finish().parts.unwrap().undeleted,
        BTreeMap::new()
    );
    assert_eq!(names(folder.path()), ["drive-001.mcap"]);
}

#[test]
fn a_recording_fails_after_the_last_number_of_a_part() {
    let _watchdog = Watchdog::for_test();
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    let (folder, path, _) = drive(5, ten_seconds);
    let first = folder.path().join("drive-001.mcap");
    let named = |number: u64| folder.path().join(format!("drive-{number}.mcap"));
    let last = u64::from(u32::MAX);
    // This number is too large for a part.
    std::fs::copy(&first, named(last + 1)).unwrap();
    let mut next = Drive::begin(&path, ten_seconds, false);
    next.record(5);
    let second = next.recorder.finish().parts.unwrap().last;
    assert_eq!(second, folder.path().join("drive-002.mcap"));

    std::fs::copy(&first, named(last - 1)).unwrap();
    let (options, errors) = support::with_troubles("endless", true);
    let mut last_parts = Drive::of(Recorder::create_split(&path, options, ten_seconds).unwrap());
    last_parts.record(15);
    let status = last_parts.recorder.finish();
    assert_eq!(status.parts.unwrap().last, named(last));
    assert_eq!(errors.lock().len(), 1);
    assert!(status.error.unwrap().contains("last number"));
    let kept = sequences(&read(&named(last)).1, "/pioneer/noise").len();
    assert!((99..=100).contains(&kept), "the last part is complete: {kept}");

    let refused = Recorder::create_split(&path, support::options("endless", true), ten_seconds).err();
    assert!(refused.unwrap().to_string().contains("last number"));
}

#[test]
fn only_files_named_as_parts_are_parts() {
    let folder = tempfile::tempdir().unwrap();
    let named = |name: &[u8]| folder.path().join(OsStr::from_bytes(name));
    let ten_seconds = split(PartSize::Time(10 * SECOND), None);
    // Two names that become the same text if invalid UTF-8 is replaced.
    Drive::begin(&named(b"d\xff.mcap"), ten_seconds, false)
        .recorder
        .finish();
    let other_part = named(b"d\xff-001.mcap");
    for similar in [&b"d\xfe-0001.mcap"[..], b"d\xfe-01.mcap", b"d\xfe-+01.mcap"] {
        std::fs::copy(&other_part, named(similar)).unwrap();
    }
    Drive::begin(&named(b"d\xfe.mcap"), ten_seconds, false)
        .recorder
        .finish();
    assert!(named(b"d\xfe-001.mcap").exists(), "the first number is 1");
    let mut overwriting = Drive::begin(&named(b"d\xfe.mcap"), split(ten_seconds.part_size, Some(1)), true);
    overwriting.record(15);
    assert_eq!(overwriting.recorder.finish().parts.unwrap().deleted, 1);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
    assert!(other_part.exists());
}

#[test]
fn a_truncated_part_does_not_affect_the_others() {
    let (folder, path, _) = drive(45, split(PartSize::Time(10 * SECOND), None));
    let third = folder.path().join("drive-003.mcap");
    let complete = std::fs::read(&third).unwrap();
    // After the header, within the repeated values, and within the new ones.
    for length in [600, 2500, complete.len() / 2] {
        std::fs::write(&third, &complete[..length]).unwrap();
        let recording = Recording::open(&path).unwrap();
        let damage = recording.damage().unwrap();
        assert!(damage.reason.starts_with("drive-003.mcap: "), "{damage:?}");
        let messages: Vec<_> = recording.messages().unwrap().map(Result::unwrap).collect();
        let kept = sequences(&messages, "/pioneer/noise");
        assert!(kept.len() >= 350, "{length}: {}", kept.len());
        assert!(
            kept.is_sorted_by(|number, next| number < next),
            "{length}: {kept:?}"
        );
    }
}
