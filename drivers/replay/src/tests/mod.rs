//! Playback of recordings: times, speeds, pauses, steps and positions, with damaged, truncated and unsuitable
//! files.

mod bags;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use jde_recorder::{Origin, Recorder, RecorderOptions, Stamps};
use jde_schema::bench::{Bench, Failure};
use jde_schema::types::Footprint;
use tempfile::TempDir;

use super::*;

const MS: u64 = 1_000_000;

/// A recording in a folder of its own, and the driver that plays it.
struct Fixture {
    bench: Bench<Recording>,
    folder: TempDir,
}

impl Fixture {
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
        let mut imu = Imu::default();
        imu.angular_velocity.z = 0.5;
        let fix = PositionFix {
            x: 3.0,
            y: 4.0,
            ..PositionFix::default()
        };
        let mut line = LineSensor::default();
        line.brightness.push(0.25).expect("room for one");
        let body = Body {
            footprint: Footprint::circle(0.3),
            ..Body::default()
        };
        put(&recorder, "/pioneer/imu", &imu);
        put(&recorder, "/pioneer/position", &fix);
        put(&recorder, "/pioneer/line_sensor", &line);
        put(&recorder, "/pioneer/body", &body);
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
        let mut fixture = Self {
            bench: Bench::new(),
            folder,
        };
        fixture.bench.set("file", text(&fixture.file()));
        fixture
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
        self.bench.exported("playback").expect("it is exported")
    }

    /// The first range of the exported scan, m.
    fn first_range(&self) -> Option<f32> {
        let laser: LaserScan = self.bench.exported("laser")?;
        laser.ranges.first().copied()
    }

    #[track_caller]
    fn refused(mut self) -> String {
        let problems = self.bench.inspect().expect("it inspects");
        let refused = self.bench.awake().map_err(|Failure { reason, .. }| reason);
        let reason = refused.expect_err("it cannot be played");
        let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
        assert_eq!(messages, [&*reason], "an inspection reports the same");
        reason
    }
}

fn recorder(file: &Path) -> Recorder {
    let options = RecorderOptions {
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
        on_trouble: Box::new(|error| panic!("{error}")),
    };
    Recorder::create(file, options).expect("a file")
}

