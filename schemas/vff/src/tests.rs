//! The field compared with numbers computed by hand, the bands and speeds of 2007, and when an obstacle
//! counts.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_schema::bench::Bench;
use jde_schema::panel::{Color, Shape};

use super::*;

const TURN: f64 = 50.0 / 180.0 * PI;
const VEER: f64 = 20.0 / 180.0 * PI;

/// The field of 2007.
const FIELD: FieldWeights = FieldWeights {
    attraction: 0.7,
    repulsion: 0.3,
    cap: 1.0,
    reach: 1.0,
};

/// A scan over half a turn with `density` beams per degree, and returns at some whole degrees.
fn scan(density: usize, returns: &[(i32, f32)]) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -(FRAC_PI_2 as f32),
        angle_increment: 1_f32.to_radians() / density as f32,
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(181 * density).fill(f32::INFINITY);
    for (degrees, range) in returns {
        let first = usize::try_from(degrees + 90).expect("ahead") * density;
        scan.ranges.as_mut_slice()[first..first + density].fill(*range);
    }
    scan.state_last_angle();
    scan
}

#[track_caller]
fn assert_near(value: (f64, f64), expected: (f64, f64), tolerance: f64) {
    let difference = (value.0 - expected.0).hypot(value.1 - expected.1);
    assert!(
        difference <= tolerance,
        "{value:?} is not {expected:?} ± {tolerance}"
    );
}

/// The sum of forces for a target at (x, y) in the robot's frame and returns one degree wide.
fn force(target: (f64, f64), returns: &[(i32, f32)]) -> (f64, f64) {
    FIELD
        .forces(&Pose2D::new(target.0, target.1, 0.0), &scan(1, returns))
        .sum()
}

#[test]
fn the_attraction_is_0_7_of_the_distance_up_to_1_m() {
    assert_near(force((0.5, 0.0), &[]), (0.35, 0.0), 1e-9);
    assert_near(force((1.0, 0.0), &[]), (0.7, 0.0), 1e-9);
    assert_near(force((20.0, 0.0), &[]), (0.7, 0.0), 1e-9);
    assert_near(force((-3.0, 4.0), &[]), (-0.42, 0.56), 1e-9);
    assert_near(force((0.0, 0.0), &[]), (0.0, 0.0), 0.0);
}

#[test]
fn the_repulsion_of_a_return_follows_the_table_of_2007() {
    // 0.3 times the push of the table, divided by 20.
    let table = [
        (0.1, 2.0),
        (0.249, 2.0),
        (0.25, 1.5),
        (0.499, 1.5),
        (0.5, 1.2),
        (0.749, 1.2),
        (0.75, 1.0),
        (0.999, 1.0),
        (1.0, 0.5),
        (1.999, 0.5),
        (2.0, 0.2),
        (2.999, 0.2),
        (3.0, 0.0),
        (7.9, 0.0),
    ];
    for (range, push) in table {
        assert_near(force((0.0, 0.0), &[(0, range)]), (-0.3 * push / 20.0, 0.0), 1e-6);
    }
}

#[test]
fn pushes_add_up_as_vectors() {
    // By the table, the push is 1.0 at 90 degrees to the left and 0.5 at 30 degrees to the right.
    let push = 0.3 / 20.0;
    let (x, y) = (0.5 * 30_f64.to_radians().cos(), -0.5 * 30_f64.to_radians().sin());
    assert_near(
        force((0.0, 0.0), &[(90, 0.8), (-30, 1.5)]),
        (-push * x, -push * (1.0 + y)),
        1e-6,
    );
    assert_near(force((2.0, 0.0), &[(0, 0.4)]), (0.7 - push * 1.5, 0.0), 1e-6);
}

#[test]
fn the_repulsion_does_not_depend_on_the_number_of_beams() {
    let wall: Vec<(i32, f32)> = (20..70).map(|degrees| (degrees, 0.6)).collect();
    let target = Pose2D::new(3.0, 1.0, 0.0);
    let coarse = FIELD.forces(&target, &scan(1, &wall)).sum();
    let fine = FIELD.forces(&target, &scan(4, &wall)).sum();
    // The additional beams are up to 0.75 degrees farther to the left.
    assert_near(fine, coarse, 0.01);
    assert!(coarse.1 < -0.1, "the wall must repel: {coarse:?}");
}

#[test]
fn a_scanner_mounted_upside_down_gives_the_same_repulsion() {
    let upright = scan(1, &[(40, 0.6), (-10, 1.2)]);
    let mut turned = upright;
    turned.ranges.as_mut_slice().reverse();
    turned.angle_min = -upright.angle_min;
    turned.angle_increment = -upright.angle_increment;
    turned.state_last_angle();
    let target = Pose2D::new(3.0, 1.0, 0.0);
    assert_near(
        FIELD.forces(&target, &turned).sum(),
        FIELD.forces(&target, &upright).sum(),
        1e-5,
    );
}

