//! What is near slows commands, and what is nearer refuses them.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{self, Point2D};

use super::{Occupied, Zones};

/// A scan of three beams ahead, 10° apart, with this range.
fn scan(range: f32) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -0.1745,
        angle_increment: 0.1745,
        range_min: 0.02,
        range_max: 8.0,
        ..LaserScan::default()
    };
    for _ in 0..3 {
        scan.ranges.push(range).expect("few beams");
    }
    scan.state_last_angle();
    scan
}

/// Stops before what is up to 0.4 m ahead, and is slow in a circle of 1 m.
fn guard() -> Bench<Zones> {
    let mut bench = Bench::new();
    let corners = [(0.4, 0.3), (0.0, 0.3), (0.0, -0.3), (0.4, -0.3)];
    let points = corners.map(|(x, y)| Point2D { x, y });
    bench.set(
        "stop",
        types::Footprint {
            radius: 0.0,
            points: Seq::from_slice(&points).expect("few corners"),
        },
    );
    bench.set("slow", types::Footprint::circle(1.0));
    bench.set("slow_speed", 0.2);
    bench.set("slow_turn", 0.5);
    bench.set("min_points", 2_u32);
    bench.awake().expect("it wakes");
    bench
}

/// Judges a command after a scan, and returns what is left of it.
fn left_of(bench: &mut Bench<Zones>, scan: &LaserScan, command: Twist) -> Result<Twist, String> {
    bench.import("laser", scan);
    bench.iterate().expect("it iterates");
    let state: Occupied = bench.exported("occupied").ok_or("no state")?;
    let age = Duration::ZERO;
    match Zones::judge(&state, age, &command) {
        Ok(()) => Ok(command),
        Err(reason) => {
            let limited = Zones::limit(&state, age, &command).ok_or(reason)?;
            Zones::judge(&state, age, &limited).map(|()| limited)
        }
    }
}

#[test]
fn r18_the_nearer_something_is_the_less_is_left_of_a_command() {
    let mut guard = guard();
    let fast = Twist::planar(0.8, 0.4);
    assert_eq!(left_of(&mut guard, &scan(2.0), fast), Ok(fast));
    let slow = left_of(&mut guard, &scan(0.9), fast).expect("it is slowed");
    assert!(
        (slow.linear.x - 0.2).abs() < 1e-9 && (slow.angular.z - 0.1).abs() < 1e-9,
        "the same curve"
    );
    let spin = Twist::planar(0.0, -2.0);
    let slow = left_of(&mut guard, &scan(0.9), spin).expect("it is slowed");
    assert!((slow.angular.z + 0.5).abs() < 1e-9);
    let gentle = Twist::planar(0.1, 0.0);
    assert_eq!(left_of(&mut guard, &scan(0.9), gentle), Ok(gentle));
    let refused = left_of(&mut guard, &scan(0.3), gentle).expect_err("it is too near");
    assert_eq!(refused, "3 points are in the zone `stop`");
    assert_eq!(left_of(&mut guard, &scan(0.3), Twist::ZERO), Ok(Twist::ZERO));
}

#[test]
fn fewer_points_than_stated_occupy_no_zone() {
    let mut guard = guard();
    let mut single = scan(2.0);
    single.ranges.as_mut_slice()[1] = 0.3;
    let fast = Twist::planar(0.8, 0.0);
    assert_eq!(left_of(&mut guard, &single, fast), Ok(fast));
}

#[test]
fn r18_without_a_scan_that_measures_and_is_of_now_there_is_no_state() {
    let mut guard = guard();
    let fast = Twist::planar(0.8, 0.0);
    assert!(left_of(&mut guard, &scan(2.0), fast).is_ok());
    assert_eq!(
        left_of(&mut guard, &scan(f32::NAN), fast),
        Err("no state".to_owned())
    );
    assert!(left_of(&mut guard, &scan(2.0), fast).is_ok());
    guard.set_now(Duration::from_secs(1));
    guard.iterate().expect("it iterates");
    assert_eq!(guard.exported::<Occupied>("occupied"), None, "the scan is old");
}

#[test]
fn a_zone_that_encloses_nothing_is_a_problem() {
    let mut bench = Bench::<Zones>::new();
    let points = Seq::from_slice(&[Point2D { x: 1.0, y: 0.0 }]).expect("few corners");
    bench.set("slow", types::Footprint { radius: 0.0, points });
    let problems = bench.inspect().expect("it inspects");
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert_eq!(problems[0].modulation, "slow");
}
