//! Logs that are played, truncated files, files that are not logs, and real logs.

mod clocks;
mod formats;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use jde_schema::Severity;
use jde_schema::bench::{Bench, Failure};
use tempfile::TempDir;

use super::*;

/// A log in a folder of its own, and the driver that plays it.
struct Player {
    bench: Bench<Log>,
    folder: TempDir,
}

impl Player {
    fn new(bytes: impl AsRef<[u8]>) -> Self {
        let folder = TempDir::new().expect("a folder");
        fs::write(folder.path().join("drive.log"), bytes).expect("a file");
        let mut player = Self {
            bench: Bench::new(),
            folder,
        };
        player.bench.set("path", player.path());
        player
    }

    fn path(&self) -> Text<1024> {
        text(&self.folder.path().join("drive.log"))
    }

    fn awake(mut self) -> Self {
        self.bench.awake().expect("it is a log");
        self
    }

    /// Iterates at a time of the log, s.
    fn at(&mut self, seconds: f64) -> Mission {
        self.bench.set_now(Duration::from_secs_f64(seconds));
        self.bench.iterate().expect("it plays");
        self.bench.exported("mission").expect("it is exported")
    }

    fn laser(&self) -> Box<LaserScan> {
        Box::new(self.bench.exported("laser").expect("it has played a scan"))
    }

    fn pose(&self) -> Pose2D {
        let odometry: Odometry = self.bench.exported("odometry").expect("it has played a pose");
        odometry.pose2d()
    }

    fn warnings(&self) -> Vec<&str> {
        let warnings = self
            .bench
            .log()
            .iter()
            .filter(|(severity, _)| *severity == Severity::Warn);
        warnings.map(|(_, text)| &**text).collect()
    }

    #[track_caller]
    fn assert_warned(&self, expected: &str) {
        let warnings = self.warnings();
        assert!(
            warnings.iter().any(|warning| warning.contains(expected)),
            "`{expected}` is not in {warnings:?}"
        );
    }
}

fn text(path: &Path) -> Text<1024> {
    Text::new(path.to_str().expect("a path in UTF-8"))
}

/// A line with a scan of these ranges at this pose, and the logger's clock.
fn flaser(ranges: &[f64], (x, y, theta): (f64, f64, f64), clock: f64) -> String {
    let ranges: Vec<String> = ranges.iter().map(f64::to_string).collect();
    let count = ranges.len();
    format!(
        "FLASER {count} {} {x} {y} {theta} {x} {y} {theta} {clock} host {clock}\n",
        ranges.join(" ")
    )
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer.write_all(bytes).expect("it fits in memory");
    packer.finish().expect("it fits in memory")
}

fn drive() -> String {
    let head = "# CARMEN Logfile\nPARAM robot_length 0.5\nSYNC tag\n";
    let odom = "ODOM 1.5 2.5 0.25 0.4 0.1 0 11.5 host 11.5\n";
    let first = flaser(&[1.0, 2.0, 3.0, 81.83], (1.0, 2.0, 0.1), 11.0);
    let last = flaser(&[4.0, 3.0, 2.0, 1.0], (2.0, 3.0, 0.4), 12.0);
    format!("{head}{first}{odom}{last}")
}

#[test]
fn a_drive_is_played_at_the_times_of_the_log() {
    let mut player = Player::new(drive()).awake();
    let mission = player.at(0.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::RUNNING, 1, 2)
    );
    assert_eq!(player.laser().ranges.as_slice(), [1.0, 2.0, 3.0, f32::INFINITY]);

    player.at(0.49);
    assert_eq!(player.pose().x, 1.0, "the pose of the wheels is at 0.5 s");
    let mission = player.at(0.7);
    assert!(player.pose().distance_to(&Pose2D::new(1.5, 2.5, 0.25)) < 1e-9);
    assert_eq!(
        player.bench.exported_at("odometry"),
        Some(Duration::from_millis(500)),
        "the time of the log, not that of the iteration"
    );
    assert_eq!((mission.state, mission.reached), (Mission::RUNNING, 1));

    let mission = player.at(1.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 2, 2)
    );
    assert_eq!(player.laser().ranges.as_slice(), [4.0, 3.0, 2.0, 1.0]);
    assert!((player.pose().theta - 0.4).abs() < 1e-9);
    assert_eq!(player.warnings(), [""; 0]);
}

