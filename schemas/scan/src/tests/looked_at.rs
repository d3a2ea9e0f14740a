//! What counts as looked at: no beam goes through a place that no laser saw.

use jde_motion::OdometryHistory;
use proptest::prelude::*;

use super::*;
use crate::eye::{Eye, Look};

/// A robot of 0.2 m radius with one laser of 240 degrees ahead and sonars.
fn without_eyes_behind() -> Bench<Merge> {
    let mut bench = Bench::with_lists(&[
        Entry::new::<LaserScan>("sensors", "laser"),
        Entry::new::<RangeRing>("sensors", "sonars"),
    ]);
    bench.set("footprint", Footprint::circle(0.2));
    bench.awake().expect("it wakes");
    bench.import("pose", &at(0.0));
    bench.import("laser", &free());
    bench
}

fn sonar_behind(range: f32) -> RangeRing {
    let mut ring = sonars(range);
    ring.poses.as_mut_slice()[0] = Pose2D::new(-0.1, 0.0, PI);
    ring
}

#[test]
fn an_echo_behind_what_no_laser_sees_frees_nothing_and_a_near_one_ends_the_beam_at_once() {
    let mut bench = without_eyes_behind();
    bench.import("sonars", &sonar_behind(2.4));
    let scan = merged(&mut bench).expect("a scan");
    assert!(toward(&scan, PI).is_nan(), "{}", toward(&scan, PI));
    bench.import("sonars", &sonar_behind(0.3));
    let scan = merged(&mut bench).expect("a scan");
    assert!((toward(&scan, PI) - 0.215).abs() < 0.01, "{}", toward(&scan, PI));
}

#[test]
fn where_one_laser_measures_nothing_the_sight_of_another_frees_nothing() {
    let mut bench = Bench::with_lists(&[
        Entry::new::<LaserScan>("sensors", "laser"),
        Entry::new::<LaserScan>("sensors", "camera"),
    ]);
    bench.set("footprint", Footprint::circle(0.2));
    bench.awake().expect("it wakes");
    bench.import("pose", &at(0.0));
    bench.import("laser", &free());
    bench.import(
        "camera",
        &scan(|angle| {
            if angle.abs() < 0.2 {
                f64::NAN
            } else {
                f64::INFINITY
            }
        }),
    );
    let scan = merged(&mut bench).expect("a scan");
    assert!(toward(&scan, 0.0).is_nan());
    assert_eq!(toward(&scan, 0.5), f32::INFINITY);
}

#[test]
fn what_is_between_two_beams_is_not_looked_at() {
    let mut bench = without_eyes_behind();
    bench.import("sonars", &sonars(f32::INFINITY));
    let mut sparse = free();
    sparse.angle_increment = 0.2;
    sparse.angle_min = -1.0;
    sparse.ranges.resize(11);
    sparse.state_last_angle();
    bench.import("laser", &sparse);
    let scan = merged(&mut bench).expect("a scan");
    assert_eq!(toward(&scan, 0.2), f32::INFINITY);
    assert!(toward(&scan, 0.3).is_nan(), "{}", toward(&scan, 0.3));
}

#[test]
fn a_laser_that_turns_during_a_scan_looked_only_where_its_beams_were_then() {
    let mut scan = free();
    scan.time_increment = 0.2 / 240.0;
    let mut history = OdometryHistory::default();
    // By the last beam, the robot has turned to the right by 23 degrees.
    for (millis, theta) in [(0, 0.0), (200, -0.4)] {
        let time = Duration::from_millis(millis);
        let pose = Pose2D::new(0.0, 0.0, theta);
        history.add(time, &Odometry::planar(time, pose, Twist::planar(0.0, -2.0)));
    }
    let sweep = history
        .sweep(&scan, Duration::ZERO, Duration::from_millis(200))
        .expect("the odometry is known");
    let eye = Eye::new(0, &scan, &sweep, &Pose2D::ORIGIN);
    let look = |degrees: f64| {
        let (y, x) = degrees.to_radians().sin_cos();
        eye.look(&Point2D { x, y })
    };
    assert_eq!(look(95.0), Look::Sees);
    assert_eq!(look(105.0), Look::Outside);
    assert_eq!(look(-118.0), Look::Sees);
    assert_eq!(look(-125.0), Look::Outside);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn no_beam_goes_through_a_place_that_no_laser_sees(
        x in -1.5..1.5f64, y in -1.5..1.5f64, side in 0.1..0.4f64, echo in 0.2..2.4f32,
    ) {
        // A round post, seen by both lasers as its geometry says, and an echo of what they look over.
        prop_assume!(x.hypot(y) > 0.5 + side);
        let mounts = [Pose2D::new(0.2, 0.0, 0.0), Pose2D::new(-0.2, 0.0, PI)];
        let length = |mount: &Pose2D, angle: f64, side: f64| {
            let local = mount.localize(&Pose2D::new(x, y, 0.0));
            let (sin, cos) = angle.sin_cos();
            let (along, across) = (local.x * cos + local.y * sin, local.y * cos - local.x * sin);
            if along > 0.0 && across.abs() < side {
                along - (side * side - across * across).sqrt()
            } else {
                f64::INFINITY
            }
        };
        // Up to the width of a beam, and to the tolerance of a range.
        let is_visible = |place: &Pose2D| mounts.iter().any(|mount| {
            let local = mount.localize(place);
            let (angle, distance) = (local.y.atan2(local.x), local.x.hypot(local.y));
            angle.abs() < 121_f64.to_radians() && distance < length(mount, angle, side - 0.06) + 0.2
        });
        let mut bench = bench();
        bench.import("front", &scan(|angle| length(&mounts[0], angle, side)));
        bench.import("rear", &scan(|angle| length(&mounts[1], angle, side)));
        bench.import("sonars", &sonars(echo));
        let scan = merged(&mut bench).expect("a scan");
        for (beam, range) in scan.ranges.iter().enumerate() {
            let angle = scan.angle(beam);
            let (sin, cos) = angle.sin_cos();
            let end = f64::from(range.min(scan.range_max));
            let places = (0..500).map(|step| 0.23 + 0.01 * f64::from(step)).take_while(|at| *at < end - 0.11);
            // Of a beam that is unknown there is no place.
            for at in places.filter(|_| !range.is_nan()) {
                // Up to the distance of two places that are looked at.
                let mut near = [-0.08, 0.0, 0.08].into_iter().map(|more| at + more);
                let is_looked_at = near.any(|at| is_visible(&Pose2D::new(at * cos, at * sin, 0.0)));
                prop_assert!(is_looked_at, "beam {beam} at {at} m of {end} m, the post at {x}, {y}");
            }
            if range.is_finite() && angle.abs() > 0.3 {
                let post = length(&Pose2D::ORIGIN, angle, side + 0.03);
                prop_assert!(end > post - 0.3 - 0.03, "{end} m, and the post at {post} m");
            }
        }
    }
}
