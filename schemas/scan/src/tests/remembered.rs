//! What is remembered: only the sensor that showed a thing can show that it is gone.

use super::*;

/// Lets a time pass, at which all sensors measure again: a robot at `x`, with one sonar.
fn pass(bench: &mut Bench<Merge>, millis: u64, x: f64, echo: f32) {
    bench.set_now(Duration::from_millis(millis));
    bench.import("pose", &moving(x));
    for name in ["front", "rear"] {
        bench.import(name, &free());
    }
    bench.import("sonars", &sonars(echo));
    bench.import("bumpers", &bumpers(None));
    bench.import("cliff", &floor(0.05));
}

fn moving(x: f64) -> Odometry {
    let mut odometry = at(x);
    odometry.twist.twist = Twist::planar(0.5, 0.0);
    odometry
}

#[test]
fn a_laser_does_not_clear_what_a_camera_saw_and_the_camera_not_what_is_nearer_than_it_measures() {
    let mut bench = Bench::with_lists(&[
        Entry::new::<LaserScan>("sensors", "laser"),
        Entry::new::<LaserScan>("sensors", "camera"),
    ]);
    bench.set("footprint", Footprint::circle(0.2));
    bench.awake().expect("it wakes");
    let camera = |range: f64| {
        let mut seen = scan(|angle| if angle.abs() < 0.2 { range } else { f64::INFINITY });
        seen.range_min = 0.6;
        seen
    };
    let mut step = |millis, x, range| {
        bench.set_now(Duration::from_millis(millis));
        bench.import("pose", &moving(x));
        bench.import("laser", &free());
        bench.import("camera", &camera(range));
        toward(&merged(&mut bench).expect("a scan"), 0.0)
    };
    // A low box, over which the laser looks.
    assert!((step(0, 0.0, 0.9) - 0.9).abs() < 0.03);
    let below_the_picture = step(800, 0.4, f64::INFINITY);
    assert!((below_the_picture - 0.5).abs() < 0.06, "{below_the_picture} m");
    // It sees another one, which is taken away.
    assert!((step(900, 0.0, 0.9) - 0.5).abs() > 0.3);
    assert_eq!(step(1000, 0.0, f64::INFINITY), f32::INFINITY);
}

#[test]
fn what_a_sonar_heard_stays_until_it_hears_something_farther() {
    let mut bench = bench();
    bench.import("sonars", &sonars(0.6));
    assert!((toward(&merged(&mut bench).expect("a scan"), 0.0) - 0.7).abs() < 0.02);
    for (millis, echo, is_there) in [
        (100, f32::INFINITY, true),
        (300, f32::INFINITY, true),
        (400, 2.6, false),
    ] {
        pass(&mut bench, millis, 0.0, echo);
        let range = toward(&merged(&mut bench).expect("a scan"), 0.0);
        assert_eq!((range - 0.7).abs() < 0.02, is_there, "{range} m at {millis} ms");
    }
    // A thing nearer than the echo does not explain it.
    let post = |angle: f64| if angle.abs() < 0.05 { 0.4 } else { f64::INFINITY };
    bench.import("front", &scan(post));
    bench.import("sonars", &sonars(1.4));
    let scan = merged(&mut bench).expect("a scan");
    let beside = (0..=10).map(|step| toward(&scan, 0.12 + f64::from(step) * 0.005));
    let nearest = beside.fold(f32::INFINITY, f32::min);
    assert!((nearest - 1.5).abs() < 0.02, "{nearest} m");
}

#[test]
fn a_sonar_that_measures_nothing_for_long_is_named_once() {
    let mut bench = bench();
    for millis in (0..5000).step_by(100) {
        pass(&mut bench, millis, 0.0, f32::INFINITY);
        let mut ring = sonars(f32::INFINITY);
        ring.poses.push(Pose2D::new(0.0, 0.1, FRAC_PI_2)).expect("two");
        ring.ranges.push(f32::NAN).expect("two");
        bench.import("sonars", &ring);
        assert!(merged(&mut bench).is_some());
    }
    let said: Vec<&str> = bench.log().iter().map(|(_, words)| words.as_str()).collect();
    assert_eq!(said, ["sonar 1 of `sonars` measures nothing"]);
    assert_eq!(bench.schema().silent(), 1);
}

#[test]
fn where_the_pose_jumps_what_is_touched_jumps_along_and_all_else_is_forgotten() {
    for jump in [0.6, 2.0] {
        let mut bench = bench();
        bench.import("bumpers", &bumpers(Some(2)));
        bench.import("sonars", &sonars(0.6));
        assert!((toward(&merged(&mut bench).expect("a scan"), 0.0) - 0.2).abs() < 0.015);
        pass(&mut bench, 100, jump, f32::INFINITY);
        bench.import(
            "pose",
            &Odometry::planar(Duration::ZERO, Pose2D::new(jump, 0.0, 0.0), Twist::ZERO),
        );
        let scan = merged(&mut bench).expect("a scan");
        let ahead = (-10..=10).map(|step| toward(&scan, f64::from(step) * 0.01));
        let nearest = ahead.fold(f32::INFINITY, f32::min);
        assert!((nearest - 0.2).abs() < 0.015, "{nearest} m after {jump} m");
        assert_eq!(toward(&scan, 0.4), f32::INFINITY);
    }
}
