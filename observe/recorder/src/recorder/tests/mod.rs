//! Tests of the recorder: values are complete, and losses are counted.

pub(crate) mod disks;

use std::fs::File;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::time::SystemTime;

use jde_board::{Access, Board, Declaration, Writer};
use jde_ros::cdr;
use jde_types::{Image, LaserScan, Value};
use tempfile::TempDir;

use super::*;

use jde_log::{RecordedMessage, Recording};

/// Variables, their clock, and the folder of the recording.
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
                access: Access::Export {
                    validity: jde_board::LASTING,
                },
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

    fn messages(&self) -> Vec<RecordedMessage> {
        let recording = Recording::open(&self.file()).unwrap();
        assert_eq!(recording.damage(), None);
        recording.messages().unwrap().map(Result::unwrap).collect()
    }
}

fn options(lossless: bool) -> RecorderOptions<'static> {
    RecorderOptions {
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
        on_trouble: Box::new(|error| panic!("{error}")),
    }
}

#[test]
fn a_recording_in_a_folder_of_another_user_is_private() {
    let fixture = Fixture::new();
    let mode = |file: &Path| file.metadata().unwrap().permissions().mode() & 0o777;
    let record = |file: &Path| {
        drop(Recorder::create(file, options(true)).unwrap().finish());
        mode(file)
    };
    let ordinary = fixture.folder.path().join("ordinary");
    drop(File::create(&ordinary).unwrap());
    assert_eq!(record(&fixture.file()), mode(&ordinary));
    // Only root can change the owner of a folder. Without root, the folder for temporary files belongs to
    // another user.
    let other = fixture.folder.path().join("other");
    std::fs::create_dir(&other).unwrap();
    let changed = std::os::unix::fs::chown(&other, Some(65534), None).is_ok();
    let foreign = if changed { other } else { std::env::temp_dir() };
    let file = foreign.join(format!("jde-{}.mcap", std::process::id()));
    assert_eq!(record(&file), 0o600);
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn a_lossless_recording_keeps_every_value_in_the_order_of_time() {
    let fixture = Fixture::new();
    let variables = [
        fixture.declare::<u64>("count"),
        fixture.declare::<LaserScan>("laser"),
        fixture.declare::<Image>("camera"),
    ];
    let recorder = Recorder::create(&fixture.file(), options(true)).unwrap();
    let mut writers: Vec<_> = variables
        .iter()
        .map(|variable| {
            recorder.watch(variable, fixture.clock());
            variable.writer(1, "test").unwrap()
        })
        .collect();
    // More than the slots of each variable.
    let rounds = 1500_u64;
    for number in 1..=rounds {
        fixture.publish(&mut writers[0], number);
        fixture.publish(&mut writers[1], number);
        if number % 50 == 0 {
            fixture.publish(&mut writers[2], number);
        }
    }
    let status = recorder.finish();
    assert_eq!((status.written, status.lost), (rounds * 2 + rounds / 50, 0));
    assert_eq!(
        status.bytes,
        fixture.file().metadata().unwrap().len(),
        "the file has the reported size"
    );

    let messages = fixture.messages();
    assert!(messages.is_sorted_by_key(|message| message.log_time));
    for (variable, topic) in variables
        .iter()
        .zip(["/robot/count", "/robot/laser", "/robot/camera"])
    {
        let of_topic = messages.iter().filter(|message| message.channel.topic == topic);
        for (index, message) in of_topic.enumerate() {
            assert_eq!(message.sequence as usize, index + 1);
            let value = cdr::decode(&variable.describe().value_type, &message.data).unwrap();
            assert_eq!(value[..8], (message.log_time / 1_000_000).to_ne_bytes());
            assert_eq!(
                message.publish_time,
                message.log_time / 1_000_000,
                "the time of the stamp"
            );
        }
    }
}

#[test]
fn in_real_time_lost_values_are_counted() {
    let fixture = Fixture::new();
    let variables = [
        fixture.declare::<u64>("count"),
        fixture.declare::<Image>("camera"),
    ];
    let recorder = Recorder::create(&fixture.file(), options(false)).unwrap();
    let mut writers: Vec<_> = variables
        .iter()
        .map(|variable| {
            recorder.watch(variable, fixture.clock());
            variable.writer(1, "test").unwrap()
        })
        .collect();
    for number in 1..=3000 {
        fixture.publish(&mut writers[0], number);
    }
    for number in 3001..=3100 {
        fixture.publish(&mut writers[1], number);
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, 3100, "{status:?}");
    let messages = fixture.messages();
    assert_eq!(messages.len() as u64, status.written);
    let last = |topic: &str| {
        let mut of_topic = messages.iter().filter(|message| message.channel.topic == topic);
        of_topic.next_back().unwrap().sequence
    };
    assert_eq!(last("/robot/camera"), 100, "the newest picture is always kept");
    let recording = Recording::open(&fixture.file()).unwrap();
    let lost: u64 = recording
        .metadata("jde/lost")
        .unwrap()
        .values()
        .map(|lost| lost.parse::<u64>().unwrap())
        .sum();
    assert_eq!(lost, status.lost, "the file contains the count");
}

#[test]
fn the_value_before_the_start_is_recorded() {
    let fixture = Fixture::new();
    let count = fixture.declare::<u64>("count");
    let mut writer = count.writer(1, "test").unwrap();
    fixture.publish(&mut writer, 5);
    let recorder = Recorder::create(&fixture.file(), options(false)).unwrap();
    recorder.watch(&count, fixture.clock());
    recorder.finish();
    fixture.publish(&mut writer, 6);
    let messages = fixture.messages();
    assert_eq!(messages.len(), 1, "values after the end are not recorded");
    assert_eq!(messages[0].data, b"\0\x01\0\0\x05\0\0\0\0\0\0\0");
    assert_eq!(messages[0].channel.type_name, "std_msgs/msg/UInt64");
    assert_eq!(messages[0].channel.metadata["access"], "export");
}

#[test]
fn values_of_another_process_keep_their_stamps() {
    let fixture = Fixture::new();
    let recorder = Recorder::create(&fixture.file(), options(false)).unwrap();
    let topic = recorder.topic(
        "/remote/count",
        Arc::new(u64::describe()),
        BTreeMap::from([("from".to_owned(), "remote".to_owned())]),
    );
    // A sequence number has 32 bits in the file, and wraps around.
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
    assert_eq!(recorder.finish().lost_by_topic["/remote/count"], 3);
    let messages = fixture.messages();
    let times: Vec<_> = messages
        .iter()
        .map(|message| (message.log_time, message.publish_time, message.sequence))
        .collect();
    assert_eq!(times, [(10, 9, 1), (20, 19, u32::MAX), (30, 29, 0)]);
    assert_eq!(messages[0].channel.metadata["from"], "remote");
}

#[test]
fn an_existing_file_is_overwritten_only_on_request() {
    let fixture = Fixture::new();
    std::fs::write(fixture.file(), "precious").unwrap();
    let refused = Recorder::create(&fixture.file(), options(false)).err();
    assert!(matches!(refused, Some(Error::Exists(_))), "{refused:?}");
    assert_eq!(std::fs::read(fixture.file()).unwrap(), b"precious");
    let overwrite = RecorderOptions {
        overwrite: true,
        ..options(false)
    };
    Recorder::create(&fixture.file(), overwrite).unwrap().finish();
    assert_eq!(fixture.messages(), []);
}

#[test]
fn a_file_that_another_recording_writes_is_not_overwritten() {
    let fixture = Fixture::new();
    let overwrite = || RecorderOptions {
        overwrite: true,
        ..options(true)
    };
    let first = Recorder::create(&fixture.file(), options(true)).unwrap();
    let refused = Recorder::create(&fixture.file(), overwrite()).err();
    assert!(matches!(refused, Some(Error::Written(_))), "{refused:?}");
    first.finish();
    assert!(fixture.messages().is_empty(), "the first recording is intact");
    drop(Recorder::create(&fixture.file(), overwrite()).unwrap());
}

#[test]
fn a_recording_fails_at_once_where_nothing_can_be_written() {
    let fixture = Fixture::new();
    std::fs::write(fixture.file(), "a file").unwrap();
    let inside = fixture.file().join("run.mcap");
    // Not even root can write to /sys, and /dev/full is a full disk.
    for path in [inside.as_path(), "/sys/run.mcap".as_ref(), "/dev/full".as_ref()] {
        let refused = Recorder::create(path, options(false)).err();
        let Some(Error::Create { path: reported, .. }) = &refused else {
            panic!("{}: {refused:?}", path.display());
        };
        assert_eq!(reported, path);
    }
}
