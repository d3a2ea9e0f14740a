//! The delivered application, whose laser an operator lets fail.

use std::path::Path;
use std::time::Duration;

use jde_core::SchemaId;
use jde_host::{Handle, Lockstep, Options, SensorFault};
use jde_types::{LaserScan, Odometry, Pose2D, RangeRing, Value};

use crate::delivered::{self, ROOT, SECOND};

struct Drive {
    running: Lockstep,
    pioneer: SchemaId,
}

impl Drive {
    fn start(seed: u64) -> Self {
        let plugins = delivered::plugins();
        let file = Path::new(ROOT).join("apps/safe-navigation.toml");
        let mut application = jde_app::load(&file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
        application.seed = seed;
        let mut running = Lockstep::start(application, &plugins, Options::default())
            .unwrap_or_else(|error| panic!("{error}"));
        running.run_until(2 * SECOND);
        let pioneer = running.handle().application().instance("pioneer");
        let pioneer = pioneer.expect("it is in the application");
        Self { running, pioneer }
    }

    fn failing(seed: u64, export: &str, fault: SensorFault) -> Self {
        let mut drive = Self::start(seed);
        let operator = drive.handle().operator("ana");
        operator
            .fail_export(drive.pioneer, export, fault)
            .expect("it is an export");
        drive.run(3);
        drive
    }

    fn run(&mut self, seconds: u64) {
        self.run_for(seconds * SECOND);
    }

    fn run_for(&mut self, time: u64) {
        let now = self.running.handle().now();
        self.running.run_until(now + time);
    }

    fn handle(&self) -> Handle {
        self.running.handle()
    }

    /// Where the robot is, by its odometry.
    fn place(&self) -> Pose2D {
        let odometry = self.odometry();
        odometry.expect("it was published").pose2d()
    }

    fn odometry(&self) -> Option<Odometry> {
        self.handle().value("pioneer.odometry").expect("it is an export")
    }

    fn scan(&self) -> Option<Box<LaserScan>> {
        let scan = self.handle().value("pioneer.laser").expect("it is an export");
        scan.map(Box::new)
    }
}

fn scan_of(drive: &Drive) -> Box<LaserScan> {
    drive.scan().expect("it was published")
}

#[test]
fn r16_noise_on_a_laser_repeats_to_the_bit_with_the_seed() {
    let noise = SensorFault::Noise { sigma: 0.1 };
    let [one, same, other] = [7, 7, 8].map(|seed| scan_of(&Drive::failing(seed, "laser", noise)));
    assert_eq!(one.as_bytes(), same.as_bytes());
    assert_ne!(one.ranges, other.ranges);
    let plain = scan_of(&Drive::failing(7, "sonars", noise));
    assert_eq!(one.range_max, plain.range_max, "only the ranges are noisy");
    assert!(one.ranges.iter().all(|range| *range >= 0.0));
    // The robots may have driven differently for three seconds, but not by much.
    let changed = one.ranges.iter().zip(plain.ranges.iter()).filter(|(a, b)| a != b);
    assert!(changed.count() > 100);
}

#[test]
fn beams_that_are_blocked_read_the_given_range() {
    let blocked = |range| SensorFault::Blocked {
        first: 10,
        last: 20,
        range,
    };
    let drive = Drive::failing(7, "laser", blocked(f32::INFINITY));
    let scan = scan_of(&drive);
    assert!(scan.ranges[10..=20].iter().all(|range| range.is_infinite()));
    assert!(scan.ranges[..10].iter().all(|range| range.is_finite()));
    let drive = Drive::failing(7, "sonars", blocked(0.5));
    let sonars: Option<RangeRing> = drive.handle().value("pioneer.sonars").expect("it is an export");
    let sonars = sonars.expect("it was published");
    assert!(sonars.ranges.len() < 20, "beams that are not there are left out");
    assert!(sonars.ranges[10..].iter().all(|range| *range == 0.5));
    assert!(sonars.ranges[..10].iter().any(|range| *range != 0.5));
}

#[test]
fn r14_a_laser_whose_limits_contradict_each_other_has_no_value_and_one_that_is_late_an_old_one() {
    let mut drive = Drive::failing(7, "laser", SensorFault::Contradictory);
    assert_eq!(drive.scan(), None);
    let stands = drive.place();
    drive.run(1);
    assert_eq!(drive.place(), stands, "nobody drives by it");

    let mut drive = Drive::start(7);
    let before = scan_of(&drive);
    let operator = drive.handle().operator("ana");
    let late = SensorFault::Late { by: SECOND * 5 / 2 };
    operator
        .fail_export(drive.pioneer, "laser", late)
        .expect("it is an export");
    drive.run(2);
    assert_eq!(
        drive.scan(),
        None,
        "nothing is as old, and the last one has ended"
    );
    drive.run(1);
    let scan = scan_of(&drive);
    let age = drive.handle().now() - Duration::from(scan.header.stamp).as_nanos() as u64;
    assert!((SECOND * 5 / 2..SECOND * 3).contains(&age), "{age}");
    assert_ne!(scan.ranges, before.ranges, "it moves on");
    let refused = operator.fail_export(drive.pioneer, "laser", SensorFault::Late { by: 61 * SECOND });
    assert!(refused.is_err_and(|why| why.contains("at most 60 s")));
}

#[test]
fn a_laser_that_repeats_itself_while_the_base_moves_and_a_silent_one_have_no_value() {
    let mut drive = Drive::failing(7, "laser", SensorFault::Frozen);
    assert_eq!(drive.scan(), None, "the base has moved by 0.1 m");
    let stands = drive.place();
    drive.run(3);
    assert_eq!(drive.scan(), None, "although it is published again and again");
    assert_eq!(drive.place(), stands, "nobody drives by it");
    let operator = drive.handle().operator("ana");
    operator.repair_export(drive.pioneer, "laser").expect("it fails");
    drive.run(1);
    assert!(
        drive.scan().is_some() && drive.place() != stands,
        "it measures again"
    );
    operator
        .fail_export(drive.pioneer, "laser", SensorFault::Silent)
        .expect("it is an export");
    assert_eq!(drive.scan(), None, "at once");
    drive.run(3);
    assert_eq!(drive.scan(), None);
}

#[test]
fn a_laser_that_measures_nothing_has_no_value_and_one_that_repeats_itself_has_one_while_the_base_stands() {
    let all = |range| SensorFault::Blocked {
        first: 0,
        last: 1087,
        range,
    };
    for nothing in [0.0, -1.0, 8.1, 0.001] {
        let mut drive = Drive::failing(7, "laser", all(nothing));
        assert_eq!(drive.scan(), None, "{nothing}");
        let stands = drive.place();
        drive.run(2);
        assert_eq!(drive.place(), stands, "{nothing}");
    }
    let mut drive = Drive::start(7);
    let operator = drive.handle().operator("ana");
    operator.stop_all().expect("it can stop");
    drive.run(3);
    operator
        .fail_export(drive.pioneer, "laser", all(0.5))
        .expect("it is an export");
    drive.run(3);
    assert_eq!(scan_of(&drive).points().count(), 180);
    let stands = drive.place();
    drive.run(3);
    assert_eq!(drive.place(), stands, "it is stopped");
    assert_eq!(scan_of(&drive).points().count(), 180);
    let free = scan_of(&Drive::failing(7, "laser", all(8.0)));
    assert_eq!(free.points().count(), 0, "the greatest distance is no wall");
}

#[test]
fn r19_an_odometry_that_repeats_itself_while_it_states_a_velocity_has_no_value() {
    let mut drive = Drive::start(7);
    let before = drive.place();
    let operator = drive.handle().operator("ana");
    operator
        .fail_export(drive.pioneer, "odometry", SensorFault::Frozen)
        .expect("it is an export");
    drive.run(3);
    assert_eq!(drive.odometry(), None);
    drive.run(10);
    assert_eq!(drive.odometry(), None, "whatever is commanded");
    operator
        .repair_export(drive.pioneer, "odometry")
        .expect("it fails");
    drive.run_for(SECOND / 10);
    let way = drive.place().distance_to(&before);
    assert!(way < 0.5, "it drove {way:.2} m without an odometry");
    drive.run(2);
    assert!(drive.place().distance_to(&before) > way + 0.1, "it drives again");
}

#[test]
fn r19_an_odometry_that_repeats_itself_has_a_value_until_the_base_is_commanded_to_move() {
    let mut drive = Drive::start(7);
    let operator = drive.handle().operator("ana");
    operator.stop_all().expect("it can stop");
    drive.run(3);
    let stands = drive.place();
    operator
        .fail_export(drive.pioneer, "odometry", SensorFault::Frozen)
        .expect("it is an export");
    drive.run(30);
    assert!(drive.odometry().is_some(), "it may stand");
    operator.release_all().expect("it may go on");
    // It tries again after pauses of 1, 2, 4 and 8 s.
    let mut tries = 0;
    let mut had_value = true;
    for _ in 0..300 {
        drive.run_for(SECOND / 10);
        let has_value = drive.odometry().is_some();
        tries += usize::from(had_value && !has_value);
        had_value = has_value;
    }
    assert!((3..=6).contains(&tries), "{tries}");
    operator
        .repair_export(drive.pioneer, "odometry")
        .expect("it fails");
    drive.run(10);
    assert!(drive.place().distance_to(&stands) > 0.5, "it drives again");
}
