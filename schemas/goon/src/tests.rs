//! The bands and speeds of 2007, and when the path counts as free.

use jde_schema::bench::Bench;
use jde_schema::panel::{Color, Shape};

use super::*;

const TURN: f64 = 50.0 / 180.0 * core::f64::consts::PI;

/// A scan with one return at a point (ahead, to the left) in metres, or with none.
fn scan(point: Option<(f64, f64)>) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: 1_f32.to_radians() / 4.0,
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(721).fill(f32::INFINITY);
    if let Some((x, y)) = point {
        let beam = (y.atan2(x) - f64::from(scan.angle_min)) / f64::from(scan.angle_increment);
        scan.ranges.as_mut_slice()[beam.round() as usize] = x.hypot(y) as f32;
    }
    scan.state_last_angle();
    scan
}

fn set_pose(bench: &mut Bench<Goon>, pose: Pose2D) {
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
}

/// A robot at (1, 1) that faces along x, with a free path and a target at (5, 1).
fn free_path() -> Bench<Goon> {
    let mut bench = Bench::new();
    bench.import("laser", &scan(None));
    set_pose(&mut bench, Pose2D::new(1.0, 1.0, 0.0));
    bench.set("target", Target::at(Pose2D::new(5.0, 1.0, 0.0)));
    bench
}

fn ready(bench: &mut Bench<Goon>) -> bool {
    bench.check().expect("the check succeeds").ready
}

/// Asserts the command when the target is this many degrees to the left.
#[track_caller]
fn assert_command(degrees: f64, linear: f64, angular: f64) {
    let mut bench = free_path();
    let (sin, cos) = degrees.to_radians().sin_cos();
    bench.set(
        "target",
        Target::at(Pose2D::new(1.0 + 4.0 * cos, 1.0 + 4.0 * sin, 0.0)),
    );
    bench.iterate().expect("the iteration succeeds");
    let twist: Twist = bench.commanded("base").expect("a command is sent");
    let (along, turn) = (twist.linear.x, twist.angular.z);
    assert!(
        (along - linear).abs() < 1e-9 && (turn - angular).abs() < 1e-9,
        "at {degrees}°: {along} m/s, {turn} rad/s"
    );
}

#[test]
fn below_10_degrees_it_drives_straight_and_fast() {
    for degrees in [0.0, 9.9, -9.9] {
        assert_command(degrees, 0.4, 0.0);
    }
}

#[test]
fn from_10_to_40_degrees_it_turns_toward_the_target_while_driving() {
    for degrees in [10.1, 39.9] {
        assert_command(degrees, 0.2, TURN);
        assert_command(-degrees, 0.2, -TURN);
    }
}

#[test]
fn from_40_degrees_it_turns_toward_the_target_on_the_spot() {
    for degrees in [40.1, 90.0, 179.0] {
        assert_command(degrees, 0.0, TURN);
        assert_command(-degrees, 0.0, -TURN);
    }
}

#[test]
fn the_heading_error_is_the_smaller_angle() {
    let mut bench = free_path();
    set_pose(&mut bench, Pose2D::new(5.0, 5.0, 3.0));
    bench.set("target", Target::at(Pose2D::new(1.0, 4.9, 0.0)));
    bench.iterate().expect("the iteration succeeds");
    // The target is at -178.6 degrees, and the robot faces 171.9 degrees.
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.4, 0.0)));
}

#[test]
fn it_is_ready_while_the_area_ahead_is_free() {
    let mut bench = free_path();
    assert!(ready(&mut bench), "there are no returns");
    for (point, expected) in [
        ((2.99, 0.0), false),
        ((3.01, 0.0), true),
        ((2.0, 0.99), false),
        ((2.0, -0.99), false),
        ((2.0, 1.01), true),
        ((2.0, -1.01), true),
    ] {
        let mut bench = free_path();
        bench.import("laser", &scan(Some(point)));
        assert_eq!(ready(&mut bench), expected, "an obstacle at {point:?}");
    }
}

