//! Playback of recordings: times, speeds, pauses, steps and positions, with damaged, truncated and foreign
//! files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use jde_log::{Options, Origin, Recorder, Stamps};
use jde_schema::bench::{Bench, Failure};
use tempfile::TempDir;

use super::*;

const MS: u64 = 1_000_000;

/// A recording in a folder of its own, and the driver that plays it.
struct Played {
    bench: Bench<Recording>,
    folder: TempDir,
}

impl Played {
    /// Records ten seconds at 10 Hz of a laser whose range in metres is the time in seconds, on two topics,
    /// and one pose at 0.05 s.
    fn new() -> Self {
        let folder = TempDir::new().expect("a folder");
        let file = folder.path().join("drive.mcap");
        let recorder = recorder(&file);
        let laser = |topic| recorder.topic(topic, Arc::new(LaserScan::describe()), BTreeMap::new());
        let lasers = [(laser("/pioneer/laser"), 0.0), (laser("/rear/laser"), 100.0)];
        let odometry = recorder.topic(
            "/pioneer/odometry",
            Arc::new(Odometry::describe()),
            BTreeMap::new(),
        );
        let pose = Pose2D::new(1.0, 2.0, 0.5);
        let odometer = Odometry::planar(Duration::from_millis(50), pose, Twist::ZERO);
        odometry.put(odometer.as_bytes(), stamps(50 * MS, 0, 1));
        for scan in 0..=100_u64 {
            for (topic, more) in &lasers {
                let mut laser = Box::new(LaserScan::zeroed());
                laser
                    .ranges
                    .push(scan as f32 / 10.0 + more)
                    .expect("room for one");
                topic.put(laser.as_bytes(), stamps(scan * 100 * MS, 30 * MS, scan + 1));
            }
        }
        recorder.finish();
        let mut played = Self {
            bench: Bench::new(),
            folder,
        };
        played.bench.set("file", text(&played.file()));
        played
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("drive.mcap")
    }

    fn awake(mut self) -> Self {
        self.bench.awake().expect("it is a recording");
        self
    }

    /// Iterates at a time of the application, s.
    fn at(&mut self, seconds: f64) -> Playback {
        self.bench.set_now(Duration::from_secs_f64(seconds));
        self.bench.iterate().expect("it plays");
        self.bench.exported("playback").expect("it says how far it is")
    }

    /// The first range of the exported scan, m.
    fn sees(&self) -> Option<f32> {
        let laser: LaserScan = self.bench.exported("laser")?;
        laser.ranges.first().copied()
    }

    #[track_caller]
    fn refused(mut self) -> String {
        let found = self.bench.inspect().expect("it inspects");
        let refused = self.bench.awake().map_err(|Failure { reason, .. }| reason);
        let reason = refused.expect_err("it is nothing to be played");
        let said: Vec<_> = found.iter().map(|problem| &*problem.words).collect();
        assert_eq!(said, [&*reason], "an inspection says the same");
        reason
    }
}

