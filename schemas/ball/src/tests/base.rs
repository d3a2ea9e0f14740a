//! The schemas that drive the base: when they are READY, and what they command.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};
use crate::{Approach, Roam, Turn};

/// Returns whether the schema is READY for each of these balls, one after another.
fn ready<S: Schema>(balls: &[Ball]) -> Vec<bool> {
    let mut bench = Bench::<S>::new();
    let check = |ball: &Ball| {
        bench.import("ball", ball);
        bench.check().expect("no fault").ready
    };
    balls.iter().map(check).collect()
}

fn commanded<S: Schema>(ball: Ball) -> (f64, f64) {
    let mut bench = Bench::<S>::new();
    bench.import("ball", &ball);
    bench.iterate().expect("no fault");
    let twist: Twist = bench.commanded("base").expect("a command");
    (twist.linear.x, twist.angular.z)
}

#[test]
fn no_schema_is_ready_without_a_ball_or_with_an_old_one() {
    fn check_readiness<S: Schema>(ball: Ball) {
        let mut bench = Bench::<S>::new();
        assert!(!bench.check().expect("no fault").ready);
        bench.import("ball", &ball);
        assert!(bench.check().expect("no fault").ready);
        bench.set_now(seconds(1.1));
        assert!(!bench.check().expect("no fault").ready);
        bench.import("ball", &ball);
        assert!(bench.check().expect("no fault").ready);
        bench.retract("ball");
        assert!(!bench.check().expect("no fault").ready);
    }
    check_readiness::<Turn>(seen(1.0, 2.0));
    check_readiness::<Approach>(seen(0.0, 2.0));
}

#[test]
fn turn_starts_at_35_degrees_and_ends_at_10() {
    let at = |degrees: f64| seen(degrees.to_radians(), 2.0);
    for side in [1.0, -1.0] {
        let balls = [34.0, 36.0, 20.0, 11.0, 9.0, 20.0].map(|degrees| at(side * degrees));
        assert_eq!(ready::<Turn>(&balls), [false, true, true, true, false, false]);
    }
}

#[test]
fn turn_turns_once_around_for_a_ball_that_the_head_has_not_found() {
    // A full turn at 0.5 rad/s takes 12.6 s.
    let balls = [4.9, 5.1, 17.5, 17.6].map(|time| unseen(0.1, 2.0, time));
    assert_eq!(ready::<Turn>(&balls), [false, true, true, false]);
    let briefly_unseen = [unseen(1.0, 2.0, 0.2), unseen(1.0, 2.0, 0.4)];
    assert_eq!(
        ready::<Turn>(&briefly_unseen),
        [true, false],
        "a ball to the side is lost after the same time"
    );
}

#[test]
fn turn_turns_toward_the_ball_on_the_spot() {
    assert_eq!(commanded::<Turn>(seen(0.8, 2.0)), (0.0, 0.6));
    assert_eq!(commanded::<Turn>(seen(-0.8, 2.0)), (0.0, -0.6));
    assert_eq!(commanded::<Turn>(unseen(-0.8, 2.0, 9.0)), (0.0, -0.5));
}

#[test]
fn approach_starts_at_90_cm_and_ends_at_80() {
    let balls = [0.85, 0.95, 0.85, 0.79, 0.85].map(|distance| seen(0.0, distance));
    assert_eq!(ready::<Approach>(&balls), [false, true, true, false, false]);
    let briefly_unseen = [0.0, 0.2, 0.4].map(|time| unseen(0.0, 2.0, time));
    assert_eq!(
        ready::<Approach>(&briefly_unseen),
        [true, true, false],
        "approach is not ready for a lost ball"
    );
}

#[test]
fn the_distance_is_measured_along_the_floor() {
    let below = Ball {
        elevation: -60_f64.to_radians(),
        ..seen(0.0, 1.7)
    };
    assert_eq!(ready::<Approach>(&[below]), [false], "0.85 m along the floor");
}

#[test]
fn approach_slows_down_near_the_ball_and_steers_to_it() {
    let (far, _) = commanded::<Approach>(seen(0.0, 3.0));
    let (close, _) = commanded::<Approach>(seen(0.0, 1.2));
    let (closest, _) = commanded::<Approach>(seen(0.0, 0.81));
    assert_eq!((far, closest), (0.35, 0.06));
    near(close, 0.2, 1e-9);
    let (aside, turn) = commanded::<Approach>(seen(0.3, 3.0));
    near(aside, 0.35 * 0.3_f64.cos(), 1e-9);
    near(turn, 0.3, 1e-9);
    assert_eq!(
        commanded::<Approach>(seen(-0.7, 3.0)).1,
        -0.6,
        "the highest turn rate"
    );
    near(commanded::<Approach>(seen(2.0, 3.0)).0, 0.0, 1e-9);
}

/// A scan with returns at these points (ahead, to the left), m.
fn scan(points: &[(f64, f64)]) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: 1_f32.to_radians(),
        range_min: 0.02,
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(181).fill(f32::INFINITY);
    for (x, y) in points {
        let beam = y.atan2(*x).to_degrees().round() + 90.0;
        scan.ranges.as_mut_slice()[beam as usize] = x.hypot(*y) as f32;
    }
    scan
}

#[test]
fn roam_is_ready_after_the_head_has_searched_and_only_with_a_scan() {
    let mut bench = Bench::<Roam>::new();
    bench.import("ball", &unseen(0.0, 2.0, 5.1));
    assert!(
        !bench.check().expect("no fault").ready,
        "roam is ready without a scan"
    );
    bench.import("laser", &scan(&[]));
    assert!(bench.check().expect("no fault").ready);
    for ball in [unseen(0.0, 2.0, 4.9), seen(0.0, 2.0)] {
        bench.import("ball", &ball);
        assert!(!bench.check().expect("no fault").ready);
    }
    bench.import("ball", &unseen(0.0, 2.0, 5.1));
    bench.set_now(seconds(1.1));
    assert!(!bench.check().expect("no fault").ready, "an old picture");
}

#[test]
fn roam_drives_while_there_is_room_and_otherwise_turns_to_the_wider_side() {
    let mut bench = Bench::<Roam>::new();
    let mut command = |points: &[(f64, f64)]| {
        bench.import("laser", &scan(points));
        bench.iterate().expect("no fault");
        let twist: Twist = bench.commanded("base").expect("a command");
        (twist.linear.x, twist.angular.z)
    };
    let (drive, left, right) = ((0.25, 0.0), (0.0, 0.5), (0.0, -0.5));
    assert_eq!(command(&[]), drive);
    assert_eq!(
        command(&[(1.1, 0.0), (0.5, 0.5)]),
        drive,
        "the points are beside the path"
    );
    assert_eq!(command(&[(0.9, 0.0), (0.5, 0.5)]), right);
    assert_eq!(command(&[(1.4, 0.0)]), right, "not enough room to drive on");
    assert_eq!(command(&[(0.9, 0.0), (0.5, -0.5)]), right, "the side is kept");
    assert_eq!(command(&[(1.6, 0.0)]), drive);
    assert_eq!(
        command(&[(0.9, 0.0), (0.5, -0.5)]),
        left,
        "the side is chosen again"
    );
}
