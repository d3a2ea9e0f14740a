//! What the guard refuses and what it must not refuse; missing and invalid inputs leave it without a state.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_motion::{BaseDynamics, Surroundings};
use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use proptest::prelude::*;

use crate::Footprint;

/// A scan of 181 beams over the half plane ahead, each with the range of its angle.
fn scan(range: impl Fn(f64) -> f64) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -FRAC_PI_2 as f32,
        angle_increment: (PI / 180.0) as f32,
        range_min: 0.02,
        range_max: 8.0,
        ..LaserScan::default()
    };
    for beam in 0..181 {
        let range = range(scan.angle(beam)) as f32;
        scan.ranges.push(range).expect("few beams");
    }
    scan.state_last_angle();
    scan
}

/// A wall `distance` m ahead, across the whole half plane.
fn wall_ahead(distance: f64) -> LaserScan {
    scan(|angle| distance / angle.cos().max(1e-6))
}

fn odometry(pose: Pose2D, speed: f64) -> Odometry {
    Odometry::planar(Duration::ZERO, pose, Twist::planar(speed, 0.0))
}

/// A guard that has seen this scan from `pose`.
fn guard(scan: &LaserScan, pose: Pose2D, speed: f64) -> Bench<Footprint> {
    let mut bench = Bench::new();
    bench.unbind("dynamics");
    bench.awake().expect("it wakes");
    observe(&mut bench, scan, pose, speed);
    bench
}

fn observe(bench: &mut Bench<Footprint>, scan: &LaserScan, pose: Pose2D, speed: f64) {
    bench.import("laser", scan);
    bench.import("pose", &odometry(pose, speed));
    bench.iterate().expect("it iterates");
}

fn judge(bench: &Bench<Footprint>, speed: f64, turn: f64) -> Result<(), String> {
    let state = bench.exported::<Surroundings>("surroundings").expect("a state");
    Footprint::judge(&state, Duration::ZERO, &Twist::planar(speed, turn))
}

#[test]
fn a_speed_is_accepted_if_the_robot_can_stop_before_the_wall() {
    // 0.75 m from the hull. At 0.5 m/s, reached from 0.4 m/s, it needs 0.07 m of reaction and 0.42 m to stop.
    let bench = guard(&wall_ahead(1.0), Pose2D::ORIGIN, 0.4);
    assert_eq!(judge(&bench, 0.5, 0.0), Ok(()));
    let near = guard(&wall_ahead(0.55), Pose2D::ORIGIN, 0.4);
    let refused = judge(&near, 0.5, 0.0).expect_err("it cannot stop in 0.3 m");
    assert!(refused.contains("m ahead"), "{refused}");
    let standing = guard(&wall_ahead(0.55), Pose2D::ORIGIN, 0.0);
    assert_eq!(judge(&standing, 0.1, 0.0), Ok(()), "a slow approach");
    assert_eq!(judge(&standing, 0.0, 1.0), Ok(()), "a turn on the spot");
}

#[test]
fn a_scan_that_is_not_of_now_moves_with_the_base_and_one_of_another_clock_is_refused() {
    let mut bench = guard(&wall_ahead(1.0), Pose2D::ORIGIN, 0.5);
    bench.set_now(Duration::from_millis(400));
    bench.import("pose", &odometry(Pose2D::new(0.2, 0.0, 0.0), 0.5));
    bench.iterate().expect("it iterates");
    let state = bench.exported::<Surroundings>("surroundings").expect("a state");
    let ahead = state
        .points
        .iter()
        .filter(|point| point.y.abs() < 0.1 && point.x > 0.4);
    let nearest = ahead.map(|point| point.x).fold(f64::INFINITY, f64::min);
    assert!((nearest - 0.8).abs() < 0.03, "{nearest} m");
    bench.set_now(Duration::from_secs(60));
    bench.import("laser", &wall_ahead(1.0));
    bench.set_now(Duration::from_secs(1));
    bench.import("pose", &odometry(Pose2D::new(0.5, 0.0, 0.0), 0.5));
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<Surroundings>("surroundings"), None);
    let words = bench.schema().lacks().expect("words");
    assert!(
        words.starts_with("the scans are stamped 59.0 s ahead of the clock"),
        "{words}"
    );
}

#[test]
fn a_robot_backs_only_to_where_it_came_from() {
    // At 0.3 m/s it needs 0.2 m to stop.
    let mut bench = guard(&wall_ahead(6.0), Pose2D::ORIGIN, -0.3);
    assert!(judge(&bench, -0.3, 0.0).is_err(), "never seen");
    for step in 1..=20 {
        let x = f64::from(step) * 0.1;
        observe(&mut bench, &wall_ahead(6.0 - x), Pose2D::new(x, 0.0, 0.0), -0.3);
    }
    assert_eq!(judge(&bench, -0.3, 0.0), Ok(()));
}

