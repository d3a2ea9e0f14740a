//! Recordings that conditions trigger: the contents and the metadata of their files.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use jde_conditions::{Condition, Names, Triggers};
use jde_core::{Case, State};
use jde_log::{RecordedMessage, Recording, record};
use jde_recorder::{FileEvent, Recorder, RecorderOptions, Stamps, Status, Topic, TriggerOptions};
use jde_records::event::{OperatorAction, What};
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};
use jde_ros::cdr;
use jde_types::Value;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

use crate::support::options;

const SECOND: u64 = 1_000_000_000;
const TENTH: u64 = SECOND / 10;

/// A robot whose speed is published ten times a second, and whose period is published once.
struct Bench {
    recorder: Recorder,
    speed: Topic,
    period: Topic,
    file_events: Arc<Mutex<Vec<(FileEvent, String)>>>,
}

fn names() -> Names {
    let number = Arc::new(f64::describe());
    Names {
        schemas: vec!["goon".to_owned()],
        groups: vec!["example/base".to_owned()],
        variables: BTreeMap::from([
            ("pioneer.speed".to_owned(), Arc::clone(&number)),
            ("goon.period".to_owned(), number),
        ]),
        seed: None,
    }
}

fn about(variable: &str) -> BTreeMap<String, String> {
    BTreeMap::from([("variable".to_owned(), variable.to_owned())])
}

impl Bench {
    fn new(path: &Path, conditions: &[&str], before: u64, after: u64) -> Self {
        Self::with(path, conditions, before, after, 64 << 20, options("bench", true))
    }

    fn with(
        path: &Path,
        conditions: &[&str],
        before: u64,
        after: u64,
        memory: usize,
        options: RecorderOptions<'_>,
    ) -> Self {
        let conditions = conditions
            .iter()
            .map(|text| Condition::new(text, &names()).unwrap());
        let file_events: Arc<Mutex<Vec<_>>> = Arc::default();
        let events = Arc::clone(&file_events);
        let trigger_options = TriggerOptions {
            triggers: Triggers::new(names(), conditions.collect()),
            before: before * SECOND,
            after: after * SECOND,
            memory,
            on_file: Box::new(move |event, file| {
                events.lock().push((event, file.reason.clone()));
            }),
        };
        let recorder = Recorder::create_triggered(path, options, trigger_options).unwrap();
        let number = Arc::new(f64::describe());
        Self {
            speed: recorder.topic("/pioneer/speed", Arc::clone(&number), about("pioneer.speed")),
            period: recorder.topic("/goon/period", number, about("goon.period")),
            recorder,
            file_events,
        }
    }

    /// Publishes ten values a second in a range of seconds.
    fn drive(&self, seconds: std::ops::Range<u64>, speed: f64) {
        for tenth in seconds.start * 10..seconds.end * 10 {
            self.speed.put(&speed.to_ne_bytes(), stamps(tenth * TENTH));
        }
    }

    fn collision(&self, seconds: u64, case: &str) {
        self.recorder.push_record(RunRecord::Decision(Decision {
            number: seconds,
            time_s: seconds as f64,
            group: "example/base".to_owned(),
            case: Case::named(case).unwrap(),
            candidates: vec![CandidateRecord {
                name: "goon".to_owned(),
                state: State::Ready,
                ready: true,
                urgency: Some(1.0),
            }],
            before: None,
            choice: Some("goon".to_owned()),
            decider: DecidedBy::Nobody,
            reason: "alone".to_owned(),
            cause: "the application started".to_owned(),
            changed: true,
            takeover_us: None,
            refused: Vec::new(),
        }));
    }

    fn finish(&self) -> Status {
        self.recorder.finish()
    }
}

fn stamps(time: u64) -> Stamps {
    Stamps {
        published: time,
        measured: time,
        sequence: time / TENTH + 1,
    }
}

