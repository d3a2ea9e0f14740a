//! What is a measurement and what is none.

use jde_types::*;

/// A scan of half a turn, whose beams all measure `range`.
fn scan(range: f32) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -1.5,
        angle_max: 1.5,
        angle_increment: 0.1,
        range_min: 0.1,
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(31).fill(range);
    scan
}

/// Asserts that nothing of the scan is taken for a measurement.
#[track_caller]
fn assert_none(scan: &LaserScan, expected: &str) {
    let why = scan.measured().expect_err("it is not a scan").to_string();
    assert!(why.contains(expected), "{why}");
    assert_eq!(
        scan.points().count() + scan.rays(&Pose2D::ORIGIN).count(),
        0,
        "{why}"
    );
    assert_eq!(scan.ahead(0.3, 0.6), Ahead::Unseen, "{why}");
}

#[test]
fn a_scan_without_a_measurement_is_none() {
    for range in [f32::NAN, 0.0, -0.0, -1.0, 0.05, 8.1, 65.535, f32::MAX, f32::MIN] {
        assert_none(&scan(range), "measures nothing");
    }
    assert_none(
        &LaserScan {
            range_min: 0.0,
            ..scan(0.0)
        },
        "measures nothing",
    );
    assert_none(
        &LaserScan {
            ranges: Seq::new(),
            ..scan(1.0)
        },
        "measures nothing",
    );
    for range in [f32::INFINITY, f32::NEG_INFINITY, 8.0, 0.1, 7.9] {
        assert_eq!(scan(range).measured(), Ok(()), "{range}");
    }
    let mut one = scan(f32::NAN);
    one.ranges.as_mut_slice()[30] = 2.0;
    assert_eq!(
        (one.measured(), one.points().count()),
        (Ok(()), 1),
        "one beam is enough"
    );
}

#[test]
fn a_scan_that_contradicts_itself_is_none() {
    type Change = fn(&mut LaserScan);
    let changes: [(Change, &str); 14] = [
        (|scan| scan.angle_increment = 0.0, "angles"),
        (|scan| scan.angle_increment = f32::NAN, "angles"),
        (|scan| scan.angle_increment = f32::INFINITY, "angles"),
        (|scan| scan.angle_min = f32::NAN, "angles"),
        (|scan| scan.angle_max = f32::NEG_INFINITY, "angles"),
        (
            |scan| (scan.angle_increment, scan.angle_max) = (1.0, 28.5),
            "angles",
        ),
        (
            |scan| scan.angle_increment = -0.1,
            "31 beams, and its angles state -29",
        ),
        (|scan| scan.angle_max = 3.0, "31 beams, and its angles state 46"),
        (
            |scan| scan.angle_increment = 0.05,
            "31 beams, and its angles state 61",
        ),
        (
            |scan| scan.ranges = Seq::from_slice(&[2.0; 15]).expect("they fit"),
            "15 beams, and its angles state 31",
        ),
        (
            |scan| (scan.range_min, scan.range_max) = (8.0, 0.1),
            "8 m and 0.1 m",
        ),
        (|scan| scan.range_max = scan.range_min, "0.1 m and 0.1 m"),
        (|scan| scan.range_min = -1.0, "-1 m and 8 m"),
        (|scan| scan.range_max = f32::NAN, "0.1 m and NaN m"),
    ];
    for (change, expected) in changes {
        let mut wrong = scan(2.0);
        change(&mut wrong);
        assert_none(&wrong, expected);
    }
}