#[test]
fn reach_scales_the_distances_of_the_table() {
    let field = FieldWeights { reach: 0.4, ..FIELD };
    let push = |range| field.forces(&Pose2D::ORIGIN, &scan(1, &[(0, range)])).sum().0;
    assert!((push(0.39) + 0.3 * 1.0 / 20.0).abs() < 1e-6);
    assert!((push(1.19) + 0.3 * 0.2 / 20.0).abs() < 1e-6);
    assert_eq!(push(1.21), 0.0);
}

/// A robot at the origin that faces along x, with a target this many degrees to the left and these returns.
fn bench(degrees: f64, returns: &[(i32, f32)]) -> Bench<Vff> {
    let mut bench = Bench::new();
    bench.import("laser", &scan(1, returns));
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO),
    );
    let (sin, cos) = degrees.to_radians().sin_cos();
    bench.set("target", Target::at(Pose2D::new(4.0 * cos, 4.0 * sin, 0.0)));
    bench
}

/// Asserts the command when the force points this many degrees to the left.
#[track_caller]
fn assert_command(degrees: f64, linear: f64, angular: f64) {
    let mut bench = bench(degrees, &[]);
    bench.iterate().expect("the iteration succeeds");
    let twist: Twist = bench.commanded("base").expect("a command is sent");
    let (along, turn) = (twist.linear.x, twist.angular.z);
    assert!(
        (along - linear).abs() < 1e-9 && (turn - angular).abs() < 1e-9,
        "at {degrees}°: {along} m/s, {turn} rad/s"
    );
}

#[test]
fn below_10_degrees_it_drives_straight() {
    for degrees in [0.0, 9.9, -9.9] {
        assert_command(degrees, 0.2, 0.0);
    }
}

#[test]
fn from_10_to_40_degrees_it_turns_toward_the_force_while_driving() {
    for degrees in [10.1, 39.9] {
        assert_command(degrees, 0.1, VEER);
        assert_command(-degrees, 0.1, -VEER);
    }
}

#[test]
fn from_40_degrees_it_turns_toward_the_force_on_the_spot() {
    for degrees in [40.1, 90.0, 179.0] {
        assert_command(degrees, 0.0, TURN);
        assert_command(-degrees, 0.0, -TURN);
    }
}

#[test]
fn the_urgency_is_the_absolute_heading_error() {
    for degrees in [0.0, 30.0, -30.0, 170.0, -170.0] {
        let urgency = bench(degrees, &[]).check().expect("the check succeeds").urgency;
        assert!(
            (urgency - f64::abs(degrees).to_radians()).abs() < 1e-6,
            "{urgency} rad at {degrees}°"
        );
    }
}

#[test]
fn in_a_symmetric_scene_it_does_not_turn() {
    let mut bench = bench(0.0, &[(-40, 0.9), (40, 0.9), (-60, 0.7), (60, 0.7), (0, 2.0)]);
    assert!(bench.check().expect("the check succeeds").ready);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.2, 0.0)));
}

#[test]
fn it_turns_away_from_a_wall_on_one_side() {
    let left: Vec<(i32, f32)> = (10..60).map(|degrees| (degrees, 0.6)).collect();
    let right: Vec<(i32, f32)> = left.iter().map(|(degrees, range)| (-degrees, *range)).collect();
    for (wall, sign) in [(left, -1.0), (right, 1.0)] {
        let mut bench = bench(0.0, &wall);
        bench.iterate().expect("the iteration succeeds");
        let twist: Twist = bench.commanded("base").expect("a command is sent");
        assert!(twist.angular.z * sign > 0.0, "{} rad/s", twist.angular.z);
    }
}

#[test]
fn it_is_ready_while_an_obstacle_stands_in_its_area() {
    // At 45 degrees, 1.41 m away is 1 m to the side.
    for (point, ready) in [
        ((0, 2.99), true),
        ((0, 3.01), false),
        ((45, 1.40), true),
        ((45, 1.43), false),
        ((-45, 1.40), true),
        ((-45, 1.43), false),
    ] {
        let mut bench = bench(0.0, &[point]);
        assert_eq!(
            bench.check().expect("the check succeeds").ready,
            ready,
            "an obstacle at {point:?}"
        );
    }
}