/// Reads an undamaged file and its messages.
fn read(path: &Path) -> (Recording, Vec<RecordedMessage>) {
    let recording = Recording::open(path).unwrap();
    assert_eq!(recording.damage(), None);
    let messages: Vec<RecordedMessage> = recording.messages().unwrap().map(Result::unwrap).collect();
    assert!(messages.is_sorted_by_key(|message| message.log_time));
    (recording, messages)
}

fn on_topic<'m>(messages: &'m [RecordedMessage], topic: &str) -> Vec<&'m RecordedMessage> {
    let on_topic = messages.iter().filter(|message| message.channel.topic == topic);
    on_topic.collect()
}

#[test]
fn a_conflict_makes_a_file_of_the_minute_before_and_ten_seconds_after() {
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench::new(&folder.path().join("deep/drive.mcap"), &["conflict"], 60, 10);
    bench.period.put(&0.1_f64.to_ne_bytes(), stamps(0));
    bench.collision(1, "alone");
    bench.drive(0..100, 0.5);
    bench.collision(100, "collision");
    bench.drive(100..200, 0.6);
    let status = bench.finish();
    assert_eq!((status.files.len(), status.lost, status.evicted), (1, 0, 0));
    let written = &status.files[0];
    assert!(written.path.ends_with("deep/drive-001.mcap"));
    assert_eq!(written.time, 100 * SECOND);

    let (recording, messages) = read(&written.path);
    assert_eq!(status.written, messages.len() as u64);
    assert_eq!(written.bytes, written.path.metadata().unwrap().len());
    let trigger = recording.metadata("jde/trigger").unwrap();
    assert_eq!(trigger["condition"], "conflict");
    assert_eq!(trigger["reason"], "conflict in example/base");
    assert_eq!(
        (trigger["time_s"].as_str(), trigger["from_s"].as_str()),
        ("100.000000000", "40.000000000")
    );

    assert_eq!(
        messages[0].log_time,
        40 * SECOND,
        "the file begins a minute before the firing"
    );
    assert_eq!(messages.last().unwrap().log_time, 110 * SECOND);
    let speeds = on_topic(&messages, "/pioneer/speed");
    assert_eq!(
        speeds.len(),
        1 + 600 + 101,
        "the value in force, before, and after"
    );
    let periods = on_topic(&messages, "/goon/period");
    assert_eq!(periods.len(), 1, "the value in force is kept");
    assert_eq!((periods[0].log_time, periods[0].publish_time), (40 * SECOND, 0));
    let decisions = on_topic(&messages, "/jde/decisions");
    assert_eq!(decisions.len(), 2, "the selection in force is kept");
    assert_eq!(
        (decisions[0].log_time, decisions[0].publish_time),
        (40 * SECOND, SECOND)
    );
    let events = on_topic(&messages, "/jde/events");
    assert_eq!(events.len(), 1);
    let Some(RunRecord::Other(event)) = record::read(events[0]) else {
        panic!("the record is not an event");
    };
    assert_eq!(
        (event.what.kind(), event.text().as_str()),
        ("trigger", "conflict in example/base")
    );
}

