//! A recorder on variables that only the test writes: no value is torn, no loss is silent, and no disk blocks
//! it.

use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::channel;
use std::time::SystemTime;

use jde_board::{Access, Board, Declaration, Writer};
use jde_types::{Image, LaserScan, Value};
use tempfile::TempDir;

use super::*;
use jde_ros::cdr;

use crate::{Message, Recording};

/// Variables, their clock and a folder.
struct Fixture {
    board: Board,
    time: Arc<AtomicU64>,
    folder: TempDir,
}

impl Fixture {
    fn new() -> Self {
        Self {
            board: Board::new(),
            time: Arc::default(),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("run.mcap")
    }

    fn clock(&self) -> Clock {
        let time = Arc::clone(&self.time);
        Arc::new(move || time.load(Ordering::Relaxed))
    }

    fn declare<T: Value>(&self, name: &str) -> Arc<Variable> {
        self.board
            .declare(Declaration {
                owner: "robot".to_owned(),
                name: name.to_owned(),
                doc: "For a test.".to_owned(),
                unit: String::new(),
                value_type: Arc::new(T::describe()),
                access: Access::Export,
                limits: jde_abi::describe::Limits::default(),
                initial: None,
                writers: 1,
                readers: 2,
            })
            .unwrap()
    }

    /// Publishes a value whose first bytes are `number`.
    fn publish(&self, writer: &mut Writer, number: u64) {
        self.time.store(number * 1_000_000, Ordering::Relaxed);
        let value = writer.loan();
        value.fill(0);
        value[..8].copy_from_slice(&number.to_ne_bytes());
        writer.publish(number, number).unwrap();
    }

    fn messages(&self) -> Vec<Message> {
        let recording = Recording::open(&self.file()).unwrap();
        assert_eq!(recording.damage(), None);
        recording.messages().unwrap().map(Result::unwrap).collect()
    }
}

fn options(lossless: bool) -> Options<'static> {
    Options {
        origin: Origin {
            application: "bench".to_owned(),
            seed: 7,
            started: SystemTime::UNIX_EPOCH,
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite: false,
        lossless,
        on_error: Box::new(|trouble| panic!("{trouble}")),
    }
}

#[test]
fn in_a_folder_that_is_somebody_elses_nobody_else_may_read_a_recording() {
    let bench = Fixture::new();
    let mode = |file: &Path| file.metadata().unwrap().permissions().mode() & 0o777;
    let record = |file: &Path| {
        drop(Recorder::create(file, options(true)).unwrap().finish());
        mode(file)
    };
    let usual = bench.folder.path().join("usual");
    drop(File::create(&usual).unwrap());
    assert_eq!(record(&bench.file()), mode(&usual));
    // Only root can change the owner of a folder. Other users use the folder of temporary files, whose owner
    // is another user.
    let other = bench.folder.path().join("other");
    std::fs::create_dir(&other).unwrap();
    let given = std::os::unix::fs::chown(&other, Some(65534), None).is_ok();
    let theirs = if given { other } else { std::env::temp_dir() };
    let file = theirs.join(format!("jde-{}.mcap", std::process::id()));
    assert_eq!(record(&file), 0o600);
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn lossless_keeps_every_value_of_every_size_in_the_order_of_time() {
    let bench = Fixture::new();
    let variables = [
        bench.declare::<u64>("count"),
        bench.declare::<LaserScan>("laser"),
        bench.declare::<Image>("camera"),
    ];
    let recorder = Recorder::create(&bench.file(), options(true)).unwrap();
    let mut writers: Vec<_> = variables
        .iter()
        .map(|variable| {
            recorder.watch(variable, bench.clock());
            variable.writer(1, "test").unwrap()
        })
        .collect();
    // More than the slots of each variable.
    let rounds = 1500_u64;
    for number in 1..=rounds {
        bench.publish(&mut writers[0], number);
        bench.publish(&mut writers[1], number);
        if number % 50 == 0 {
            bench.publish(&mut writers[2], number);
        }
    }
    let status = recorder.finish();
    assert_eq!((status.written, status.lost), (rounds * 2 + rounds / 50, 0));
    assert_eq!(
        status.bytes,
        bench.file().metadata().unwrap().len(),
        "all that was counted is there"
    );

    let messages = bench.messages();
    assert!(messages.is_sorted_by_key(|message| message.log_time));
    for (variable, topic) in variables
        .iter()
        .zip(["/robot/count", "/robot/laser", "/robot/camera"])
    {
        let of_topic = messages.iter().filter(|message| message.channel.topic == topic);
        for (place, message) in of_topic.enumerate() {
            assert_eq!(message.sequence as usize, place + 1);
            let value = cdr::decode(&variable.describe().value_type, &message.data).unwrap();
            assert_eq!(value[..8], (message.log_time / 1_000_000).to_ne_bytes());
            assert_eq!(
                message.publish_time,
                message.log_time / 1_000_000,
                "its own stamp"
            );
        }
    }
}

#[test]
fn in_real_time_what_is_not_kept_is_counted() {
    let bench = Fixture::new();
    let variables = [bench.declare::<u64>("count"), bench.declare::<Image>("camera")];
    let recorder = Recorder::create(&bench.file(), options(false)).unwrap();
    let mut writers: Vec<_> = variables
        .iter()
        .map(|variable| {
            recorder.watch(variable, bench.clock());
            variable.writer(1, "test").unwrap()
        })
        .collect();
    for number in 1..=3000 {
        bench.publish(&mut writers[0], number);
    }
    for number in 3001..=3100 {
        bench.publish(&mut writers[1], number);
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, 3100, "{status:?}");
    let messages = bench.messages();
    assert_eq!(messages.len() as u64, status.written);
    let last = |topic: &str| {
        let mut of_topic = messages.iter().filter(|message| message.channel.topic == topic);
        of_topic.next_back().unwrap().sequence
    };
    assert_eq!(last("/robot/camera"), 100, "the newest picture is always kept");
    let told = Recording::open(&bench.file()).unwrap();
    let told: u64 = told
        .metadata("jde/lost")
        .unwrap()
        .values()
        .map(|lost| lost.parse::<u64>().unwrap())
        .sum();
    assert_eq!(told, status.lost, "and the file says so");
}

#[test]
fn the_value_at_the_beginning_is_kept_too() {
    let bench = Fixture::new();
    let count = bench.declare::<u64>("count");
    let mut writer = count.writer(1, "test").unwrap();
    bench.publish(&mut writer, 5);
    let recorder = Recorder::create(&bench.file(), options(false)).unwrap();
    recorder.watch(&count, bench.clock());
    recorder.finish();
    bench.publish(&mut writer, 6);
    let messages = bench.messages();
    assert_eq!(messages.len(), 1, "and none after the end");
    assert_eq!(messages[0].data, b"\0\x01\0\0\x05\0\0\0\0\0\0\0");
    assert_eq!(messages[0].channel.type_name, "std_msgs/msg/UInt64");
    assert_eq!(messages[0].channel.metadata["access"], "export");
}

#[test]
fn values_from_elsewhere_are_kept_as_they_are_stamped() {
    let bench = Fixture::new();
    let recorder = Recorder::create(&bench.file(), options(false)).unwrap();
    let topic = recorder.topic(
        "/elsewhere/count",
        Arc::new(u64::describe()),
        BTreeMap::from([("from".to_owned(), "afar".to_owned())]),
    );
    // The file has 32 bits for a sequence number, which restarts at 0 after the largest.
    let large = u64::from(u32::MAX);
    for (published, measured, sequence) in [(30, 29, large + 1), (20, 19, large), (10, 9, 1)] {
        let stamps = crate::Stamps {
            published,
            measured,
            sequence,
        };
        assert!(topic.put(&published.to_ne_bytes(), stamps));
    }
    topic.add_lost(3);
    assert_eq!(recorder.finish().lost_by_topic["/elsewhere/count"], 3);
    let messages = bench.messages();
    let times: Vec<_> = messages
        .iter()
        .map(|message| (message.log_time, message.publish_time, message.sequence))
        .collect();
    assert_eq!(times, [(10, 9, 1), (20, 19, u32::MAX), (30, 29, 0)]);
    assert_eq!(messages[0].channel.metadata["from"], "afar");
}

/// Far longer than any of these tests takes.
const WATCHDOG: std::time::Duration = std::time::Duration::from_secs(60);

/// About three chunks.
const ROOM: usize = 3_500_000;

/// A disk with limited room.
struct LimitedFile {
    file: File,
    room: usize,
}

impl Write for LimitedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.room == 0 {
            return Err(io::Error::from_raw_os_error(28));
        }
        let written = self.file.write(&bytes[..bytes.len().min(self.room)])?;
        self.room -= written;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[test]
fn a_disk_that_runs_full_is_told_once_and_stops_nobody() {
    let bench = Fixture::new();
    let laser = bench.declare::<LaserScan>("laser");
    let (tell, told) = channel();
    let disk = LimitedFile {
        file: File::create(bench.file()).unwrap(),
        room: ROOM,
    };
    let options = Options {
        on_error: Box::new(move |trouble| tell.send(trouble.to_owned()).unwrap()),
        ..options(true)
    };
    let Ok(recorder) = Recorder::create_with(Box::new(disk), None, options) else {
        panic!("there is room for the beginning");
    };
    recorder.watch(&laser, bench.clock());
    let mut writer = laser.writer(1, "test").unwrap();
    // Numbers that do not compress, so that the disk does run full.
    let mut noise = 1_u64;
    for number in 1..=1000_u64 {
        bench.time.store(number, Ordering::Relaxed);
        let value = writer.loan();
        value.fill(0);
        // A length beyond the capacity counts as the capacity.
        value.chunks_exact_mut(8).for_each(|bytes| {
            noise = noise.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            bytes.copy_from_slice(&noise.rotate_left(29).to_ne_bytes());
        });
        writer.publish(number, number).unwrap();
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, 1000);
    assert!(status.error.unwrap().contains("space"));
    assert_eq!(told.iter().count(), 1);
    let recording = Recording::open(&bench.file()).unwrap();
    let damage = recording.damage().unwrap();
    assert!(damage.offset <= ROOM as u64, "{damage:?}");
    let read = recording.messages().unwrap().map(Result::unwrap).count() as u64;
    assert!(read > 0 && read >= status.written, "{read} of {}", status.written);
}

/// A disk that fails after `good` requests and, like Linux, reports the failure once. The receiver gets a
/// message for each request.
fn failing(mut good: u64) -> (Disk, Receiver<()>) {
    let (asked, is_asked) = channel();
    let disk = move || {
        let fails = good == 0;
        good = good.wrapping_sub(1);
        asked.send(()).unwrap();
        if fails {
            return Err(io::Error::from_raw_os_error(5));
        }
        Ok(())
    };
    (Box::new(disk), is_asked)
}

/// Records `flushes` flushes of one message each, on a disk that fails after `good` of them.
fn on_a_failing_disk(good: u64, flushes: u64) -> Status {
    let (tell, told) = channel();
    let options = Options {
        on_error: Box::new(move |trouble| tell.send(trouble.to_owned()).unwrap()),
        ..options(false)
    };
    let (disk, is_asked) = failing(good);
    let Ok(recorder) = Recorder::create_with(Box::new(io::sink()), Some(disk), options) else {
        panic!("there is no such file that could fail");
    };
    let topic = recorder.topic("/a/b", Arc::new(u64::describe()), BTreeMap::new());
    for number in 1..=flushes {
        let stamps = crate::Stamps {
            published: number,
            measured: number,
            sequence: number,
        };
        assert!(topic.put(&number.to_ne_bytes(), stamps));
        if number < flushes {
            is_asked.recv_timeout(WATCHDOG).expect("the disk is asked");
        }
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, flushes);
    assert_eq!(told.iter().count(), 1, "told once");
    assert!(status.error.is_some());
    status
}

#[test]
fn a_disk_that_fails_at_the_very_end_is_heard() {
    let status = on_a_failing_disk(0, 1);
    assert_eq!((status.written, status.lost), (0, 1));
}

#[test]
fn what_a_failing_disk_had_taken_before_is_kept_and_the_rest_is_lost() {
    let status = on_a_failing_disk(2, 3);
    assert_eq!((status.written, status.lost), (2, 1));
}

#[test]
fn a_file_that_exists_is_not_written_over_unless_asked() {
    let bench = Fixture::new();
    std::fs::write(bench.file(), "precious").unwrap();
    let refused = Recorder::create(&bench.file(), options(false)).err();
    assert!(matches!(refused, Some(Error::Exists(_))), "{refused:?}");
    assert_eq!(std::fs::read(bench.file()).unwrap(), b"precious");
    let overwrite = Options {
        overwrite: true,
        ..options(false)
    };
    Recorder::create(&bench.file(), overwrite).unwrap().finish();
    assert_eq!(bench.messages(), []);
}

#[test]
fn a_file_that_another_recording_writes_is_not_written_over() {
    let bench = Fixture::new();
    let over = || Options {
        overwrite: true,
        ..options(true)
    };
    let first = Recorder::create(&bench.file(), options(true)).unwrap();
    let refused = Recorder::create(&bench.file(), over()).err();
    assert!(matches!(refused, Some(Error::Written(_))), "{refused:?}");
    first.finish();
    assert!(bench.messages().is_empty(), "and it is whole");
    drop(Recorder::create(&bench.file(), over()).unwrap());
}

#[test]
fn where_nothing_can_be_written_no_recording_begins() {
    let bench = Fixture::new();
    std::fs::write(bench.file(), "a file").unwrap();
    let inside = bench.file().join("run.mcap");
    // The last one is a full disk. The one before it is a folder in which not even root can write.
    for path in [inside.as_path(), "/sys/run.mcap".as_ref(), "/dev/full".as_ref()] {
        let refused = Recorder::create(path, options(false)).err();
        let Some(Error::Create { path: named, .. }) = &refused else {
            panic!("{}: {refused:?}", path.display());
        };
        assert_eq!(named, path);
    }
}