#[test]
fn with_a_margin_the_area_is_larger_while_an_obstacle_is_in_it() {
    let mut bench = bench(0.0, &[]);
    bench.set("margin", 0.2);
    for (range, ready) in [
        (3.1, false),
        (2.9, true),
        (3.1, true),
        (3.19, true),
        (3.21, false),
        (3.1, false),
    ] {
        bench.import("laser", &scan(1, &[(0, range)]));
        assert_eq!(
            bench.check().expect("the check succeeds").ready,
            ready,
            "at {range} m"
        );
    }
    bench.import("laser", &scan(1, &[(45, 1.40)]));
    assert!(bench.check().expect("the check succeeds").ready);
    bench.import("laser", &scan(1, &[(45, 1.60)]));
    assert!(
        bench.check().expect("the check succeeds").ready,
        "the area grows to the sides too"
    );
}

#[test]
fn without_a_target_a_scan_or_a_pose_it_is_not_ready_and_commands_zero() {
    let mut without_target = bench(0.0, &[(0, 1.0)]);
    without_target.set("target", Target::NONE);
    let mut without_pose = Bench::<Vff>::new();
    without_pose.import("laser", &scan(1, &[(0, 1.0)]));
    without_pose.set("target", Target::at(Pose2D::ORIGIN));
    let mut without_scan = Bench::<Vff>::new();
    without_scan.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO),
    );
    without_scan.set("target", Target::at(Pose2D::ORIGIN));
    for mut bench in [without_target, without_pose, without_scan] {
        assert!(!bench.check().expect("the check succeeds").ready);
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
    }
}

#[test]
fn the_target_is_converted_to_the_frame_of_the_robot() {
    let mut bench = bench(0.0, &[]);
    let pose = Pose2D::new(4.0, -3.0, FRAC_PI_2);
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
    assert!(
        bench.check().expect("the check succeeds").urgency < 1e-6,
        "the target at 4, 0 lies straight ahead"
    );
}

#[test]
fn the_panel_shows_the_forces() {
    let mut bench = bench(0.0, &[(90, 0.4), (89, 0.4)]);
    bench.iterate().expect("the iteration succeeds");
    let panel = bench.draw().expect("the panel is drawn");
    assert!((panel.value("attraction") - 0.7).abs() < 1e-9);
    let push = 2.0 * 0.3 * 1.5 / 20.0 * 0.5_f64.to_radians().cos();
    assert!((panel.value("repulsion") - push).abs() < 1e-6);
    let tips: Vec<_> = panel
        .shapes("area")
        .iter()
        .filter_map(|shape| match shape {
            Shape::Arrow { from, to, stroke } => {
                assert_eq!(*from, [0.0, 0.0]);
                Some((*to, stroke.color))
            }
            _ => None,
        })
        .collect();
    let [(pull, _), (push_tip, _), (sum, color)] = tips[..] else {
        panic!("three forces: {tips:?}")
    };
    assert!(push_tip[1] < 0.0, "away from the wall on the left");
    assert_near(
        (sum[0], sum[1]),
        (pull[0] + push_tip[0], pull[1] + push_tip[1]),
        1e-9,
    );
    assert_eq!(color, Color::Ink(Ink::Accent));
    let error = sum[1].atan2(sum[0]);
    assert!((panel.value("heading error") - error).abs() < 1e-9);
}

#[test]
fn the_panel_shows_the_area_of_the_last_check() {
    let mut bench = bench(0.0, &[]);
    bench.set("margin", 0.2);
    for (range, expected) in [
        (3.1, ([3.0, 1.0], Ink::Good)),
        (2.9, ([3.0, 1.0], Ink::Warn)),
        (3.1, ([3.2, 1.2], Ink::Warn)),
        (3.3, ([3.2, 1.2], Ink::Good)),
        (3.1, ([3.0, 1.0], Ink::Good)),
    ] {
        bench.import("laser", &scan(1, &[(0, range)]));
        bench.check().expect("the check succeeds");
        let panel = bench.draw().expect("the panel is drawn");
        let area = panel.shapes("area").iter().find_map(|shape| match shape {
            Shape::Line {
                points,
                closed: true,
                stroke,
            } => Some((points[2], stroke.color)),
            _ => None,
        });
        let (corner, ink) = expected;
        assert_eq!(area, Some((corner, Color::Ink(ink))), "at {range} m");
    }
}

#[test]
fn another_build_restores_whether_an_obstacle_was_in_the_area() {
    let mut old = bench(0.0, &[]);
    old.import("laser", &scan(1, &[(0, 2.9)]));
    assert!(old.check().expect("the check succeeds").ready);
    let saved = old.save().expect("saving succeeds");
    for (restored, ready) in [(false, false), (true, true)] {
        let mut new = bench(0.0, &[]);
        new.set("margin", 0.2);
        if restored {
            new.restore(&saved).expect("restoring succeeds");
        }
        new.import("laser", &scan(1, &[(0, 3.1)]));
        assert_eq!(new.check().expect("the check succeeds").ready, ready);
    }
}