#[test]
fn a_firing_during_a_file_prolongs_it_and_later_firings_start_new_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(folder.path().join("drive-002.mcap"), "precious").unwrap();
    let bench = Bench::new(&path, &["conflict", "operator"], 20, 10);
    for second in 0..100 {
        bench.drive(second..second + 1, 0.5);
        match second {
            // The other condition prolongs the first file at 38 s. The next file overlaps it.
            30 | 54 => bench.collision(second, "collision"),
            31 | 55 => bench.collision(second, "alone"),
            38 => bench.recorder.push_record(
                What::Operator {
                    by: "ana".to_owned(),
                    action: OperatorAction::Play {
                        schema: "goon".to_owned(),
                    },
                    losses: Vec::new(),
                }
                .at(38 * SECOND)
                .into(),
            ),
            _ => {}
        }
    }
    let status = bench.finish();
    let fired: Vec<_> = status.files.iter().map(|file| file.fired).collect();
    assert_eq!(fired, [2, 1]);
    let (first, messages) = read(&folder.path().join("drive-001.mcap"));
    assert_eq!(
        first.metadata("jde/trigger/2").unwrap()["reason"],
        "operator: ana acted on goon"
    );
    assert_eq!(
        (messages[0].log_time, messages.last().unwrap().log_time),
        (10 * SECOND, 48 * SECOND)
    );
    assert_eq!(
        std::fs::read(folder.path().join("drive-002.mcap")).unwrap(),
        b"precious"
    );
    let (second, messages) = read(&folder.path().join("drive-003.mcap"));
    assert_eq!(second.metadata("jde/trigger/2"), None);
    assert_eq!(
        (messages[0].log_time, messages.last().unwrap().log_time),
        (34 * SECOND, 64 * SECOND)
    );
    let file_events = bench.file_events.lock();
    let file_events: Vec<_> = file_events.iter().map(|(event, _)| *event).collect();
    assert_eq!(
        file_events,
        [
            FileEvent::Started,
            FileEvent::Extended,
            FileEvent::Ended,
            FileEvent::Started,
            FileEvent::Ended
        ]
    );
}

#[test]
fn an_expression_over_encoded_messages_fires_when_it_becomes_true() {
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench::new(&folder.path().join("drive.mcap"), &["pioneer.speed > 0.4"], 5, 1);
    let mut message = Vec::new();
    for tenth in 0..600 {
        let fast = (200..250).contains(&tenth) || tenth >= 400;
        let speed = if fast { 0.5_f64 } else { 0.3 };
        cdr::encode(&f64::describe(), &speed.to_ne_bytes(), &mut message);
        assert!(bench.speed.put_message(&message, stamps(tenth * TENTH)));
    }
    let status = bench.finish();
    let times: Vec<_> = status.files.iter().map(|file| file.time / TENTH).collect();
    assert_eq!(times, [200, 400]);
    let (_, messages) = read(&folder.path().join("drive-002.mcap"));
    let speeds = on_topic(&messages, "/pioneer/speed");
    assert_eq!(speeds.len(), 1 + 50 + 11);
    assert_eq!(speeds.last().unwrap().data, message, "the message is unchanged");
    assert_eq!(speeds[0].channel.type_name, "std_msgs/msg/Float64");
}

#[test]
fn the_same_run_in_virtual_time_gives_the_same_messages() {
    // Not the same bytes: the file is also flushed after half a second of real time.
    let files = || {
        let folder = tempfile::tempdir().unwrap();
        let bench = Bench::new(
            &folder.path().join("drive.mcap"),
            &["pioneer.speed > goon.period"],
            2,
            1,
        );
        for tenth in 0..2000_u64 {
            let time = stamps(tenth * TENTH);
            bench.speed.put(&((tenth * 7 % 13) as f64).to_ne_bytes(), time);
            bench.period.put(&((tenth * 5 % 11) as f64).to_ne_bytes(), time);
        }
        let status = bench.finish();
        let files = status.files.iter();
        let messages = files.map(|file| {
            let messages = read(&file.path).1.into_iter();
            let facts = messages.map(|message| {
                (
                    message.channel.topic.clone(),
                    message.log_time,
                    message.sequence,
                    message.data,
                )
            });
            facts.collect::<Vec<_>>()
        });
        messages.collect::<Vec<_>>()
    };
    let first = files();
    assert!(!first.is_empty());
    assert!(first == files(), "the messages are the same");
}

#[test]
fn memory_is_limited_and_evicted_messages_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let bench = Bench::with(&path, &["conflict"], 60, 1, 10_000, options("bench", true));
    bench.drive(0..100, 0.5);
    bench.collision(100, "collision");
    bench.drive(100..120, 0.5);
    let status = bench.finish();
    assert!(status.evicted > 0);
    assert_eq!(status.lost, 0, "evicted messages do not count as lost");
    let (recording, messages) = read(&status.files[0].path);
    let from: f64 = recording.metadata("jde/trigger").unwrap()["from_s"]
        .parse()
        .unwrap();
    assert!(from > 40.0 && from < 100.0, "{from}");
    assert_eq!(
        messages[0].log_time,
        (from * 1e9).round() as u64,
        "the file begins with the values in force"
    );
    assert_eq!(messages.last().unwrap().log_time, 101 * SECOND);
}

