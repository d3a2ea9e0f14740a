//! Logs of all formats, with faulty clocks, truncated files, files that are not logs, and two real logs.

use core::f64::consts::{FRAC_PI_2, PI};
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
        "FLASER {count} {} {x} {y} {theta} 9 9 9 {clock} host {clock}\n",
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
fn beams_go_from_right_to_left_over_half_a_turn() {
    for (beams, last) in [(180, 89.0), (181, 90.0), (360, 89.5), (361, 90.0)] {
        let mut player = Player::new(flaser(&vec![1.0; beams], (0.0, 0.0, 0.0), 1.0)).awake();
        player.at(0.0);
        let scan = player.laser();
        assert!((scan.angle(0) + FRAC_PI_2).abs() < 1e-6);
        assert!(
            (scan.angle(beams - 1) - f64::to_radians(last)).abs() < 1e-5,
            "{beams} beams"
        );
        assert!((f64::from(scan.angle_max) - scan.angle(beams - 1)).abs() < 1e-5);
    }
    let one = Scan { ranges: vec![1.0] };
    assert_eq!(one.angle_increment(), PI, "a single beam does not divide by 0");
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
fn a_clock_that_does_not_advance_is_replaced_by_a_rate() {
    let scan = |x| flaser(&[1.0], (x, 0.0, 0.0), 7.0);
    let mut player = Player::new([scan(0.0), scan(1.0), scan(2.0)].concat());
    player.bench.set("interval", 0.5);
    let mut player = player.awake();
    player.assert_warned("its clock stands still at 7 s; the scans are played 0.5 s apart");
    assert_eq!(player.at(0.0).reached, 1);
    assert_eq!(player.at(0.99).reached, 2);
    let mission = player.at(1.0);
    assert_eq!((mission.state, mission.reached), (Mission::DONE, 3));
}

#[test]
fn a_clock_that_goes_back_is_ignored() {
    let scan = |x, clock| flaser(&[1.0], (x, 0.0, 0.0), clock);
    let mut player = Player::new(
        [
            scan(0.0, 100.0),
            scan(1.0, 102.0),
            scan(2.0, 90.0),
            scan(3.0, 103.0),
        ]
        .concat(),
    )
    .awake();
    assert_eq!(player.at(1.9).reached, 1);
    // A scan stamped before the start is played with the record before it.
    assert_eq!(player.at(2.0).reached, 3);
    assert_eq!(player.bench.exported_at("laser"), Some(Duration::from_secs(2)));
    assert_eq!(player.at(3.0).state, Mission::DONE);
}

#[test]
fn a_line_before_the_clock_was_set_does_not_count_from_the_epoch() {
    let scan = |x, clock| flaser(&[1.0], (x, 0.0, 0.0), clock);
    let mut player = Player::new([scan(0.0, 0.0), scan(1.0, 1.1e9), scan(2.0, 1.1e9 + 0.5)].concat()).awake();
    assert_eq!(player.at(0.0).reached, 2);
    assert_eq!(player.at(0.5).state, Mission::DONE);
}

#[test]
fn unreadable_lines_are_skipped_with_warnings() {
    let good = flaser(&[1.0, 2.0], (1.0, 0.0, 0.0), 5.0);
    let bad = [
        "FLASER 3 1.0 2.0\n",
        "FLASER 2 1.0 two 0 0 0 0 0 0 1 host 1\n",
        "FLASER 0 0 0 0 0 0 0 1 host 1\n",
        "FLASER 1089 1\n",
        "FLASER 2.5 1 2 0 0 0 0 0 0 1 host 1\n",
        "FLASER 1 -1 0 0 0 0 0 0 1 host 1\n",
        "FLASER 1 NaN 0 0 0 0 0 0 1 host 1\n",
        "ODOM 1 2\n",
        "FLASER\n",
    ];
    let mut player = Player::new(format!("{}{good}", bad.concat())).awake();
    assert_eq!(player.at(0.0).total, 1);
    player.assert_warned("line 1 is left out: it ends before a range");
    player.assert_warned("line 2 is left out: `two` is not a range");
    player.assert_warned("line 3 is left out: 0 beams; a scan has 1 to 1088");
    player.assert_warned("9 lines in all are left out");
    assert_eq!(player.warnings().len(), 4, "the number of warnings is limited");
}

#[test]
fn each_error_of_a_line_has_its_message() {
    let error = |line: &str| {
        record::parse(line)
            .expect("a line of a known kind")
            .expect_err("an invalid line")
    };
    assert_eq!(error("FLASER 2.5 1 2"), "2.5 beams; a scan has 1 to 1088");
    assert_eq!(error("FLASER 1 -1 0"), "a range of -1 m");
    assert_eq!(error("FLASER 1 NaN 0"), "`NaN` is not a range");
    assert_eq!(
        error("FLASER 1 1 0 0 0 0 0 0 1"),
        "it ends before the host's name"
    );
    assert_eq!(
        error("FLASER 1 1 0 0 0 0 0 0 1 host"),
        "it ends before the logger's time"
    );
    assert_eq!(error("ODOM 1 2 3 4"), "it ends before a turn rate");
    assert_eq!(
        error("ODOM 1 x\u{1b}[2J 3"),
        "`x\\u{1b}[2J` is not y",
        "control characters of a file are escaped"
    );
    assert_eq!(record::parse("RLASER1 3 1 2 3"), None);
    assert_eq!(record::parse(""), None);
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
    player.assert_warned("line 199 is left out");
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
        reason.ends_with("drive.log has no scan: not one of its 0 lines is a FLASER line that can be read"),
        "{reason}"
    );
    let reason = refused(Player::new("ODOM 1 2 3 0 0 0 1 host 1\nFLASER 2 1\n"));
    assert!(
        reason.ends_with("can be read; line 2 is left out: it ends before a range"),
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

/// Plays a log of the Radish data sets to its end. The data sets are not part of the project.
fn play_real_log(name: &str, beams: usize, scans: u32) {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if !path.exists() {
        eprintln!("skipped: there is no {}", path.display());
        return;
    }
    let mut player = Player::new("");
    player.bench.set("path", text(&path));
    let mut player = player.awake();
    let (mut played, mut last, mut seconds) = (0, Duration::ZERO, 0.0);
    loop {
        let mission = player.at(seconds);
        if mission.reached > played {
            played = mission.reached;
            assert_eq!(player.laser().ranges.len(), beams);
            let time = player.bench.exported_at("laser").expect("it has played a scan");
            assert!(time >= last, "time does not go back");
            last = time;
        }
        if mission.state == Mission::DONE {
            break;
        }
        seconds += 0.5;
    }
    assert_eq!(played, scans);
}

#[test]
fn a_real_building_of_180_beams() {
    play_real_log("intel-corrected.log.gz", 180, 910);
}

#[test]
fn a_real_building_of_361_beams() {
    play_real_log("csail-corrected.log.gz", 361, 406);
}
