//! Plane geometry and ranges, compared with known numbers.

use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;

use jde_types::*;

#[track_caller]
fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not near {b}");
}

#[test]
fn angles_are_normalized_to_one_turn() {
    assert_near(normalize_angle(3.0 * PI), PI);
    assert_near(normalize_angle(-PI), PI);
    assert_near(normalize_angle(-0.5), -0.5);
    assert_near(normalize_angle(2.0 * PI + 0.25), 0.25);
}

#[test]
fn yaw_survives_the_quaternion() {
    for yaw in [-3.0, -FRAC_PI_2, 0.0, 0.4, 3.1] {
        assert_near(Quaternion::from_yaw(yaw).yaw(), yaw);
    }
}

#[test]
fn a_rotation_takes_the_axes_to_those_that_it_was_made_from() {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axes = [
        unit,
        [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
        [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
        [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]],
    ];
    for axes in axes {
        let rotation = Quaternion::from_axes(axes);
        for (from, to) in unit.into_iter().zip(axes) {
            for (found, expected) in rotation.rotate(from).into_iter().zip(to) {
                assert_near(found, expected);
            }
        }
    }
    let yaw = Quaternion::from_axes([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_near(yaw.yaw(), FRAC_PI_2);
}

#[test]
fn transforms_follow_each_other_and_back() {
    let pose = |x, y, theta| Transform::from(Pose::from(Pose2D::new(x, y, theta)));
    let (base, laser) = (pose(1.0, 2.0, FRAC_PI_2), pose(0.1, 0.0, PI));
    let point = Point {
        x: 3.0,
        y: 0.0,
        z: 0.5,
    };
    let seen = base.compose(&laser).apply(point);
    for (found, expected) in [(seen.x, 1.0), (seen.y, 2.0 + 0.1 - 3.0), (seen.z, 0.5)] {
        assert_near(found, expected);
    }
    assert_near(Pose::from(base.compose(&laser)).orientation.yaw(), -FRAC_PI_2);
    let back = base.compose(&laser).inverse().apply(seen);
    for (found, expected) in [(back.x, point.x), (back.y, point.y), (back.z, point.z)] {
        assert_near(found, expected);
    }
}

#[test]
fn bearing_and_distance_are_relative_to_the_pose() {
    let pose = Pose2D::new(1.0, 1.0, FRAC_PI_2);
    assert_near(pose.distance_to(&Pose2D::new(4.0, 5.0, 0.0)), 5.0);
    assert_near(pose.bearing_to(&Pose2D::new(1.0, 3.0, 0.0)), 0.0);
    assert_near(pose.bearing_to(&Pose2D::new(0.0, 1.0, 0.0)), FRAC_PI_2);
    assert_near(pose.bearing_to(&Pose2D::new(2.0, 1.0, 0.0)), -FRAC_PI_2);
}

#[test]
fn transform_and_localize_are_inverse() {
    let pose = Pose2D::new(1.0, -2.0, 2.5);
    let local = Pose2D::new(0.3, 0.4, 1.5);
    let transformed = pose.transform(&local);
    assert_near(Pose2D::ORIGIN.transform(&local).x, 0.3);
    assert_near(
        Pose2D::new(0.0, 0.0, FRAC_PI_2)
            .transform(&Pose2D::new(1.0, 0.0, 0.0))
            .y,
        1.0,
    );
    let back = pose.localize(&transformed);
    assert_near(back.x, local.x);
    assert_near(back.y, local.y);
    assert_near(back.theta, local.theta);
}

#[test]
fn times_are_converted_and_saturate() {
    let time = Duration::new(12, 345);
    assert_eq!(Duration::from(Time::from(time)), time);
    assert_eq!(Time::from(Duration::MAX).sec, i32::MAX);
    assert_eq!(Duration::from(Time { sec: -1, nanosec: 5 }), Duration::ZERO);
}

fn scan(ranges: &[f32]) -> LaserScan {
    LaserScan {
        angle_min: -FRAC_PI_2 as f32,
        angle_max: (ranges.len() as f32 - 2.0) * FRAC_PI_2 as f32,
        angle_increment: FRAC_PI_2 as f32,
        range_min: 0.1,
        range_max: 8.0,
        ranges: Seq::from_slice(ranges).expect("the elements fit"),
        ..LaserScan::default()
    }
}

#[test]
fn a_scan_returns_the_hits_of_its_beams() {
    let points: Vec<LaserPoint> = scan(&[1.0, 2.0, 3.0]).points().collect();
    let assert_close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} is not near {b}");
    for (point, (x, y)) in points.iter().zip([(0.0, -1.0), (2.0, 0.0), (0.0, 3.0)]) {
        assert_close(point.x, x);
        assert_close(point.y, y);
    }
    assert_eq!(points[1].beam, 1);
}

#[test]
fn rep_117_ranges_without_a_hit_are_omitted_and_too_close_counts_as_the_least_range() {
    let mut scan = scan(&[f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.05, 9.0, 8.0, 7.0]);
    scan.angle_increment /= 2.0;
    scan.angle_max = scan.angle_min + 6.0 * scan.angle_increment;
    let hits: Vec<(usize, f64)> = scan.points().map(|point| (point.beam, point.range)).collect();
    assert_eq!(hits, [(1, f64::from(0.1_f32)), (6, 7.0)]);
    let rays: Vec<(usize, f32, bool)> = scan.lengths().collect();
    assert_eq!(
        rays,
        [(0, 8.0, false), (5, 8.0, false), (6, 7.0, true)],
        "the greatest range is free, and what is too close is no ray"
    );
}

#[test]
fn the_nearest_point_ahead_is_in_front_and_within_the_width() {
    assert_eq!(scan(&[0.2, 2.0, 0.2]).nearest_ahead(0.1), Some(2.0));
    assert_eq!(scan(&[0.2, f32::INFINITY, 0.2]).nearest_ahead(0.1), None);
}

#[test]
fn the_nearest_point_ahead_is_the_nearest_of_all_points_to_the_bit() {
    for case in 0..2000_u32 {
        // Ranges between 0.2 m and 8 m that look random, over up to a whole turn.
        let beams = 1 + case % 180;
        let range = |beam: u32| 0.2 + (beam * 7919 + case * 104_729) as f32 % 7.8;
        let ranges: Vec<f32> = (0..beams).map(range).collect();
        let view = 0.1 + case as f32 % 6.1;
        let scan = LaserScan {
            angle_min: -view / 2.0,
            angle_max: view / 2.0,
            angle_increment: view / beams as f32,
            ..scan(&ranges)
        };
        for half_width in [0.0, 0.3, 1.0, 5.0] {
            let inside = scan
                .points()
                .filter(|point| point.x > 0.0 && point.y.abs() <= half_width);
            let nearest = inside.map(|point| point.x).min_by(f64::total_cmp);
            assert_eq!(scan.nearest_ahead(half_width), nearest, "{case}: {half_width}");
        }
    }
}

#[test]
fn a_ring_of_sonars_places_its_echoes_around_the_base() {
    let mut ring = RangeRing {
        min_range: 0.1,
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.poses =
        Seq::from_slice(&[Pose2D::new(0.2, 0.1, FRAC_PI_2), Pose2D::ORIGIN]).expect("the elements fit");
    ring.ranges = Seq::from_slice(&[1.0, f32::INFINITY]).expect("the elements fit");
    let echoes: Vec<SonarEcho> = ring.echoes().collect();
    assert_eq!(echoes.len(), 1);
    assert_near(echoes[0].x, 0.2);
    assert_near(echoes[0].y, 1.1);
}

#[test]
fn a_route_is_converted_to_a_path() {
    let poses = Seq::from_slice(&[Pose2D::new(1.0, 2.0, 0.3)]).expect("the element fits");
    let path = Route { poses }.to_path(Header::new(Duration::from_secs(1), "odom"));
    assert_eq!(path.poses.len(), 1);
    assert_near(Pose2D::from(path.poses[0].pose).theta, 0.3);
}

#[test]
fn each_pose_of_a_path_through_points_faces_the_next_one() {
    let header = Header::new(Duration::from_secs(1), "odom");
    let path = Path::through(header, &[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)]);
    let headings: Vec<f64> = path
        .poses
        .iter()
        .map(|pose| Pose2D::from(pose.pose).theta)
        .collect();
    for (heading, expected) in headings.iter().zip([0.0, FRAC_PI_2, FRAC_PI_2]) {
        assert_near(*heading, expected);
    }
    assert_eq!((path.poses.len(), path.poses[2].header), (3, header));
    assert_eq!(
        Path::through(header, &[(0.0, 0.0); 300]).poses.len(),
        256,
        "as far as they fit"
    );
    assert_eq!(Path::through(header, &[]).poses.len(), 0);
}

#[test]
fn the_occupied_cells_of_a_map_are_where_its_origin_puts_them() {
    let mut map = OccupancyGrid::drawn(0.5, &["#?.", "..#"]);
    map.data[1] = 64;
    map.data[5] = 101;
    map.info.origin = Pose2D::new(1.0, 2.0, FRAC_PI_2).into();
    let places: Vec<_> = map.occupied(5).collect();
    assert_eq!(places.len(), 2);
    for (place, (x, y)) in places.iter().zip([(0.75, 3.25), (0.25, 2.25)]) {
        assert_near(place.0, x);
        assert_near(place.1, y);
    }
    assert_eq!(map.occupied(1).count(), 1);
    map.info.resolution = f32::NAN;
    assert_eq!(map.occupied(5).count(), 0);
}