#[test]
fn without_a_target_a_scan_or_a_pose_it_is_not_ready() {
    let mut bench = free_path();
    bench.set("target", Target::NONE);
    assert!(!ready(&mut bench));

    let mut bench = Bench::<Goon>::new();
    bench.set("target", Target::at(Pose2D::ORIGIN));
    bench.import("laser", &scan(None));
    assert!(!ready(&mut bench), "no pose");

    let mut bench = Bench::<Goon>::new();
    bench.set("target", Target::at(Pose2D::ORIGIN));
    set_pose(&mut bench, Pose2D::ORIGIN);
    assert!(!ready(&mut bench), "no scan");
}

#[test]
fn without_a_measurement_in_the_area_ahead_it_is_not_ready() {
    let mut blind_ahead = scan(None);
    blind_ahead.ranges.as_mut_slice()[200..520].fill(0.0);
    let mut beyond = scan(None);
    beyond.ranges.as_mut_slice().fill(65.0);
    for none in [blind_ahead, beyond, LaserScan::default()] {
        let mut bench = free_path();
        bench.import("laser", &none);
        assert!(!ready(&mut bench), "{:?}", none.measured());
    }
    let mut nowhere = Odometry::default();
    nowhere.pose.pose.orientation.w = 0.0;
    let mut bench = free_path();
    bench.import("pose", &nowhere);
    assert!(!ready(&mut bench), "no orientation");
}

#[test]
fn a_target_removed_while_it_wins_stops_it() {
    let mut bench = free_path();
    bench.set("target", Target::NONE);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
}

#[test]
fn it_commands_nothing_without_a_pose() {
    let mut bench = free_path();
    bench.retract("pose");
    let failure = bench.iterate().expect_err("the pose has no value");
    assert!(failure.lacks_value(), "{failure}");
    assert_eq!(bench.commanded::<Twist>("base"), None);
}

#[test]
fn speeds_and_bands_are_modulated() {
    let mut bench = free_path();
    for (name, value) in [
        ("fast", 0.9),
        ("slow", 0.3),
        ("turn", 0.5),
        ("straight", 0.2),
        ("veer", 1.0),
    ] {
        bench.set(name, value);
    }
    for (heading, twist) in [(0.19, (0.9, 0.0)), (0.21, (0.3, -0.5)), (1.01, (0.0, -0.5))] {
        set_pose(&mut bench, Pose2D::new(1.0, 1.0, heading));
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(
            bench.commanded("base"),
            Some(Twist::planar(twist.0, twist.1)),
            "heading {heading}"
        );
    }
}

#[test]
fn the_panel_shows_the_reaction_to_the_heading_error() {
    for (degrees, expected) in [
        (5.0, "straight and fast"),
        (-20.0, "slowly while turning"),
        (90.0, "turns on the spot"),
    ] {
        let mut bench = free_path();
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        bench.set(
            "target",
            Target::at(Pose2D::new(1.0 + 4.0 * cos, 1.0 + 4.0 * sin, 0.0)),
        );
        let panel = bench.draw().expect("the panel is drawn");
        assert_eq!(panel.texts(), [expected], "at {degrees}°");
        assert!((panel.value("heading error") - degrees.to_radians()).abs() < 1e-9);
        assert!((panel.value("target ahead") - 4.0).abs() < 1e-9);
    }
}

#[test]
fn the_panel_shows_whether_the_area_is_free() {
    let mut bench = free_path();
    for (obstacle, ink) in [(None, Ink::Good), (Some((2.0, 0.5)), Ink::Bad)] {
        bench.import("laser", &scan(obstacle));
        let panel = bench.draw().expect("the panel is drawn");
        let area = panel.shapes("area").iter().find_map(|shape| match shape {
            Shape::Line {
                points,
                closed: true,
                stroke,
            } => Some((points[2], stroke.color)),
            _ => None,
        });
        assert_eq!(area, Some(([3.0, 1.0], Color::Ink(ink))));
    }
    bench.set("target", Target::NONE);
    assert_eq!(
        bench.draw().expect("the panel is drawn").texts(),
        ["No target, or no pose"]
    );
}