#[test]
fn what_others_report_slightly_wrong_is_a_scan() {
    let mut last_angle_not_counted = scan(2.0);
    last_angle_not_counted.angle_max += 0.1;
    let mut rounded = scan(2.0);
    rounded.ranges.resize(1081).fill(2.0);
    (rounded.angle_min, rounded.angle_max, rounded.angle_increment) = (-2.356, 2.356, 0.0044);
    let mut turned = scan(2.0);
    (turned.angle_min, turned.angle_max, turned.angle_increment) = (1.5, -1.5, -0.1);
    let mut single = scan(2.0);
    single.ranges.resize(1);
    (single.angle_min, single.angle_max, single.angle_increment) = (0.0, 0.0, 0.0);
    let unlimited = LaserScan {
        range_max: f32::INFINITY,
        ..scan(2.0)
    };
    for scan in [last_angle_not_counted, rounded, turned, single, unlimited] {
        assert_eq!(scan.measured(), Ok(()));
        assert!(scan.points().count() > 0);
    }
}

#[test]
fn an_area_ahead_into_which_no_beam_measures_is_not_free() {
    let mut scan = scan(f32::INFINITY);
    assert_eq!(scan.ahead(0.3, 0.6), Ahead::Free);
    scan.ranges.as_mut_slice()[8..23].fill(0.02);
    assert_eq!((scan.measured(), scan.ahead(0.3, 0.6)), (Ok(()), Ahead::Unseen));
    scan.ranges.as_mut_slice()[15] = 0.5;
    assert!(matches!(scan.ahead(0.3, 0.6), Ahead::Hit(nearest) if (nearest - 0.5).abs() < 1e-9));
    assert_eq!(
        scan.ahead(0.3, 0.4),
        Ahead::Free,
        "the beam goes through all of it"
    );
    scan.ranges.as_mut_slice()[15] = f32::NEG_INFINITY;
    assert!(matches!(scan.ahead(0.3, 0.6), Ahead::Hit(nearest) if (nearest - 0.1).abs() < 1e-6));
    scan.range_min = 0.0;
    assert!(
        matches!(scan.ahead(0.3, 0.6), Ahead::Hit(_)),
        "an object at the scanner"
    );
}

#[test]
fn a_sensor_of_a_fixed_distance_tells_whether_something_is_there() {
    let mut range = Range {
        min_range: 0.3,
        max_range: 0.3,
        range: f32::NEG_INFINITY,
        ..Range::default()
    };
    assert_eq!((range.measured(), range.echo()), (Ok(()), Echo::TooClose));
    range.range = f32::INFINITY;
    assert_eq!((range.measured(), range.echo()), (Ok(()), Echo::Free));
    range.range = 0.0;
    assert_eq!(range.measured(), Err(Unmeasured::Nothing));
}

#[test]
fn a_ring_of_sonars_that_all_measure_nothing_is_none() {
    let mut ring = RangeRing {
        min_range: 0.1,
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.ranges.resize(4).fill(0.0);
    assert_eq!(ring.measured(), Err(Unmeasured::Nothing));
    ring.ranges.as_mut_slice()[2] = 5.0;
    assert_eq!(ring.measured(), Ok(()));
    ring.max_range = 0.05;
    assert!(matches!(ring.measured(), Err(Unmeasured::Limits { .. })));
}

#[test]
fn a_picture_of_depths_without_a_depth_is_none() {
    let mut image = Image::boxed();
    (image.width, image.height, image.step) = (2, 2, 8);
    image.encoding = Text::truncated("32FC1");
    image.data.resize(16).fill(0);
    assert_eq!(image.measured(), Err(Unmeasured::Nothing));
    image.data.as_mut_slice()[12..].copy_from_slice(&1.5_f32.to_le_bytes());
    assert_eq!(image.measured(), Ok(()));
    image.step = 9;
    assert_eq!(image.measured(), Err(Unmeasured::Bytes));
    (image.encoding, image.step) = (Text::truncated("mono8"), 2);
    assert_eq!(image.measured(), Ok(()), "a black picture is one");
    image.width = 0;
    assert_eq!(image.measured(), Err(Unmeasured::Nothing));
}

#[test]
fn a_quaternion_is_an_orientation_whatever_its_length_but_without_one_it_is_none() {
    let turned = Quaternion::from_yaw(1.0);
    for factor in [2.0, 0.5, -1.0, 1e-100, 1e100] {
        let long = Quaternion {
            x: factor * turned.x,
            y: factor * turned.y,
            z: factor * turned.z,
            w: factor * turned.w,
        };
        assert!((long.yaw() - 1.0).abs() < 1e-12, "{factor}");
        let [x, y, _] = long.rotate([1.0, 0.0, 0.0]);
        assert!(
            (x - 1.0_f64.cos()).abs() < 1e-12 && (y - 1.0_f64.sin()).abs() < 1e-12,
            "{factor}"
        );
    }
    assert_eq!(turned.normalized(), Some(turned), "to the bit");
    for part in [0.0, f64::NAN, f64::INFINITY] {
        let none = Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: part,
        };
        assert_eq!(none.normalized(), None);
        assert!(none.yaw().is_nan() && none.rotate([1.0, 0.0, 0.0])[0].is_nan());
    }
}