#[test]
fn where_the_laser_measures_nothing_the_robot_drives_only_if_the_unknown_is_allowed() {
    // Nothing ahead is within the range of the laser; a wall is to the left.
    let hall = scan(|angle| if angle > 0.5 { 1.0 / angle.sin() } else { f64::NAN });
    let mut bench = guard(&hall, Pose2D::ORIGIN, 0.3);
    assert!(judge(&bench, 0.3, 0.0).is_err(), "never seen");
    bench.set("allow_unknown", true);
    observe(&mut bench, &hall, Pose2D::ORIGIN, 0.3);
    assert_eq!(judge(&bench, 0.3, 0.0), Ok(()));
    observe(&mut bench, &wall_ahead(0.4), Pose2D::ORIGIN, 0.3);
    observe(&mut bench, &hall, Pose2D::ORIGIN, 0.3);
    assert!(judge(&bench, 0.3, 0.0).is_err(), "what went out of sight");
}

#[test]
fn what_went_out_of_sight_still_counts() {
    let after_a_half_turn = |distance| {
        let mut bench = guard(&wall_ahead(distance), Pose2D::ORIGIN, 0.0);
        // Several scans, so that the cells are believed.
        for _ in 0..5 {
            observe(&mut bench, &wall_ahead(distance), Pose2D::ORIGIN, 0.0);
        }
        // A turn in one step would be a jump.
        for part in 1..8 {
            let turned = Pose2D::new(0.0, 0.0, f64::from(part) * PI / 8.0);
            bench.import("pose", &odometry(turned, 0.0));
            bench.iterate().expect("it iterates");
        }
        observe(&mut bench, &scan(|_| 6.0), Pose2D::new(0.0, 0.0, PI), -0.5);
        judge(&bench, -0.5, 0.0)
    };
    assert!(after_a_half_turn(0.6).is_err());
    assert_eq!(after_a_half_turn(3.0), Ok(()));
}

#[test]
fn what_the_driver_knows_of_the_base_counts_and_as_long_as_that_is_missing_nothing_is_accepted() {
    let mut bench = Bench::<Footprint>::new();
    bench.awake().expect("it wakes");
    observe(&mut bench, &wall_ahead(1.0), Pose2D::ORIGIN, 0.4);
    assert!(bench.exported::<Surroundings>("surroundings").is_none());
    let mut accepts = |deceleration, lag| {
        let dynamics = BaseDynamics {
            deceleration,
            lag,
            ..BaseDynamics::default()
        };
        bench.import("dynamics", &dynamics);
        observe(&mut bench, &wall_ahead(1.0), Pose2D::ORIGIN, 0.4);
        judge(&bench, 0.5, 0.0).is_ok()
    };
    // 0.75 m from the hull. It needs 0.07 m of reaction, 0.42 m to stop, and as much as it moves in its lag.
    assert!(accepts(0.0, 0.0), "nothing is known");
    assert!(accepts(0.0, 0.2) && !accepts(0.0, 0.8));
    assert!(accepts(2.0, 0.8) && !accepts(0.15, 0.0));
}

#[test]
fn an_odometry_without_a_stamp_counts_at_the_time_at_which_it_came() {
    let mut bench = guard(&wall_ahead(3.0), Pose2D::ORIGIN, 0.0);
    bench.set("lag", 0.2);
    for step in 1..50 {
        bench.set_now(Duration::from_millis(20 * step));
        observe(&mut bench, &wall_ahead(3.0), Pose2D::ORIGIN, 0.4);
    }
    let state = bench.exported::<Surroundings>("surroundings").expect("a state");
    assert!(
        (state.velocity.linear.x - 0.4).abs() < 0.01,
        "{:?}",
        state.velocity
    );
}

#[test]
fn dynamics_that_are_not_valid_leave_it_without_a_state_and_it_names_the_number_once() {
    let mut bench = Bench::<Footprint>::new();
    let dynamics = BaseDynamics {
        deceleration: -1.0,
        ..BaseDynamics::default()
    };
    bench.import("dynamics", &dynamics);
    bench.awake().expect("it wakes");
    for _ in 0..3 {
        observe(&mut bench, &wall_ahead(1.0), Pose2D::ORIGIN, 0.0);
        assert!(bench.exported::<Surroundings>("surroundings").is_none());
    }
    let said = bench
        .log()
        .iter()
        .filter(|(_, text)| text.contains("the deceleration of the base is -1"));
    assert_eq!(said.count(), 1);
}