/// Records a value at 60 ms.
fn put<T: Value>(recorder: &Recorder, topic: &str, value: &T) {
    let topic = recorder.topic(topic, Arc::new(T::describe()), BTreeMap::new());
    topic.put(value.as_bytes(), stamps(60 * MS, 0, 1));
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
fn a_drive_is_played_at_its_recorded_times() {
    let mut fixture = Fixture::new().awake();
    assert_eq!(fixture.at(0.0).messages, 1);
    assert_eq!(fixture.first_range(), Some(0.0), "the first topic of the type");
    let playback = fixture.at(0.25);
    assert_eq!((playback.position, playback.length), (0.25, 10.0));
    assert_eq!(fixture.first_range(), Some(0.2));
    let odometry: Odometry = fixture
        .bench
        .exported("odometry")
        .expect("it has played the pose");
    assert!((odometry.pose2d().x - 1.0).abs() < 1e-9);
    assert_eq!(
        fixture.bench.exported_at("laser"),
        Some(Duration::from_millis(170)),
        "measured 30 ms before it was published, which was at 0.2 s"
    );
    let imu: Imu = fixture.bench.exported("imu").expect("it has played one");
    assert_eq!(imu.angular_velocity.z, 0.5);
    let fix: PositionFix = fixture.bench.exported("position_fix").expect("it has played one");
    assert_eq!((fix.x, fix.y), (3.0, 4.0));
    let line: LineSensor = fixture.bench.exported("line_sensor").expect("it has played one");
    assert_eq!(line.brightness.as_slice(), [0.25]);
    let body: Body = fixture.bench.exported("body").expect("it has played one");
    assert_eq!(body.footprint.radius, 0.3);
    let laser: LaserScan = fixture.bench.exported("laser").expect("it is exported");
    assert_eq!(laser.header.stamp, Duration::from_millis(170).into());
    fixture.at(20.0);
    let mission: Mission = fixture.bench.exported("mission").expect("it is exported");
    assert_eq!(
        (mission.state, fixture.first_range()),
        (Mission::DONE, Some(10.0))
    );
}

#[test]
fn a_named_topic_is_played_instead_of_the_first() {
    let mut fixture = Fixture::new();
    fixture.bench.set("laser_topic", Text::<120>::new("/rear/laser"));
    let mut fixture = fixture.awake();
    fixture.at(0.0);
    assert_eq!(fixture.first_range(), Some(100.0));
}

#[test]
fn a_sensor_that_was_not_recorded_has_no_value() {
    let mut fixture = Fixture::new().awake();
    fixture.at(5.0);
    assert!(fixture.bench.exported::<BatteryState>("battery").is_none());
}

#[test]
fn a_change_of_speed_does_not_change_the_position() {
    let mut fixture = Fixture::new().awake();
    fixture.at(0.0);
    fixture.bench.set("speed", 4.0);
    assert_eq!(fixture.at(1.0).position, 4.0);
    fixture.bench.set("speed", 0.5);
    assert_eq!(fixture.at(2.0).position, 4.5);
    assert_eq!(fixture.first_range(), Some(4.5));
}

#[test]
fn a_step_in_a_pause_plays_messages() {
    let mut fixture = Fixture::new().awake();
    fixture.at(0.0);
    fixture.at(1.0);
    fixture.bench.set("paused", Flag::TRUE);
    let playback = fixture.at(3.0);
    assert_eq!((playback.position, playback.playing), (1.0, Flag::FALSE));
    let before = playback.messages;
    fixture.bench.set("step", 2_u32);
    let playback = fixture.at(4.0);
    assert_eq!(
        (playback.messages - before, fixture.first_range()),
        (2, Some(1.2))
    );
    assert_eq!(
        fixture.at(5.0).messages,
        playback.messages,
        "a step is performed once"
    );
    fixture.bench.set("step", 2_u32);
    fixture.at(6.0);
    assert_eq!(fixture.first_range(), Some(1.4), "a second write steps again");
    fixture.bench.set("paused", Flag::FALSE);
    fixture.at(6.5);
    fixture.at(7.0);
    assert_eq!(
        fixture.first_range(),
        Some(2.4),
        "it continues from the last step"
    );
}

#[test]
fn a_jump_exports_the_values_in_force_at_the_new_position() {
    let mut fixture = Fixture::new().awake();
    fixture.at(0.0);
    fixture.bench.set("position", 7.05);
    assert_eq!(fixture.at(1.0).position, 7.05);
    assert_eq!(fixture.first_range(), Some(7.0));
    fixture.bench.set("position", 2.05);
    fixture.at(1.5);
    assert_eq!(fixture.first_range(), Some(2.0));
    fixture.bench.set("paused", Flag::TRUE);
    fixture.bench.set("position", 9.0);
    fixture.at(2.0);
    assert_eq!(fixture.first_range(), Some(8.9), "a jump also works in a pause");
}

#[test]
fn the_playback_begins_at_the_given_position() {
    let mut fixture = Fixture::new();
    fixture.bench.set("position", 3.0);
    let mut fixture = fixture.awake();
    assert_eq!(fixture.at(0.0).position, 3.0);
    assert_eq!(fixture.at(1.0).position, 4.0);
}

#[test]
fn with_repeat_the_playback_starts_again() {
    let mut fixture = Fixture::new();
    fixture.bench.set("repeat", Flag::TRUE);
    let mut fixture = fixture.awake();
    fixture.at(0.0);
    fixture.at(10.5);
    assert_eq!(fixture.first_range(), Some(10.0));
    let mission: Mission = fixture.bench.exported("mission").expect("it is exported");
    assert_eq!(mission.state, Mission::RUNNING, "the mission never ends");
    let playback = fixture.at(10.6);
    assert_eq!((playback.position, playback.playing), (0.0, Flag::TRUE));
    fixture.at(11.1);
    assert_eq!(fixture.first_range(), Some(0.5));
}

#[test]
fn a_command_is_exported_and_has_no_effect() {
    let mut fixture = Fixture::new().awake();
    fixture.at(0.0);
    fixture.bench.command("velocity", &Twist::planar(0.2, 0.5));
    fixture.at(0.5);
    assert_eq!(fixture.bench.exported("wanted"), Some(Twist::planar(0.2, 0.5)));
}

#[test]
fn time_asleep_does_not_advance_the_recording() {
    let mut fixture = Fixture::new().awake();
    fixture.at(0.0);
    fixture.at(1.0);
    fixture.bench.sleep().expect("it sleeps");
    fixture.bench.set_now(Duration::from_secs(5));
    fixture.bench.awake().expect("it wakes");
    assert_eq!(fixture.at(6.0).position, 2.0);
}

#[test]
fn a_truncated_recording_is_played_to_its_end() {
    let fixture = Fixture::new();
    let bytes = fs::read(fixture.file()).expect("it was written");
    fs::write(fixture.file(), &bytes[..bytes.len() - 200]).expect("it is truncated");
    let mut fixture = fixture.awake();
    let warned = fixture
        .bench
        .log()
        .iter()
        .any(|(_, text)| text.contains("it ends too soon, at byte"));
    assert!(warned, "{:?}", fixture.bench.log());
    fixture.at(0.0);
    fixture.at(30.0);
    let mission: Mission = fixture.bench.exported("mission").expect("it is exported");
    assert_eq!(mission.state, Mission::DONE);
}

#[test]
fn an_unplayable_recording_is_refused_with_its_reason() {
    let mut fixture = Fixture::new();
    fixture.bench.set("laser_topic", Text::<120>::new("/front/laser"));
    let reason = fixture.refused();
    assert!(
        reason.contains("has no topic `/front/laser`; it has /pioneer/laser"),
        "{reason}"
    );

    let mut fixture = Fixture::new();
    fixture
        .bench
        .set("laser_topic", Text::<120>::new("/pioneer/odometry"));
    let reason = fixture.refused();
    assert!(
        reason.contains("is a nav_msgs/msg/Odometry; expected a sensor_msgs/msg/LaserScan"),
        "{reason}"
    );

    let mut fixture = Fixture::new();
    fixture.bench.set("file", Text::<1024>::default());
    assert!(fixture.refused().contains("--set NAME.file=drive.mcap"));

    let fixture = Fixture::new();
    fs::write(fixture.file(), "not a recording").expect("it is written");
    assert!(fixture.refused().contains("is no MCAP file and no bag of ROS 2"));
}

#[test]
fn depths_come_from_the_named_topic_and_pictures_from_another() {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("camera.mcap");
    let recorder = recorder(&file);
    for (topic, encoding) in [("/a/depth", "32FC1"), ("/b/image", "rgb8")] {
        let mut image = Image::boxed();
        image.encoding = Text::new(encoding);
        put(&recorder, topic, &*image);
    }
    recorder.finish();
    let played = |depth_topic| {
        let mut bench = Bench::<Recording>::new();
        bench.set("file", text(&file));
        bench.set("depth_topic", Text::<120>::new(depth_topic));
        bench.awake().expect("it is a recording");
        bench.set_now(Duration::from_secs(1));
        bench.iterate().expect("it plays");
        let encoding = |export| {
            Some(
                bench
                    .exported_in_place::<Image>(export)?
                    .encoding
                    .as_str()
                    .to_owned(),
            )
        };
        [encoding("image"), encoding("depth")]
    };
    assert_eq!(played("/a/depth"), [Some("rgb8".into()), Some("32FC1".into())]);
    assert_eq!(played(""), [Some("32FC1".into()), None]);
}

#[test]
fn a_recording_without_topics_of_sensors_is_refused() {
    let fixture = Fixture::new();
    fs::remove_file(fixture.file()).expect("it was there");
    let recorder = recorder(&fixture.file());
    let topic = recorder.topic("/mission", Arc::new(Mission::describe()), BTreeMap::new());
    topic.put(Mission::default().as_bytes(), stamps(0, 0, 1));
    recorder.finish();
    let reason = fixture.refused();
    assert!(
        reason.ends_with("has no topic that a robot senses; it has /mission"),
        "{reason}"
    );
}
