//! The histogram with points known by hand, the command as a closed loop among walls, and input that must not
//! move the robot.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_schema::bench::Bench;
use jde_schema::types::{Footprint, Point2D, Seq};

use super::*;
use crate::bench::{Loop, Wall, room, scan};

const COSTS: Costs = Costs {
    target: 5.0,
    heading: 2.0,
    change: 2.0,
};

/// The directions that are free among points in the base's frame, for a robot of 0.35 m with its margin.
fn free(points: &[(f64, f64)], turn_radius: f64) -> Free {
    let points: Vec<Point2D> = points.iter().map(|&(x, y)| Point2D { x, y }).collect();
    Histogram::default().update(&around(&points, turn_radius))
}

fn around(points: &[Point2D], turn_radius: f64) -> Surroundings<'_> {
    Surroundings {
        points,
        heading: 0.0,
        enlargement: 0.35,
        near: 1.0,
        far: 1.2,
        turn_radius,
    }
}

fn is_free(free: &Free, degrees: f64) -> bool {
    let angle = degrees.to_radians();
    free.middles()
        .any(|middle| jde_schema::types::normalize_angle(middle - angle).abs() < 2.5_f64.to_radians())
}

#[test]
fn a_point_blocks_the_angle_that_the_enlarged_robot_needs() {
    // asin(0.35 / 0.7) is 30°.
    let free = free(&[(0.7, 0.0)], 0.0);
    for (degrees, expected) in [
        (0.0, false),
        (28.0, false),
        (-28.0, false),
        (37.0, true),
        (-37.0, true),
    ] {
        assert_eq!(is_free(&free, degrees), expected, "at {degrees}°");
    }
    assert_eq!(free.middles().count(), histogram::SECTORS - 14);
}

#[test]
fn a_blocked_sector_is_free_again_only_beyond_the_far_threshold() {
    let mut histogram = Histogram::default();
    let mut ahead = |x: f64| {
        let points = [Point2D { x: x + 0.35, y: 0.0 }];
        is_free(&histogram.update(&around(&points, 0.0)), 2.0)
    };
    assert_eq!(
        [1.1, 0.9, 1.1, 1.3, 1.1].map(&mut ahead),
        [true, false, false, true, true]
    );
}

#[test]
fn at_speed_a_point_beside_the_robot_masks_what_its_arc_cannot_reach() {
    let beside = [(0.3, 0.6)];
    assert!(is_free(&free(&beside, 0.0), 130.0));
    assert!(!is_free(&free(&beside, 0.6), 130.0));
    assert!(is_free(&free(&beside, 0.6), -130.0));
}

#[test]
fn without_points_the_direction_is_that_of_the_target() {
    let all = free(&[], 0.3);
    for bearing in [0.0, 1.234, -3.0] {
        assert_eq!(all.direction(bearing, 0.0, 0.0, 1.0, &COSTS), Some(bearing));
    }
}

#[test]
fn a_narrow_opening_is_entered_in_its_middle_and_a_wide_one_beside_its_edge() {
    let narrow = free(
        &[(0.8, 0.8), (0.8, -0.8), (-0.8, 0.8), (-0.8, -0.8), (-0.8, 0.0)],
        0.0,
    );
    let direction = narrow.direction(0.1, 0.0, 0.0, 1.4, &COSTS).expect("an opening");
    assert!(
        direction.sin().abs() < 2.5_f64.to_radians().sin() + 1e-9,
        "{direction}"
    );

    let wide = free(&[(0.7, 0.0)], 0.0);
    let direction = wide.direction(0.2, 0.0, 0.0, 1.0, &COSTS).expect("an opening");
    assert!(
        (direction - 35_f64.to_radians() - 0.5).abs() < 1e-9,
        "{direction}"
    );
}

#[test]
fn enclosed_on_all_sides_there_is_no_direction() {
    let ring: Vec<(f64, f64)> = (0..36).map(|i| (f64::from(i) * PI / 18.0).sin_cos()).collect();
    assert_eq!(free(&ring, 0.0).direction(0.0, 0.0, 0.0, 1.0, &COSTS), None);
}

/// A robot at the origin with a target ahead.
fn bench() -> Bench<Vfh> {
    let mut bench = Bench::new();
    bench.unbind("dynamics");
    bench.awake().expect("it awakes");
    bench.import("laser", &scan(&[], &Pose2D::ORIGIN));
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO),
    );
    bench.set("target", Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    bench
}