#[test]
fn a_robot_that_touches_something_may_leave_it() {
    // The hull is 0.25 m from the laser.
    let bench = guard(&wall_ahead(0.24), Pose2D::ORIGIN, 0.0);
    assert!(judge(&bench, 0.1, 0.0).is_err());
    let mut bench = guard(&wall_ahead(6.0), Pose2D::new(-1.0, 0.0, 0.0), 0.0);
    for step in 0..=20 {
        let x = -1.0 + f64::from(step) * 0.05;
        observe(&mut bench, &wall_ahead(0.24 - x), Pose2D::new(x, 0.0, 0.0), 0.0);
    }
    assert!(judge(&bench, 0.1, 0.0).is_err());
    assert_eq!(judge(&bench, -0.1, 0.0), Ok(()));
}

#[test]
fn what_a_bumper_touches_or_a_cliff_below_the_robot_refuses_what_brings_it_nearer_and_lets_the_robot_back_away()
 {
    // As `scan/merge` shows them: on the outline of 0.25 m, and within it.
    for range in [0.25, 0.2] {
        let mut bench = guard(&wall_ahead(6.0), Pose2D::new(-1.0, 0.0, 0.0), 0.0);
        for step in 0..20 {
            observe(
                &mut bench,
                &wall_ahead(6.0),
                Pose2D::new(-1.0 + f64::from(step) * 0.05, 0.0, 0.0),
                0.0,
            );
        }
        let touched = scan(|angle| if angle.abs() < 0.3 { range } else { 6.0 });
        observe(&mut bench, &touched, Pose2D::ORIGIN, 0.0);
        assert!(
            judge(&bench, 0.05, 0.0).is_err() && judge(&bench, 0.2, 0.4).is_err(),
            "{range} m"
        );
        assert_eq!(judge(&bench, -0.1, 0.0), Ok(()), "{range} m");
        assert_eq!(judge(&bench, 0.0, 0.5), Ok(()), "it is round");
    }
}

#[test]
fn without_a_usable_scan_or_pose_it_has_no_state() {
    let state = |bench: &Bench<Footprint>| bench.exported::<Surroundings>("surroundings");
    let mut bench = guard(&wall_ahead(2.0), Pose2D::ORIGIN, 0.0);
    assert!(state(&bench).is_some());
    observe(&mut bench, &scan(|_| f64::NAN), Pose2D::ORIGIN, 0.0);
    assert!(state(&bench).is_none(), "NaN in each beam");
    observe(&mut bench, &LaserScan::default(), Pose2D::ORIGIN, 0.0);
    assert!(state(&bench).is_none(), "no beam");
    for pose in [
        Pose2D::new(f64::NAN, 0.0, 0.0),
        Pose2D::new(0.0, 0.0, f64::NAN),
        Pose2D::new(f64::INFINITY, 0.0, 0.0),
        Pose2D::new(1e300, 0.0, 0.0),
    ] {
        observe(&mut bench, &wall_ahead(2.0), pose, 0.0);
        assert!(state(&bench).is_none(), "{pose:?}");
    }
    observe(&mut bench, &wall_ahead(2.0), Pose2D::ORIGIN, 0.0);
    assert!(state(&bench).is_some());
    bench.set_now(Duration::from_secs(60));
    bench.iterate().expect("it iterates");
    assert!(state(&bench).is_none(), "the scan is old");
}

#[test]
fn a_pose_that_is_old_leaves_it_without_a_state() {
    let mut bench = guard(&wall_ahead(2.0), Pose2D::ORIGIN, 0.0);
    bench.set_now(Duration::from_secs(60));
    bench.import("laser", &wall_ahead(2.0));
    bench.iterate().expect("it iterates");
    assert!(bench.exported::<Surroundings>("surroundings").is_none());
}

#[test]
fn what_the_robot_touches_does_not_permit_to_touch_something_else() {
    let around = |behind: f64| {
        let mut scan = LaserScan {
            angle_min: -PI as f32,
            ..scan(|_| 1.0)
        };
        scan.ranges.resize(360).fill(1.0);
        // An edge of the floor below the front of the robot, and a wall behind it.
        scan.ranges.as_mut_slice()[180] = 0.2;
        scan.ranges.as_mut_slice()[0] = (0.25 + behind) as f32;
        scan.state_last_angle();
        judge(&guard(&scan, Pose2D::ORIGIN, 0.0), -0.1, 0.0)
    };
    assert!(around(0.03).is_err());
    assert_eq!(around(0.4), Ok(()), "it backs away from the edge");
}

#[test]
fn a_stop_is_accepted_whatever_is_near() {
    let bench = guard(&wall_ahead(0.3), Pose2D::ORIGIN, 0.5);
    assert!(judge(&bench, 0.1, 0.0).is_err(), "it cannot stop in time");
    assert_eq!(judge(&bench, 0.0, 0.0), Ok(()));
}

