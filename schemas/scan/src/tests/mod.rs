//! What a merged scan has of each sensor, what it does not claim to know, and when there is none.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_schema::bench::{Bench, Entry};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, Point2D};

use crate::Merge;
use crate::sensor::Mounting;

mod looked_at;
mod refused;
mod remembered;

/// A robot of 0.2 m radius with a laser of 240 degrees ahead, one behind, sonars, bumpers and a cliff sensor.
fn bench() -> Bench<Merge> {
    let mounted = |x, theta| Mounting {
        mount: Pose2D::new(x, 0.0, theta),
        ..Mounting::DEFAULT
    };
    let cliff = Mounting {
        floor: 0.05,
        ..mounted(0.18, 0.0)
    };
    let mut bench = Bench::with_lists(&[
        Entry::new::<LaserScan>("sensors", "front").settings(&mounted(0.2, 0.0)),
        Entry::new::<LaserScan>("sensors", "rear").settings(&mounted(-0.2, PI)),
        Entry::new::<RangeRing>("sensors", "sonars"),
        Entry::new::<Bumpers>("sensors", "bumpers"),
        Entry::new::<Range>("sensors", "cliff").settings(&cliff),
    ]);
    bench.set("footprint", Footprint::circle(0.2));
    bench.awake().expect("it wakes");
    bench.import("pose", &at(0.0));
    bench.import("front", &free());
    bench.import("rear", &free());
    bench.import("sonars", &sonars(f32::INFINITY));
    bench.import("bumpers", &bumpers(None));
    bench.import("cliff", &floor(0.05));
    bench
}

fn at(x: f64) -> Odometry {
    Odometry::planar(Duration::ZERO, Pose2D::new(x, 0.0, 0.0), Twist::ZERO)
}

/// A scan of 240 degrees, each beam with the range of its angle.
fn scan(range: impl Fn(f64) -> f64) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -(120_f32.to_radians()),
        angle_increment: 1_f32.to_radians(),
        range_min: 0.02,
        range_max: 4.0,
        ..LaserScan::default()
    };
    for beam in 0..241 {
        let range = range(scan.angle(beam)) as f32;
        scan.ranges.push(range).expect("few beams");
    }
    scan.state_last_angle();
    scan
}

fn free() -> LaserScan {
    scan(|_| f64::INFINITY)
}

/// What a laser sees of a wall `distance` m before it.
fn wall(distance: f64) -> LaserScan {
    scan(|angle| {
        let range = distance / angle.cos();
        if range > 0.0 && range < 4.0 {
            range
        } else {
            f64::INFINITY
        }
    })
}

