//! Plane geometry and ranges, compared with known numbers.

use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;

use jde_types::*;

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

#[test]
fn angles_are_brought_into_one_turn() {
    near(normalize_angle(3.0 * PI), PI);
    near(normalize_angle(-PI), PI);
    near(normalize_angle(-0.5), -0.5);
    near(normalize_angle(2.0 * PI + 0.25), 0.25);
}

#[test]
fn yaw_survives_the_quaternion() {
    for yaw in [-3.0, -FRAC_PI_2, 0.0, 0.4, 3.1] {
        near(Quaternion::from_yaw(yaw).yaw(), yaw);
    }
}

#[test]
fn bearing_and_distance_are_seen_from_the_pose() {
    let pose = Pose2D::new(1.0, 1.0, FRAC_PI_2);
    near(pose.distance_to(&Pose2D::new(4.0, 5.0, 0.0)), 5.0);
    near(pose.bearing_to(&Pose2D::new(1.0, 3.0, 0.0)), 0.0);
    near(pose.bearing_to(&Pose2D::new(0.0, 1.0, 0.0)), FRAC_PI_2);
    near(pose.bearing_to(&Pose2D::new(2.0, 1.0, 0.0)), -FRAC_PI_2);
}

#[test]
fn transform_and_localize_undo_each_other() {
    let pose = Pose2D::new(1.0, -2.0, 2.5);
    let local = Pose2D::new(0.3, 0.4, 1.5);
    let there = pose.transform(&local);
    near(Pose2D::ORIGIN.transform(&local).x, 0.3);
    near(
        Pose2D::new(0.0, 0.0, FRAC_PI_2)
            .transform(&Pose2D::new(1.0, 0.0, 0.0))
            .y,
        1.0,
    );
    let back = pose.localize(&there);
    near(back.x, local.x);
    near(back.y, local.y);
    near(back.theta, local.theta);
}

#[test]
fn times_survive_and_saturate() {
    let time = Duration::new(12, 345);
    assert_eq!(Duration::from(Time::from(time)), time);
    assert_eq!(Time::from(Duration::MAX).sec, i32::MAX);
    assert_eq!(Duration::from(Time { sec: -1, nanosec: 5 }), Duration::ZERO);
}

fn scan(ranges: &[f32]) -> LaserScan {
    LaserScan {
        angle_min: -FRAC_PI_2 as f32,
        angle_increment: FRAC_PI_2 as f32,
        range_min: 0.1,
        range_max: 8.0,
        ranges: Seq::from_slice(ranges).expect("they fit"),
        ..LaserScan::default()
    }
}

#[test]
fn a_scan_shows_what_its_beams_hit() {
    let points: Vec<LaserPoint> = scan(&[1.0, 2.0, 3.0]).points().collect();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    for (point, (x, y)) in points.iter().zip([(0.0, -1.0), (2.0, 0.0), (0.0, 3.0)]) {
        close(point.x, x);
        close(point.y, y);
    }
    assert_eq!(points[1].beam, 1);
}

#[test]
fn rep_117_ranges_that_measure_nothing_are_left_out_and_too_close_is_close() {
    let scan = scan(&[f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.05, 9.0, 8.0]);
    let hits: Vec<(usize, f64)> = scan.points().map(|point| (point.beam, point.range)).collect();
    assert_eq!(hits, [(1, f64::from(0.1_f32)), (5, 8.0)]);
}

#[test]
fn the_nearest_ahead_is_within_the_width_and_in_front() {
    assert_eq!(scan(&[0.2, 2.0, 0.2]).nearest_ahead(0.1), Some(2.0));
    assert_eq!(scan(&[0.2, f32::INFINITY, 0.2]).nearest_ahead(0.1), None);
}

#[test]
fn a_ring_of_sonars_places_its_echoes_around_the_base() {
    let mut ring = RangeRing {
        min_range: 0.1,
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.poses = Seq::from_slice(&[Pose2D::new(0.2, 0.1, FRAC_PI_2), Pose2D::ORIGIN]).expect("they fit");
    ring.ranges = Seq::from_slice(&[1.0, f32::INFINITY]).expect("they fit");
    let echoes: Vec<SonarEcho> = ring.echoes().collect();
    assert_eq!(echoes.len(), 1);
    near(echoes[0].x, 0.2);
    near(echoes[0].y, 1.1);
}

#[test]
fn a_route_is_drawn_as_a_path() {
    let poses = Seq::from_slice(&[Pose2D::new(1.0, 2.0, 0.3)]).expect("it fits");
    let path = Route { poses }.to_path(Header::new(Duration::from_secs(1), "odom"));
    assert_eq!(path.poses.len(), 1);
    near(Pose2D::from(path.poses[0].pose).theta, 0.3);
}