#[test]
fn a_command_is_slowed_down_to_what_lets_the_robot_stop() {
    let mut bench = Bench::<Footprint>::new();
    bench.unbind("dynamics");
    bench.set("slowdown", 0.8);
    bench.awake().expect("it wakes");
    observe(&mut bench, &wall_ahead(0.65), Pose2D::ORIGIN, 0.4);
    let state = bench.exported::<Surroundings>("surroundings").expect("a state");
    let limit = |speed, turn| Footprint::limit(&state, Duration::ZERO, &Twist::planar(speed, turn));
    let command = Twist::planar(1.0, 0.5);
    assert!(Footprint::judge(&state, Duration::ZERO, &command).is_err());
    let limited = limit(1.0, 0.5).expect("a part of it");
    assert!(limited.linear.x > 0.2 && limited.linear.x < 1.0, "{limited:?}");
    assert!(
        (limited.angular.z / limited.linear.x - 0.5).abs() < 1e-9,
        "the same curve"
    );
    assert_eq!(Footprint::judge(&state, Duration::ZERO, &limited), Ok(()));
    let blocked = guard(&wall_ahead(0.26), Pose2D::ORIGIN, 0.0);
    let state = blocked.exported::<Surroundings>("surroundings").expect("a state");
    assert_eq!(
        Footprint::limit(&state, Duration::ZERO, &command),
        None,
        "by default it refuses"
    );
}

#[test]
fn a_pose_that_jumps_forgets_what_was_known() {
    for way in [0.3, 1.6] {
        let mut bench = guard(&wall_ahead(0.6), Pose2D::ORIGIN, 0.0);
        observe(&mut bench, &wall_ahead(6.0), Pose2D::new(way, 0.0, 0.0), 0.0);
        assert_eq!(judge(&bench, 0.3, 0.0), Ok(()), "the wall is forgotten");
        observe(&mut bench, &wall_ahead(6.0), Pose2D::new(way, 0.0, 0.0), -0.3);
        assert!(judge(&bench, -0.3, 0.0).is_err(), "nothing is known behind it");
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let bench = guard(&wall_ahead(6.0), Pose2D::ORIGIN, f64::NAN);
    assert_eq!(
        bench.exported::<Surroundings>("surroundings"),
        None,
        "the velocity"
    );
    let bench = guard(&wall_ahead(6.0), Pose2D::ORIGIN, 0.0);
    assert!(judge(&bench, f64::INFINITY, 0.0).is_err(), "the command");
}

/// How far ahead the base comes that follows a command for some time and then brakes, in small steps of its
/// own.
fn greatest_ahead(present: f64, command: &Twist, hold: f64) -> f64 {
    const STEP: f64 = 1e-3;
    let (mut speed, mut turn, mut heading, mut x, mut time) = (present, 0.0_f64, 0.0_f64, 0.0_f64, 0.0);
    let mut ahead = 0.0_f64;
    while time < hold || speed != 0.0 || turn != 0.0 {
        let goal = if time < hold {
            (command.linear.x, command.angular.z)
        } else {
            (0.0, 0.0)
        };
        speed += (goal.0 - speed).clamp(-0.3 * STEP, 0.3 * STEP);
        turn += (goal.1 - turn).clamp(-STEP, STEP);
        heading += turn * STEP;
        x += speed * heading.cos() * STEP;
        ahead = ahead.max(x);
        time += STEP;
    }
    ahead
}

proptest! {
    #[test]
    fn no_command_that_is_accepted_drives_into_the_wall(
        distance in 0.3..3.0f64, present in 0.0..0.8f64, speed in -1.0..1.0f64, turn in -1.0..1.0f64, age in 0.0..0.1f64
    ) {
        let bench = guard(&wall_ahead(distance), Pose2D::ORIGIN, present);
        let state = bench.exported::<Surroundings>("surroundings").expect("a state");
        let command = Twist::planar(speed, turn);
        if Footprint::judge(&state, Duration::from_secs_f64(age), &command).is_ok() {
            let ahead = greatest_ahead(present, &command, 0.15 + age);
            prop_assert!(ahead + 0.25 < distance, "{ahead} m ahead of {distance} m");
        }
    }

    #[test]
    fn any_scan_and_any_pose_give_a_state_or_none_and_no_panic(
        ranges in prop::collection::vec(prop::num::f32::ANY, 0..40),
        x in prop::num::f64::ANY, y in prop::num::f64::ANY, theta in prop::num::f64::ANY,
        speed in prop::num::f64::ANY, turn in prop::num::f64::ANY,
    ) {
        let mut scan = scan(|_| 1.0);
        scan.ranges.clear();
        scan.ranges.extend_from_slice(&ranges).expect("few beams");
        let mut bench = guard(&scan, Pose2D::new(x, y, theta), 0.0);
        if let Some(state) = bench.exported::<Surroundings>("surroundings") {
            drop(Footprint::judge(&state, Duration::ZERO, &Twist::planar(speed, turn)));
        }
        drop(bench.draw());
    }
}
