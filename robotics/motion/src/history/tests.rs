//! Times of sensors and what is known of the base at them.

use proptest::prelude::*;

use super::*;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The odometry of a base that has driven so long at `twist`, each 40 ms.
fn driven(twist: Twist, until: u64) -> OdometryHistory {
    let mut history = OdometryHistory::default();
    for at in (0..=until).step_by(40) {
        let pose = arc(&twist, at as f64 / 1000.0);
        history.add(ms(at), &Odometry::planar(ms(at), pose, twist));
    }
    history
}

/// What a laser sees of a wall 2 m ahead of the first pose, with beams that follow each other by `increment` s.
fn wall(twist: Twist, begins: f64, increment: f64) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -0.6,
        angle_increment: 0.012,
        range_min: 0.1,
        range_max: 30.0,
        time_increment: increment as f32,
        ..LaserScan::default()
    };
    for beam in 0..100 {
        let laser = arc(&twist, begins + increment * beam as f64);
        let angle = laser.theta + scan.angle(beam);
        scan.ranges
            .push(((2.0 - laser.x) / angle.cos()) as f32)
            .expect("few beams");
    }
    scan.state_last_angle();
    scan
}

#[test]
fn each_jump_counts_and_a_motion_is_none() {
    let mut history = driven(Twist::planar(0.4, 0.5), 2000);
    assert_eq!(history.jumps(), 0);
    let here = |x, turn| Odometry::planar(ms(0), Pose2D::new(x, 0.0, turn), Twist::ZERO);
    let mut jumps = |at: u64, odometry: &Odometry| {
        history.add(ms(at), odometry);
        history.jumps()
    };
    assert_eq!(jumps(3000, &here(30.0, 0.0)), 1);
    assert_eq!(jumps(3100, &here(30.2, 0.4)), 1);
    assert_eq!(jumps(3100, &here(30.6, 0.4)), 2, "at the same time");
    assert_eq!(jumps(3200, &here(30.6, 1.0)), 3);
    assert_eq!(jumps(3200, &here(f64::NAN, 1.0)), 4);
    assert_eq!(jumps(3300, &here(30.6, 1.0)), 4);
    assert_eq!(jumps(3000, &here(30.6, 1.0)), 5, "the clock was set back");
}

#[test]
fn a_time_of_another_clock_is_refused_in_words() {
    let history = driven(Twist::planar(0.4, 0.0), 2000);
    let words = |seen: u64, now: u64| history.base("scans", ms(seen), ms(now)).unwrap_err();
    assert_eq!(
        words(5000, 2000),
        "the scans are stamped 3.0 s ahead of the clock of this machine: set the clock of their sensor by it"
    );
    assert_eq!(
        words(1000, 60_000),
        "the scans are stamped 59.0 s behind the clock of this machine: set the clock of their sensor by it"
    );
    assert_eq!(words(900, 2000), "the scans are 1.1 s old");
    assert_eq!(words(1900, 3000), "the scans are 1.1 s old");
    assert_eq!(words(2600, 3000), "the scans are 0.6 s newer than the odometry");
    assert!(history.base("scans", ms(1000), ms(2000)).is_ok());
    let none = OdometryHistory::default();
    assert_eq!(
        none.base("scans", ms(0), ms(0)).unwrap_err(),
        "there is no odometry"
    );
}

#[test]
fn a_jump_of_the_odometry_is_no_motion() {
    let twist = Twist::planar(0.5, 0.0);
    let mut history = driven(twist, 400);
    let jumped = Pose2D::new(7.0, 3.0, 1.0);
    history.add(ms(440), &Odometry::planar(ms(440), jumped, twist));
    let then = history.base("scans", ms(340), ms(440)).expect("by the velocity");
    assert!((jumped.localize(&then).x + 0.05).abs() < 1e-9, "{then:?}");
    // An earlier time, and a pose that is none.
    history.add(ms(40), &Odometry::planar(ms(40), Pose2D::ORIGIN, twist));
    assert!(history.base("scans", ms(440), ms(440)).is_ok());
    assert!(history.base("scans", ms(640), ms(640)).is_err());
    let mut none = Odometry::planar(ms(80), Pose2D::ORIGIN, twist);
    none.pose.pose.position.x = f64::NAN;
    history.add(ms(80), &none);
    assert!(history.base("scans", ms(80), ms(80)).is_err());
}

#[test]
fn a_scan_whose_newest_beam_nobody_can_place_is_refused() {
    let history = driven(Twist::planar(0.4, 0.5), 1000);
    let scan = wall(Twist::ZERO, 0.0, 0.003);
    assert!(history.sweep(&scan, ms(1200), ms(1500)).is_ok());
    let words = history.sweep(&scan, ms(1400), ms(1700)).unwrap_err();
    assert_eq!(words, "the scans are 0.7 s newer than the odometry");
}

#[test]
fn numbers_that_are_no_times_undistort_nothing() {
    let history = driven(Twist::planar(0.5, 1.0), 1000);
    let sweep = |time_increment: f32, scan_time: f32| {
        let scan = LaserScan {
            time_increment,
            scan_time,
            ..wall(Twist::ZERO, 0.0, 0.0)
        };
        history.sweep(&scan, ms(500), ms(1000)).expect("in time").motion
    };
    for increment in [0.0, f32::NAN, f32::INFINITY] {
        assert_eq!(sweep(increment, 0.1), Pose2D::ORIGIN, "{increment}");
    }
    assert!((sweep(0.001, 0.1).x - 0.0495).abs() < 1e-3);
    assert!((sweep(1.0, 0.2).x - 0.1).abs() < 1e-3, "no longer than a scan");
    assert!(
        (sweep(-0.001, 0.1).x + 0.0495).abs() < 1e-3,
        "the first beam is measured last"
    );
}

proptest! {
    #[test]
    fn a_wall_is_straight_however_the_base_moves_while_the_laser_turns(
        speed in -1.0..1.0f64, turn in -0.8..0.8f64, begins in 200..600u64, increment in -0.002..0.002f64, until in 900..1200u64,
    ) {
        let twist = Twist::planar(speed, turn);
        let history = driven(twist, until);
        let now = ms(until / 40 * 40);
        let scan = wall(twist, begins as f64 / 1000.0, increment);
        let oldest = begins as f64 / 1000.0 + (increment * 99.0).min(0.0);
        let Ok(sweep) = history.sweep(&scan, Duration::from_secs_f64(oldest), now) else {
            prop_assert!(now.as_secs_f64() - oldest > MAX_AGE);
            return Ok(());
        };
        for (end, hit) in sweep.rays(&scan, &Pose2D::ORIGIN) {
            prop_assert!(hit && (end.x - 2.0).abs() < 0.01, "{end:?}");
        }
        // The same, seen from where the base is now.
        let here = arc(&twist, now.as_secs_f64());
        let laser = sweep.seen_from(&here, &Pose2D::ORIGIN);
        for (beam, range) in scan.ranges.iter().enumerate() {
            let point = end(&laser(beam), scan.angle(beam), f64::from(*range));
            let place = here.transform(&Pose2D::new(point.x, point.y, 0.0));
            prop_assert!((place.x - 2.0).abs() < 0.01, "{place:?}");
        }
    }
}