/// One sonar that looks ahead.
fn sonars(range: f32) -> RangeRing {
    let mut ring = RangeRing {
        field_of_view: 0.5,
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.poses.push(Pose2D::new(0.1, 0.0, 0.0)).expect("one");
    ring.ranges.push(range).expect("one");
    ring
}

/// Five bumpers ahead and five behind, of which one is pressed.
fn bumpers(pressed: Option<usize>) -> Bumpers {
    let mut bumpers = Bumpers::default();
    let side =
        |from: usize| -> Vec<Flag> { (from..from + 5).map(|at| (Some(at) == pressed).into()).collect() };
    bumpers.front.extend_from_slice(&side(0)).expect("five");
    bumpers.rear.extend_from_slice(&side(5)).expect("five");
    bumpers
}

/// What a sensor measures that looks down.
fn floor(range: f32) -> Range {
    Range {
        radiation_type: 1,
        max_range: 0.5,
        min_range: 0.01,
        range,
        ..Range::default()
    }
}

fn merged(bench: &mut Bench<Merge>) -> Option<LaserScan> {
    bench.iterate().expect("it iterates");
    let scan = bench.exported::<LaserScan>("scan");
    if let Some(scan) = &scan {
        scan.measured().expect("it is a scan");
    }
    scan
}

/// What the beam nearest to a direction tells.
fn toward(scan: &LaserScan, angle: f64) -> f32 {
    let beam = (angle - f64::from(scan.angle_min)) / f64::from(scan.angle_increment);
    scan.ranges[beam.round() as usize % scan.ranges.len()]
}

fn words(bench: &mut Bench<Merge>) -> String {
    assert_eq!(merged(bench), None);
    bench.schema().lacks().expect("a reason").to_owned()
}

#[test]
fn two_lasers_are_one_around_the_base() {
    let mut bench = bench();
    bench.import("front", &wall(1.0));
    bench.import("rear", &wall(2.0));
    let scan = merged(&mut bench).expect("a scan");
    assert!((toward(&scan, 0.0) - 1.2).abs() < 0.01);
    assert!((toward(&scan, PI) - 2.2).abs() < 0.01);
    assert_eq!(scan.header.frame_id.as_str(), "base_link");
}

#[test]
fn a_direction_is_free_only_where_a_laser_looked_at_the_whole_way() {
    let mut bench = bench();
    let scan = merged(&mut bench).expect("a scan");
    assert_eq!(toward(&scan, 0.0), f32::INFINITY);
    assert_eq!(toward(&scan, PI), f32::INFINITY);
    // Beside the robot there is a corner that neither laser sees.
    assert!(toward(&scan, FRAC_PI_2).is_nan() && toward(&scan, -FRAC_PI_2).is_nan());
    assert!(
        (f64::from(scan.range_max) - 3.8).abs() < 1e-6,
        "from the centre of the base"
    );
}

#[test]
fn what_went_out_of_all_views_is_remembered_and_what_is_seen_to_be_gone_is_not() {
    let mut bench = bench();
    // Ahead to the left, at the edge of the view of the front laser.
    let post = |x: f64, y: f64| {
        scan(move |angle| {
            if (angle - y.atan2(x)).abs() < 0.05 {
                x.hypot(y)
            } else {
                f64::INFINITY
            }
        })
    };
    let is_there =
        |scan: &LaserScan, x: f64, y: f64| (toward(scan, y.atan2(x)) - x.hypot(y) as f32).abs() < 0.05;
    bench.import("front", &post(0.0, 0.3));
    assert!(is_there(&merged(&mut bench).expect("a scan"), 0.2, 0.3));
    // The robot drives on by 0.2 m: the post is beside it, where no laser looks.
    bench.set_now(Duration::from_millis(400));
    let mut odometry = at(0.2);
    odometry.twist.twist = Twist::planar(0.5, 0.0);
    bench.import("pose", &odometry);
    for (name, value) in [("front", free()), ("rear", free())] {
        bench.import(name, &value);
    }
    bench.import("sonars", &sonars(f32::INFINITY));
    bench.import("bumpers", &bumpers(None));
    bench.import("cliff", &floor(0.05));
    assert!(is_there(&merged(&mut bench).expect("a scan"), 0.0, 0.3));
    bench.set("observation_persistence", 0.1);
    assert!(toward(&merged(&mut bench).expect("a scan"), FRAC_PI_2).is_nan());
    // A post in the middle of the view that is gone is gone at once.
    bench.set("observation_persistence", 10.0);
    bench.import("front", &post(1.0, 0.0));
    assert!((toward(&merged(&mut bench).expect("a scan"), 0.0) - 1.2).abs() < 0.02);
    bench.import("front", &free());
    assert_eq!(toward(&merged(&mut bench).expect("a scan"), 0.0), f32::INFINITY);
}

#[test]
fn a_sonar_adds_what_lasers_look_over_and_an_echo_that_they_explain_adds_nothing() {
    let mut bench = bench();
    bench.import("sonars", &sonars(0.9));
    let scan = merged(&mut bench).expect("a scan");
    for angle in [0.0, 0.15, -0.15] {
        assert!((toward(&scan, angle) - 1.0).abs() < 0.02, "{angle}");
    }
    // The wall is 1.2 m ahead of the centre, 1.1 m from the sonar.
    bench.import("front", &wall(1.0));
    bench.import("sonars", &sonars(1.1));
    let scan = merged(&mut bench).expect("a scan");
    let at_wall = |angle: f64| (f64::from(toward(&scan, angle)) * angle.cos() - 1.2).abs() < 0.02;
    assert!(scan.ranges.iter().all(|range| range.is_nan() || *range > 1.1));
    assert!(at_wall(0.0));
    bench.import("front", &free());
    bench.import("sonars", &sonars(2.6));
    assert_eq!(
        toward(&merged(&mut bench).expect("a scan"), 0.0),
        f32::INFINITY,
        "too far away"
    );
}

#[test]
fn a_pressed_bumper_is_an_obstacle_at_its_part_of_the_outline_also_when_the_robot_backs_away() {
    let mut bench = bench();
    bench.import("bumpers", &bumpers(Some(2)));
    let scan = merged(&mut bench).expect("a scan");
    assert!((toward(&scan, 0.0) - 0.2).abs() < 0.015 && (toward(&scan, 0.25) - 0.2).abs() < 0.015);
    assert!(toward(&scan, 0.5) > 1.0 && toward(&scan, PI) > 1.0);
    bench.import("bumpers", &bumpers(None));
    bench.import("pose", &at(-0.1));
    let scan = merged(&mut bench).expect("a scan");
    let nearest = (-10..=10)
        .map(|step| toward(&scan, f64::from(step) * 0.01))
        .fold(f32::INFINITY, f32::min);
    assert!((nearest - 0.3).abs() < 0.02, "lasers look over it");
    bench.set("observation_persistence", 0.0);
    bench.set_now(Duration::from_millis(100));
    assert_eq!(toward(&merged(&mut bench).expect("a scan"), 0.0), f32::INFINITY);
    bench.import("bumpers", &bumpers(Some(5)));
    let scan = merged(&mut bench).expect("a scan");
    let left = PI - FRAC_PI_2 + 0.3;
    assert!((toward(&scan, left) - 0.2).abs() < 0.015, "the left one behind");
}

#[test]
fn a_missing_or_too_deep_floor_is_an_obstacle_at_the_edge_of_the_robot() {
    for (range, is_cliff) in [(0.05, false), (0.07, false), (0.09, true), (f32::INFINITY, true)] {
        let mut bench = bench();
        bench.import("cliff", &floor(range));
        let scan = merged(&mut bench).expect("a scan");
        // The sensor is inside the outline, and a guard must not count what is there as an obstacle to pass.
        assert_eq!((toward(&scan, 0.0) - 0.205).abs() < 0.01, is_cliff, "{range}");
    }
    let down = Mounting {
        floor: 0.05,
        ..Mounting::DEFAULT
    };
    let mut ring = Bench::<Merge>::with_lists(&[
        Entry::new::<LaserScan>("sensors", "laser"),
        Entry::new::<RangeRing>("sensors", "edges").settings(&down),
    ]);
    ring.awake().expect("it wakes");
    ring.import("pose", &at(0.0));
    ring.import("laser", &free());
    let mut edges = sonars(0.05);
    edges.poses.push(Pose2D::new(0.1, 0.15, 0.0)).expect("two");
    edges.ranges.push(0.3).expect("two");
    ring.import("edges", &edges);
    let scan = merged(&mut ring).expect("a scan");
    assert!((toward(&scan, 0.983) - 0.255).abs() < 0.01 && toward(&scan, 0.0) > 1.0);
    edges.ranges[1] = f32::NAN;
    ring.import("edges", &edges);
    assert_eq!(words(&mut ring), "`edges`: it does not measure the floor");
}

#[test]
fn while_a_sensor_is_silent_late_or_of_another_clock_there_is_no_scan_and_the_words_name_it() {
    for name in ["front", "rear", "sonars", "bumpers", "cliff"] {
        let mut bench = bench();
        assert!(merged(&mut bench).is_some());
        bench.retract(name);
        assert_eq!(words(&mut bench), format!("`{name}` has no value"));
        assert_eq!(bench.log().len(), 1);
    }
    let mut late = bench();
    late.set_now(Duration::from_millis(1200));
    late.import("pose", &at(0.0));
    late.import("front", &free());
    assert_eq!(words(&mut late), "`rear`: the scans are 1.2 s old");
    let mut ahead = bench();
    ahead.set_now(Duration::from_secs(5));
    ahead.import("bumpers", &bumpers(None));
    ahead.set_now(Duration::ZERO);
    let said = words(&mut ahead);
    assert!(
        said.starts_with("the values of `bumpers` are stamped 5.0 s ahead"),
        "{said}"
    );
    let mut lost = bench();
    lost.retract("pose");
    assert_eq!(words(&mut lost), "there is no odometry");
    let mut blind = bench();
    blind.import("rear", &scan(|_| f64::NAN));
    assert_eq!(words(&mut blind), "`rear` has no value");
}

#[test]
fn the_scan_has_the_time_of_its_oldest_part_and_each_part_is_where_it_was_measured() {
    let mut bench = bench();
    // The front laser measured at 0 s, when the base was at 0; all else is of 0.2 s later, 0.1 m farther.
    bench.import("front", &wall(1.0));
    bench.iterate().expect("it iterates");
    bench.set_now(Duration::from_millis(200));
    let mut odometry = at(0.1);
    odometry.twist.twist = Twist::planar(0.5, 0.0);
    bench.import("pose", &odometry);
    bench.import("rear", &wall(1.0));
    bench.import("sonars", &sonars(f32::INFINITY));
    bench.import("bumpers", &bumpers(None));
    bench.import("cliff", &floor(0.05));
    let scan = merged(&mut bench).expect("a scan");
    assert!(
        bench
            .exported_at("scan")
            .is_some_and(|time| time < Duration::from_millis(1))
    );
    assert!((toward(&scan, 0.0) - 1.2).abs() < 0.01);
    assert!(
        (toward(&scan, PI) - 1.1).abs() < 0.01,
        "by then the base had come 0.1 m nearer"
    );
}

#[test]
fn what_is_no_sensor_and_a_list_without_a_laser_are_refused_before_the_start() {
    let problems = |entries: &[Entry]| {
        let problems = Bench::<Merge>::with_lists(entries)
            .inspect()
            .expect("it inspects");
        problems
            .into_iter()
            .map(|problem| problem.words)
            .collect::<Vec<_>>()
            .join("; ")
    };
    let laser = || Entry::new::<LaserScan>("sensors", "front");
    assert_eq!(problems(&[laser()]), "");
    assert!(problems(&[laser(), Entry::new::<f64>("sensors", "number")]).contains("expected a LaserScan"));
    assert!(
        problems(&[Entry::new::<RangeRing>("sensors", "sonars")]).contains("none of `sensors` is a laser")
    );
    let wrong = Mounting {
        floor: -1.0,
        ..Mounting::DEFAULT
    };
    assert!(problems(&[laser().settings(&wrong)]).contains("`floor` of `front`: expected 0 to 10 m"));
}
