//! The schemas that drive the base: when they are READY, and what they command.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::ball::Ball;
use crate::tests::{assert_near, seconds, seen, unseen};
use crate::{Approach, Roam, Turn};

/// Whether the schema is READY for each of these balls, one after another.
fn ready<S: Schema>(balls: &[Ball]) -> Vec<bool> {
    let mut bench = Bench::<S>::new();
    let check = |ball: &Ball| {
        bench.import("ball", ball);
        bench.check().expect("the check succeeds").ready
    };
    balls.iter().map(check).collect()
}

fn commanded<S: Schema>(ball: Ball) -> (f64, f64) {
    let mut bench = Bench::<S>::new();
    bench.import("ball", &ball);
    bench.iterate().expect("the iteration succeeds");
    let twist: Twist = bench.commanded("base").expect("a command is sent");
    (twist.linear.x, twist.angular.z)
}

#[test]
fn without_a_recent_ball_no_schema_is_ready() {
    fn assert_needs_recent_ball<S: Schema>(ball: Ball) {
        let mut bench = Bench::<S>::new();
        assert!(!bench.check().expect("the check succeeds").ready);
        bench.import("ball", &ball);
        assert!(bench.check().expect("the check succeeds").ready);
        bench.set_now(seconds(1.1));
        assert!(!bench.check().expect("the check succeeds").ready);
        bench.import("ball", &ball);
        assert!(bench.check().expect("the check succeeds").ready);
        bench.retract("ball");
        assert!(!bench.check().expect("the check succeeds").ready);
    }
    assert_needs_recent_ball::<Turn>(seen(1.0, 2.0));
    assert_needs_recent_ball::<Approach>(seen(0.0, 2.0));
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
fn turn_makes_one_full_turn_for_a_ball_that_the_head_did_not_find() {
    // A full turn at 0.5 rad/s takes 12.6 s.
    let balls = [4.9, 5.1, 17.5, 17.6].map(|time| unseen(0.1, 2.0, time));
    assert_eq!(ready::<Turn>(&balls), [false, true, true, false]);
    let shortly_lost = [unseen(1.0, 2.0, 0.2), unseen(1.0, 2.0, 0.4)];
    assert_eq!(
        ready::<Turn>(&shortly_lost),
        [true, false],
        "a ball to the side is also lost"
    );
}

#[test]
fn turn_commands_a_rotation_toward_the_ball_on_the_spot() {
    assert_eq!(commanded::<Turn>(seen(0.8, 2.0)), (0.0, 0.6));
    assert_eq!(commanded::<Turn>(seen(-0.8, 2.0)), (0.0, -0.6));
    assert_eq!(commanded::<Turn>(unseen(-0.8, 2.0, 9.0)), (0.0, -0.5));
}

#[test]
fn approach_starts_at_90_cm_and_stops_at_80_cm() {
    let balls = [0.85, 0.95, 0.85, 0.79, 0.85].map(|distance| seen(0.0, distance));
    assert_eq!(ready::<Approach>(&balls), [false, true, true, false, false]);
    let shortly_lost = [0.0, 0.2, 0.4].map(|time| unseen(0.0, 2.0, time));
    assert_eq!(
        ready::<Approach>(&shortly_lost),
        [true, true, false],
        "a lost ball is not approached"
    );
}

#[test]
fn approach_uses_the_distance_along_the_floor() {
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
    assert_near(close, 0.2, 1e-9);
    let (speed, turn) = commanded::<Approach>(seen(0.3, 3.0));
    assert_near(speed, 0.35 * 0.3_f64.cos(), 1e-9);
    assert_near(turn, 0.3, 1e-9);
    assert_eq!(
        commanded::<Approach>(seen(-0.7, 3.0)).1,
        -0.6,
        "the turn rate is limited"
    );
    assert_near(commanded::<Approach>(seen(2.0, 3.0)).0, 0.0, 1e-9);
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
    scan.state_last_angle();
    scan
}

#[test]
fn roam_is_ready_when_the_head_did_not_find_the_ball_and_there_is_a_recent_scan() {
    let mut bench = Bench::<Roam>::new();
    bench.import("ball", &unseen(0.0, 2.0, 5.1));
    assert!(
        !bench.check().expect("the check succeeds").ready,
        "it needs a laser"
    );
    bench.import("laser", &scan(&[]));
    assert!(bench.check().expect("the check succeeds").ready);
    for ball in [unseen(0.0, 2.0, 4.9), seen(0.0, 2.0)] {
        bench.import("ball", &ball);
        assert!(!bench.check().expect("the check succeeds").ready);
    }
    bench.import("ball", &unseen(0.0, 2.0, 5.1));
    bench.set_now(seconds(1.1));
    assert!(
        !bench.check().expect("the check succeeds").ready,
        "the position is out of date"
    );
}

#[test]
fn roam_drives_while_there_is_room_and_otherwise_turns_to_the_wider_side() {
    let mut bench = Bench::<Roam>::new();
    let mut steps = |points: &[(f64, f64)]| {
        bench.import("laser", &scan(points));
        bench.iterate().expect("the iteration succeeds");
        let twist: Twist = bench.commanded("base").expect("a command is sent");
        (twist.linear.x, twist.angular.z)
    };
    let (drive, left, right) = ((0.25, 0.0), (0.0, 0.5), (0.0, -0.5));
    assert_eq!(steps(&[]), drive);
    assert_eq!(
        steps(&[(1.1, 0.0), (0.5, 0.5)]),
        drive,
        "the obstacle is beside the path"
    );
    assert_eq!(steps(&[(0.9, 0.0), (0.5, 0.5)]), right);
    assert_eq!(steps(&[(1.4, 0.0)]), right, "the margin is not reached");
    assert_eq!(steps(&[(0.9, 0.0), (0.5, -0.5)]), right, "the side is kept");
    assert_eq!(steps(&[(1.6, 0.0)]), drive);
    assert_eq!(
        steps(&[(0.9, 0.0), (0.5, -0.5)]),
        left,
        "the side is chosen again"
    );
}