#[test]
fn an_odometry_needs_an_orientation_and_finite_numbers() {
    let with = |change: fn(&mut Odometry)| {
        let mut odometry = Odometry::default();
        change(&mut odometry);
        odometry.measured()
    };
    assert_eq!(with(|_| ()), Ok(()));
    assert_eq!(
        with(|odometry| odometry.twist.twist.linear.z = f64::NAN),
        Ok(()),
        "it does not count in the plane"
    );
    assert_eq!(
        with(|odometry| odometry.pose.pose.orientation.w = 0.0),
        Err(Unmeasured::Orientation)
    );
    assert_eq!(
        with(|odometry| odometry.pose.pose.position.x = f64::NAN),
        Err(Unmeasured::NotFinite)
    );
    assert_eq!(
        with(|odometry| odometry.twist.twist.angular.z = f64::INFINITY),
        Err(Unmeasured::NotFinite)
    );
}

#[test]
fn the_checks_of_a_type_are_found_by_its_description() {
    let checks = Checks::of(&LaserScan::describe()).expect("scans are checked");
    assert_eq!((checks.measured)(scan(2.0).as_bytes()), Ok(()));
    assert_eq!((checks.measured)(scan(0.0).as_bytes()), Err(Unmeasured::Nothing));
    assert!(Checks::of(&Twist::describe()).is_none());
    assert!(Checks::of(&Range::describe()).is_some_and(|checks| checks.repeats.is_none()));
    let mut other = LaserScan::describe();
    other.fields.pop();
    assert!(
        Checks::of(&other).is_none(),
        "a type of that name with other fields"
    );
}

#[test]
fn a_sensor_repeats_itself_if_only_the_header_changes_and_a_motion_would_show() {
    fn repeats<T: Value>(now: &T, before: &T) -> bool {
        let checks = Checks::of(&T::describe()).expect("it is checked");
        checks.repeats.expect("it is of the surroundings")(now.as_bytes(), before.as_bytes())
    }
    let before = scan(2.0);
    let mut now = LaserScan {
        header: Header::new(core::time::Duration::from_secs(9), "laser"),
        ..before
    };
    assert!(repeats(&now, &before));
    now.ranges.as_mut_slice()[7] = f32::NAN;
    assert!(
        !repeats(&now, &before) && repeats(&now, &now),
        "NaN is NaN to the bit"
    );
    assert!(
        !repeats(&scan(f32::INFINITY), &scan(f32::INFINITY)),
        "an empty hall"
    );
    let mut ring = RangeRing {
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.poses.resize(4);
    ring.ranges.resize(4).fill(f32::INFINITY);
    ring.ranges.as_mut_slice()[..2].fill(1.0);
    assert!(!repeats(&ring, &ring), "two echoes are equal by chance");
    ring.ranges.as_mut_slice()[2] = 1.0;
    assert!(repeats(&ring, &ring));
    let mut image = Image::boxed();
    (image.width, image.height, image.step) = (2, 2, 6);
    image.data.resize(12)[6..].fill(9);
    assert!(!repeats(&*image, &*image), "floor and wall");
    image.data.as_mut_slice()[4] = 1;
    assert!(repeats(&*image, &*image));
}