#[test]
fn in_real_time_every_message_is_written_or_counted_as_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let bench = Bench::with(&path, &["conflict"], 60, 60, 1 << 20, options("bench", false));
    bench.collision(0, "collision");
    bench.drive(0..2000, 0.5);
    let status = bench.finish();
    let (recording, messages) = read(&status.files[0].path);
    let lost = recording.metadata("jde/lost").unwrap().get("/pioneer/speed");
    let lost: u64 = lost.map_or(0, |lost| lost.parse().unwrap());
    let written = on_topic(&messages, "/pioneer/speed").len() as u64;
    assert!(written + lost >= 601, "{written} written, {lost} lost");
    assert_eq!(messages.len() as u64, status.written);
}

#[test]
fn a_recording_fails_at_once_where_no_file_can_be_created() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "a file").unwrap();
    let trigger_options = || TriggerOptions {
        triggers: Triggers::new(names(), Vec::new()),
        before: SECOND,
        after: SECOND,
        memory: 1000,
        on_file: Box::new(|_, _| {}),
    };
    for path in [file.join("drive.mcap").as_path(), "/sys/drive.mcap".as_ref()] {
        assert!(Recorder::create_triggered(path, options("bench", true), trigger_options()).is_err());
    }
    Recorder::create_triggered(
        &folder.path().join("drive.mcap"),
        options("bench", true),
        trigger_options(),
    )
    .unwrap()
    .finish();
    let count = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(count, 1, "the check leaves no file");
}

/// The file that the child process records. Set in the child only.
const FILE: &str = "JDE_LOG_TEST_TRIGGERED";

/// Fires at 10 s and continues until it is killed. Prints the number of messages that have reached the file
/// whenever it changes.
fn record_until_killed(path: &Path) {
    let bench = Bench::new(path, &["conflict"], 5, 1_000_000);
    bench.drive(0..10, 0.5);
    bench.collision(10, "collision");
    let mut printed = 0;
    for second in 10.. {
        bench.drive(second..second + 1, 0.5);
        let kept = bench.recorder.status().written;
        if kept > printed {
            printed = kept;
            println!("\nkept {printed}");
        }
    }
}

#[test]
fn a_file_of_a_killed_process_contains_the_messages_before_and_after_the_firing() {
    let _watchdog = Watchdog::for_test();
    if let Some(file) = std::env::var_os(FILE) {
        return record_until_killed(file.as_ref());
    }
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "triggered::a_file_of_a_killed_process_contains_the_messages_before_and_after_the_firing",
            "--nocapture",
        ])
        .env(FILE, folder.path().join("drive.mcap"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let kept = lines
        .filter_map(|line| line.unwrap().strip_prefix("kept ")?.parse::<usize>().ok())
        .nth(1)
        .expect("the child prints the number of kept messages");
    // SIGKILL: no code of the process runs after it.
    child.kill().unwrap();
    child.wait().unwrap();

    let recording = Recording::open(&folder.path().join("drive-001.mcap")).unwrap();
    assert!(recording.damage().is_some(), "the index is missing");
    assert_eq!(
        recording.metadata("jde/trigger").unwrap()["reason"],
        "conflict in example/base"
    );
    let messages: Vec<RecordedMessage> = recording.messages().unwrap().map(Result::unwrap).collect();
    assert!(messages.len() >= kept, "{} of {kept}", messages.len());
    let speeds = on_topic(&messages, "/pioneer/speed");
    assert_eq!(speeds[0].log_time, 5 * SECOND);
    for (index, message) in speeds.iter().skip(1).enumerate() {
        assert_eq!(
            message.log_time,
            5 * SECOND + index as u64 * TENTH,
            "no message is missing"
        );
    }
}