fn recorder(file: &Path) -> Recorder {
    let options = Options {
        origin: Origin {
            application: "bench".to_owned(),
            seed: 0,
            started: SystemTime::UNIX_EPOCH + Duration::from_secs(1_800_000_000),
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite: false,
        lossless: true,
        on_error: Box::new(|trouble| panic!("{trouble}")),
    };
    Recorder::create(file, options).expect("a file")
}

fn stamps(published: u64, age: u64, sequence: u64) -> Stamps {
    Stamps {
        published,
        measured: published.saturating_sub(age),
        sequence,
    }
}

fn text(path: &Path) -> Text<1024> {
    Text::new(path.to_str().expect("a path in UTF-8"))
}

#[test]
fn a_drive_is_played_at_its_times() {
    let mut played = Played::new().awake();
    assert_eq!(played.at(0.0).messages, 1);
    assert_eq!(played.sees(), Some(0.0), "the first laser there is");
    let playback = played.at(0.25);
    assert_eq!((playback.position, playback.length), (0.25, 10.0));
    assert_eq!(played.sees(), Some(0.2));
    let odometry: Odometry = played.bench.exported("odometry").expect("it has played the pose");
    assert!((odometry.pose2d().x - 1.0).abs() < 1e-9);
    assert_eq!(
        played.bench.exported_at("laser"),
        Some(Duration::from_millis(170)),
        "measured 30 ms before it was published, which was at 0.2 s"
    );
    let laser: LaserScan = played.bench.exported("laser").expect("it sees");
    assert_eq!(laser.header.stamp, Duration::from_millis(170).into());
    played.at(20.0);
    let mission: Mission = played.bench.exported("mission").expect("it says how far it is");
    assert_eq!((mission.state, played.sees()), (Mission::DONE, Some(10.0)));
}

#[test]
fn a_named_topic_comes_before_the_first() {
    let mut played = Played::new();
    played.bench.set("laser_topic", Text::<120>::new("/rear/laser"));
    let mut played = played.awake();
    played.at(0.0);
    assert_eq!(played.sees(), Some(100.0));
}

#[test]
fn a_sensor_that_was_not_recorded_has_no_value() {
    let mut played = Played::new().awake();
    played.at(5.0);
    assert!(played.bench.exported::<BatteryState>("battery").is_none());
}

#[test]
fn it_goes_at_any_speed_and_not_back() {
    let mut played = Played::new().awake();
    played.at(0.0);
    played.bench.set("speed", 4.0);
    assert_eq!(played.at(1.0).position, 4.0);
    played.bench.set("speed", 0.5);
    assert_eq!(played.at(2.0).position, 4.5);
    assert_eq!(played.sees(), Some(4.5));
}

#[test]
fn a_pause_stands_still_and_a_step_plays_messages() {
    let mut played = Played::new().awake();
    played.at(0.0);
    played.at(1.0);
    played.bench.set("paused", Flag::TRUE);
    let playback = played.at(3.0);
    assert_eq!((playback.position, playback.playing), (1.0, Flag::FALSE));
    let before = playback.messages;
    played.bench.set("step", 2_u32);
    let playback = played.at(4.0);
    assert_eq!((playback.messages - before, played.sees()), (2, Some(1.2)));
    assert_eq!(played.at(5.0).messages, playback.messages, "a step is taken once");
    played.bench.set("step", 2_u32);
    played.at(6.0);
    assert_eq!(played.sees(), Some(1.4), "and again when it is written again");
    played.bench.set("paused", Flag::FALSE);
    played.at(6.5);
    played.at(7.0);
    assert_eq!(played.sees(), Some(2.4), "it goes on from where the steps led");
}

#[test]
fn a_jump_shows_what_was_in_force_there_back_and_forth() {
    let mut played = Played::new().awake();
    played.at(0.0);
    played.bench.set("position", 7.05);
    assert_eq!(played.at(1.0).position, 7.05);
    assert_eq!(played.sees(), Some(7.0));
    played.bench.set("position", 2.05);
    played.at(1.5);
    assert_eq!(played.sees(), Some(2.0));
    played.bench.set("paused", Flag::TRUE);
    played.bench.set("position", 9.0);
    played.at(2.0);
    assert_eq!(played.sees(), Some(8.9), "also in a pause");
}

#[test]
fn it_begins_where_it_is_told_to() {
    let mut played = Played::new();
    played.bench.set("position", 3.0);
    let mut played = played.awake();
    assert_eq!(played.at(0.0).position, 3.0);
    assert_eq!(played.at(1.0).position, 4.0);
}

#[test]
fn it_begins_anew_if_it_is_to() {
    let mut played = Played::new();
    played.bench.set("repeat", Flag::TRUE);
    let mut played = played.awake();
    played.at(0.0);
    played.at(10.5);
    assert_eq!(played.sees(), Some(10.0));
    let mission: Mission = played.bench.exported("mission").expect("it says how far it is");
    assert_eq!(mission.state, Mission::RUNNING, "it never ends");
    let playback = played.at(10.6);
    assert_eq!((playback.position, playback.playing), (0.0, Flag::TRUE));
    played.at(11.1);
    assert_eq!(played.sees(), Some(0.5));
}

#[test]
fn what_is_commanded_is_shown_and_goes_nowhere() {
    let mut played = Played::new().awake();
    played.at(0.0);
    played.bench.command("velocity", &Twist::planar(0.2, 0.5));
    played.at(0.5);
    assert_eq!(played.bench.exported("wanted"), Some(Twist::planar(0.2, 0.5)));
}

#[test]
fn a_sleep_is_no_part_of_the_recording() {
    let mut played = Played::new().awake();
    played.at(0.0);
    played.at(1.0);
    played.bench.sleep().expect("it sleeps");
    played.bench.set_now(Duration::from_secs(5));
    played.bench.awake().expect("it wakes");
    assert_eq!(played.at(6.0).position, 2.0);
}

#[test]
fn a_recording_that_was_cut_off_is_played_as_far_as_it_goes() {
    let played = Played::new();
    let bytes = fs::read(played.file()).expect("it was written");
    fs::write(played.file(), &bytes[..bytes.len() - 200]).expect("it is cut");
    let mut played = played.awake();
    let warned = played
        .bench
        .log()
        .iter()
        .any(|(_, words)| words.contains("is damaged behind byte"));
    assert!(warned, "{:?}", played.bench.log());
    played.at(0.0);
    played.at(30.0);
    let mission: Mission = played.bench.exported("mission").expect("it says how far it is");
    assert_eq!(mission.state, Mission::DONE);
}

#[test]
fn what_cannot_be_played_is_named() {
    let mut played = Played::new();
    played.bench.set("laser_topic", Text::<120>::new("/front/laser"));
    let reason = played.refused();
    assert!(
        reason.contains("has no topic `/front/laser`; it has /pioneer/laser"),
        "{reason}"
    );

    let mut played = Played::new();
    played
        .bench
        .set("laser_topic", Text::<120>::new("/pioneer/odometry"));
    let reason = played.refused();
    assert!(
        reason
            .contains("is a nav_msgs/msg/Odometry in cdr, and a sensor_msgs/msg/LaserScan in cdr is wanted"),
        "{reason}"
    );

    let mut played = Played::new();
    played.bench.set("file", Text::<1024>::default());
    assert!(played.refused().contains("--set NAME.file=drive.mcap"));

    let played = Played::new();
    fs::write(played.file(), "no recording at all").expect("it is written");
    assert!(played.refused().contains("is no MCAP file"));
}

#[test]
fn a_recording_without_senses_is_refused() {
    let played = Played::new();
    fs::remove_file(played.file()).expect("it was there");
    let recorder = recorder(&played.file());
    let topic = recorder.topic("/mission", Arc::new(Mission::describe()), BTreeMap::new());
    topic.put(Mission::default().as_bytes(), stamps(0, 0, 1));
    recorder.finish();
    let reason = played.refused();
    assert!(
        reason.ends_with("has no topic that a robot senses; it has /mission"),
        "{reason}"
    );
}