/// Asserts that it is not ready and stands still.
#[track_caller]
fn assert_still(bench: &mut Bench<Vfh>) {
    assert!(!bench.check().expect("the check succeeds").ready);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
}

#[test]
fn it_is_ready_with_scan_pose_and_target_and_drives() {
    let mut bench = bench();
    assert!(bench.check().expect("the check succeeds").ready);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.4, 0.0)));
}

#[test]
fn without_scan_pose_or_target_it_is_not_ready_and_stands_still() {
    for import in ["laser", "pose"] {
        let mut bench = bench();
        bench.retract(import);
        assert_still(&mut bench);
    }
    let mut bench = bench();
    bench.set("target", Target::NONE);
    assert_still(&mut bench);
}

#[test]
fn a_scan_that_measures_nothing_and_a_pose_that_is_no_number_do_not_move_it() {
    let mut blind = scan(&[], &Pose2D::ORIGIN);
    blind.ranges.as_mut_slice().fill(f32::NAN);
    for laser in [blind, LaserScan::default()] {
        let mut bench = bench();
        bench.import("laser", &laser);
        assert_still(&mut bench);
    }
    for pose in [
        Pose2D::new(f64::NAN, 0.0, 0.0),
        Pose2D::new(0.0, 0.0, f64::INFINITY),
    ] {
        let mut bench = bench();
        bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
        assert_still(&mut bench);
    }
}

#[test]
fn something_too_close_to_measure_blocks_the_way() {
    let mut bench = bench();
    let mut laser = scan(&[], &Pose2D::ORIGIN);
    laser.range_min = 0.3;
    laser.ranges.as_mut_slice()[85..96].fill(f32::NEG_INFINITY);
    bench.import("laser", &laser);
    bench.iterate().expect("the iteration succeeds");
    let command: Twist = bench.commanded("base").expect("a command");
    assert!(command.linear.x == 0.0 && command.angular.z != 0.0, "{command:?}");
}

#[test]
fn a_footprint_that_is_no_convex_area_is_a_problem_before_the_start() {
    let mut bench = Bench::<Vfh>::new();
    bench.set(
        "footprint",
        Footprint {
            radius: 0.0,
            points: Seq::new(),
        },
    );
    assert_eq!(bench.inspect().expect("it looks").len(), 1);
    assert!(bench.awake().is_err());
}

#[test]
fn it_reaches_a_target_behind_a_wall_with_a_door() {
    let mut walls = room((0.0, 0.0), (8.0, 4.0));
    walls.extend([[(4.0, 0.0), (4.0, 1.0)], [(4.0, 2.2), (4.0, 4.0)]] as [Wall; 2]);
    let mut world = Loop::<Vfh>::new(walls, Pose2D::new(1.0, 2.8, FRAC_PI_2));
    let target = Pose2D::new(7.0, 2.8, 0.0);
    world.bench.set("target", Target::at(target));
    world.drive_while(120, |_| true);
    assert!(
        world.travel.pose.distance_to(&target) < 0.15,
        "it ends at {:?}",
        world.travel.pose
    );
    assert!(world.clearance > 0.05, "{} m from a wall", world.clearance);
}

#[test]
fn it_never_touches_a_wall_wherever_the_target_is() {
    for step in 0..8 {
        let mut walls = room((-3.0, -2.0), (3.0, 2.0));
        walls.extend([
            [(1.0, -0.6), (1.0, 0.6)],
            [(-1.0, 0.5), (-1.8, 1.2)],
            [(-0.5, -1.0), (0.2, -1.3)],
        ]);
        let (sin, cos) = (f64::from(step) * PI / 4.0).sin_cos();
        let mut world = Loop::<Vfh>::new(walls, Pose2D::ORIGIN);
        // Some of the targets are in a wall or behind one.
        world
            .bench
            .set("target", Target::at(Pose2D::new(3.0 * cos, 3.0 * sin, 0.0)));
        world.drive_while(60, |_| true);
        assert!(
            world.clearance > 0.02,
            "{} m from a wall in case {step}",
            world.clearance
        );
    }
}

#[test]
fn the_panel_states_why_it_does_not_drive() {
    let mut bench = bench();
    bench.set("target", Target::NONE);
    bench.check().expect("the check succeeds");
    let panel = bench.draw().expect("the panel is drawn");
    assert_eq!(
        panel.texts(),
        ["No target, pose, usable scan or dynamics of the base"]
    );
}
