//! The conversions, at their limits.

use core::time::Duration;

use jde_player::{Mount, Power, Scan};
use jde_schema::prelude::*;

use crate::convert;

#[test]
fn ranges_are_those_of_rep_117() {
    let range = |metres: f64| convert::range(metres, 0.1, 8.0);
    assert_eq!((range(0.1), range(7.5)), (0.1, 7.5));
    assert_eq!((range(8.0), range(f64::INFINITY)), (f32::INFINITY, f32::INFINITY));
    assert_eq!((range(0.05), range(0.0)), (f32::NEG_INFINITY, f32::NEG_INFINITY));
    assert!(range(-1.0).is_nan() && range(f64::NAN).is_nan() && range(f64::NEG_INFINITY).is_nan());
}

#[test]
fn too_many_beams_are_reduced_to_the_nearest_of_each_group() {
    let mut ranges = vec![5.0; 2000];
    (ranges[1000], ranges[1001]) = (f64::NAN, 2.0);
    let sweep = Scan {
        angle_min: -1.0,
        angle_max: 0.999,
        ranges,
        ..Scan::default()
    };
    let mut scan = Box::new(LaserScan::default());
    convert::fill_scan(&mut scan, &sweep, 6.0);
    assert_eq!(
        (scan.ranges.len(), scan.ranges[500], scan.ranges[0]),
        (1000, 2.0, 5.0)
    );
    assert_eq!(
        scan.range_max, 6.0,
        "the default, because the server reports none"
    );
    let angle = scan.angle(500);
    assert!((angle - (-1.0 + 1000.5 * 0.001)).abs() < 1e-4, "{angle}");
    assert!((scan.angle_max - 0.9985).abs() < 1e-4);
}

#[test]
fn a_scan_without_beams_is_empty() {
    let mut scan = Box::new(LaserScan::default());
    convert::fill_scan(&mut scan, &Scan::default(), 6.0);
    assert!(scan.ranges.is_empty() && scan.angle_increment.is_finite());
}

#[test]
fn bumpers_without_places_are_front_bumpers_and_none_is_lost() {
    let mut states = [false; 10];
    states[9] = true;
    let bumpers = convert::bumpers(Duration::ZERO, &states, &[], false);
    let pressed: Vec<bool> = bumpers.front.iter().map(|flag| flag.get()).collect();
    assert_eq!(pressed, [false, false, false, false, false, false, false, true]);
    let behind = [Mount {
        x: -0.1,
        y: 0.0,
        yaw: 0.0,
    }];
    let bumpers = convert::bumpers(Duration::ZERO, &[true], &behind, true);
    assert!(bumpers.front.is_empty() && bumpers.rear[0].get() && bumpers.stalled.get());
}

#[test]
fn a_battery_is_converted_to_amperes_and_ampere_hours() {
    let power = Power {
        volts: Some(12.0),
        watts: Some(-24.0),
        joules: Some(86_400.0),
        charging: Some(1),
        percent: None,
    };
    let battery = convert::battery(Duration::ZERO, &power);
    assert_eq!(
        (battery.current, battery.charge, battery.power_supply_status),
        (-2.0, 2.0, 1)
    );
    assert!(battery.percentage.is_nan());
}