#[test]
fn skipped_records_are_played_later() {
    let mut player = Player::new(drive()).awake();
    let mission = player.at(60.0);
    assert_eq!((mission.state, mission.reached), (Mission::DONE, 2));
    assert_eq!(player.pose().x, 2.0);
}

#[test]
fn gzip_plain_and_windows_lines_give_the_same_drive() {
    let plain = drive();
    let windows = plain.replace('\n', "\r\n");
    // Two gzip members in one file, as `cat a.gz b.gz` writes them.
    let (head, tail) = plain.split_at(plain.find("ODOM").expect("the log has one"));
    let members = [gzip(head.as_bytes()), gzip(tail.as_bytes())].concat();
    for bytes in [
        plain.clone().into_bytes(),
        windows.into_bytes(),
        gzip(plain.as_bytes()),
        members,
    ] {
        let mut player = Player::new(bytes).awake();
        assert_eq!(player.at(1.0).reached, 2);
        assert_eq!(player.laser().ranges.as_slice(), [4.0, 3.0, 2.0, 1.0]);
        assert_eq!(player.warnings(), [""; 0]);
    }
}

#[test]
fn a_command_is_exported_while_it_is_in_force() {
    let mut player = Player::new(drive()).awake();
    player.at(0.0);
    assert_eq!(
        player.bench.exported("wanted"),
        Some(Twist::ZERO),
        "no command yet"
    );
    player.bench.command("velocity", &Twist::planar(0.2, 0.5));
    player.at(0.5);
    assert_eq!(player.bench.exported("wanted"), Some(Twist::planar(0.2, 0.5)));
    player.at(1.5);
    assert_eq!(
        player.bench.exported("wanted"),
        Some(Twist::ZERO),
        "the validity has expired"
    );
}

#[test]
fn a_sleep_does_not_reset_the_position() {
    let mut player = Player::new(drive()).awake();
    player.at(0.0);
    player.bench.sleep().expect("it sleeps");
    player.bench.awake().expect("it wakes");
    assert_eq!(player.at(0.1).reached, 1);
    assert_eq!(player.at(1.0).reached, 2);
}

#[test]
fn unreadable_lines_are_left_out_with_their_place() {
    let good = flaser(&[1.0, 2.0], (1.0, 0.0, 0.0), 5.0);
    let bad = [
        "FLASER 3 1.0 2.0\n",
        "FLASER 2 1.0 two 0 0 0 0 0 0 1 host 1\n",
        "FLASER 0 0 0 0 0 0 0 1 host 1\n",
        "FLASER 99999 1\n",
        "FLASER 2.5 1 2 0 0 0 0 0 0 1 host 1\n",
        "ODOM 1 2\n",
        "NEFF 30 1 host 1\n",
        "FLASER 9\n",
        "\u{1b}[2J\n",
    ];
    let mut player = Player::new(format!("{}{good}", bad.concat())).awake();
    assert_eq!(player.at(0.0).total, 1);
    player.assert_warned("a FLASER line is left out: it ends before a range (line 1, and 1 more)");
    player.assert_warned("a FLASER line is left out: `two` is not a range (line 2)");
    player.assert_warned("NEFF is left out: it has neither a scan nor the pose of the robot (line 7)");
    player.assert_warned("a line without the name of a message is left out");
    assert_eq!(player.warnings().len(), 8);
}

#[test]
fn a_truncated_log_is_played_to_its_end() {
    let scan = |index: u32| {
        flaser(
            &[f64::from(index); 90],
            (f64::from(index), 0.0, 0.0),
            f64::from(index),
        )
    };
    let plain: String = (1..200).map(scan).collect();
    let packed = gzip(plain.as_bytes());
    let mut player = Player::new(&packed[..packed.len() / 2]).awake();
    player.assert_warned("the file is cut short after line");
    player.assert_warned("only the part before is played");
    let mission = player.at(1000.0);
    assert!((1..199).contains(&mission.reached), "{} scans", mission.reached);
    assert_eq!((mission.state, mission.total), (Mission::DONE, mission.reached));

    let mut player = Player::new(&plain[..plain.len() - 40]).awake();
    player.assert_warned("it ends before a range (line 199)");
    assert_eq!(player.at(1000.0).reached, 198);
}

#[track_caller]
fn refused(player: Player) -> String {
    let mut player = player;
    let problems = player.bench.inspect().expect("it inspects");
    let refused = player.bench.awake().map_err(|Failure { reason, .. }| reason);
    let reason = refused.expect_err("it is not a log");
    let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
    assert_eq!(messages, [&*reason], "an inspection reports the same");
    reason
}

#[test]
fn a_file_that_is_not_a_log_is_refused_by_its_name() {
    let reason = refused(Player::new(""));
    assert!(
        reason.ends_with(
            "drive.log has no scan: not one of its 0 lines is a FLASER or ROBOTLASER1 line that can be read"
        ),
        "{reason}"
    );
    let reason = refused(Player::new("ODOM 1 2 3 0 0 0 1 host 1\nFLASER 2 1\n"));
    assert!(
        reason.ends_with("can be read; a FLASER line is left out: it ends before a range (line 2)"),
        "{reason}"
    );
    let noise: Vec<u8> = (0..100_000_u32)
        .map(|number| (number.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let reason = refused(Player::new(&noise));
    assert!(reason.contains("drive.log has no scan"), "{reason}");
    let reason = refused(Player::new([&[0x1f, 0x8b], &noise[..]].concat()));
    assert!(
        reason.starts_with("cannot read the log") && reason.contains("drive.log"),
        "{reason}"
    );
}

#[test]
fn a_log_of_which_nothing_can_be_used_is_refused() {
    let blind = |range: f64| {
        let scan = |clock| flaser(&[range; 9], (clock, 0.0, 0.0), clock);
        refused(Player::new([scan(1.0), scan(2.0)].concat()))
    };
    for range in [0.0, -1.0, f64::NAN] {
        let reason = blind(range);
        assert!(
            reason.ends_with("no beam of its 2 scans ends at an object"),
            "{reason}"
        );
    }
    let reason = refused(Player::new("RAWLASER1 0 -1 2 1 50 0.01 0 3 1 1 1 0 1 host 1\n"));
    assert!(
        reason.ends_with("its scans have no poses, and it has no ODOM line"),
        "{reason}"
    );
}

#[test]
fn a_missing_log_is_reported_by_its_name() {
    let mut player = Player::new("");
    player
        .bench
        .set("path", text(&player.folder.path().join("other.log")));
    let reason = refused(player);
    assert!(reason.contains("other.log: No such file"), "{reason}");
    let mut player = Player::new("");
    player.bench.set("path", Text::<1024>::default());
    let reason = refused(player);
    assert!(reason.contains("--set NAME.path=drive.log.gz"), "{reason}");
}

/// Plays a real log to its end, which takes at least so long: no log is played in an instant, whatever its clocks say. The
/// data sets are not part of the project.
fn play_real_log(name: &str, beams: usize, scans: u32, least_seconds: f64) {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if !path.exists() {
        eprintln!("skipped: there is no {}", path.display());
        return;
    }
    let mut player = Player::new("");
    player.bench.set("path", text(&path));
    let mut player = player.awake();
    let (mut played, mut last, mut seconds) = (0, None, 0.0);
    let mut way = 0.0;
    loop {
        let mission = player.at(seconds);
        if mission.reached > played {
            assert!(
                mission.reached - played <= 4,
                "scans are played one after the other"
            );
            played = mission.reached;
            assert_eq!(player.laser().ranges.len(), beams);
            let time = player.bench.exported_at("laser").expect("it has played a scan");
            let pose = player.pose();
            if let Some((before, from)) = last.replace((time, pose)) {
                assert!(time > before, "time goes on");
                way += pose.distance_to(&from);
            }
        }
        if mission.state == Mission::DONE {
            break;
        }
        seconds += 0.4;
    }
    assert_eq!(played, scans);
    assert!(seconds >= least_seconds, "{seconds} s");
    assert!((100.0..1000.0).contains(&way), "{way} m");
}

#[test]
fn a_real_building_of_180_beams() {
    play_real_log("intel-corrected.log.gz", 180, 910, 2600.0);
}

#[test]
fn a_real_building_of_361_beams_with_a_rounded_clock() {
    play_real_log("csail-corrected.log.gz", 361, 406, 200.0);
}

#[test]
fn a_real_building_in_the_newer_message() {
    play_real_log("flirt/fr079.log.gz", 360, 1464, 900.0);
}
