//! The edges of the watched area, and readings that are not distances.

use jde_schema::bench::Bench;
use jde_schema::panel::{Color, Shape};

use super::*;

/// A scan of points (ahead, to the left) in metres. The beams between them have no return.
fn scan(points: &[(f64, f64)]) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: 1_f32.to_radians() / 4.0,
        range_min: 0.02,
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(721).fill(f32::INFINITY);
    for (x, y) in points {
        let beam = (y.atan2(*x) - f64::from(scan.angle_min)) / f64::from(scan.angle_increment);
        scan.ranges.as_mut_slice()[beam.round() as usize] = x.hypot(*y) as f32;
    }
    scan.state_last_angle();
    scan
}

fn ready(points: &[(f64, f64)]) -> bool {
    let mut bench = Bench::<Stop>::new();
    bench.import("laser", &scan(points));
    bench.check().expect("the check succeeds").ready
}

/// Whether the schema is READY for a reading straight ahead.
fn ready_at(reading: f32) -> bool {
    let mut bench = Bench::<Stop>::new();
    let mut scan = scan(&[]);
    scan.ranges.as_mut_slice()[360] = reading;
    bench.import("laser", &scan);
    bench.check().expect("the check succeeds").ready
}

#[test]
fn the_area_reaches_60_cm_ahead() {
    assert!(ready_at(0.599));
    assert!(!ready_at(0.601));
    assert!(ready(&[(2.0, 0.0), (0.5, 0.1)]), "the nearest counts");
}

#[test]
fn the_area_reaches_30_cm_to_each_side() {
    for side in [1.0, -1.0] {
        assert!(ready(&[(0.4, 0.29 * side)]));
        assert!(!ready(&[(0.4, 0.31 * side)]));
        assert!(!ready(&[(0.1, 0.59 * side)]), "near, but outside the width");
    }
}

#[test]
fn the_area_is_a_rectangle_and_not_a_disc() {
    assert!(ready(&[(0.59, 0.28)]), "0.65 m away, and inside");
}

#[test]
fn it_does_not_let_go_when_the_scan_ends_or_is_none() {
    let mut bench = Bench::<Stop>::new();
    let ready = |bench: &mut Bench<Stop>| bench.check().expect("the check succeeds").ready;
    assert!(ready(&mut bench), "before the first scan");
    let mut wrong = scan(&[]);
    wrong.angle_increment = 0.0;
    let mut zeros = scan(&[]);
    zeros.ranges.as_mut_slice().fill(0.0);
    for none in [LaserScan::default(), wrong, zeros] {
        bench.import("laser", &scan(&[]));
        assert!(!ready(&mut bench));
        bench.import("laser", &none);
        assert!(ready(&mut bench), "{:?}", none.measured());
    }
    bench.import("laser", &scan(&[]));
    assert!(!ready(&mut bench));
    bench.retract("laser");
    assert!(ready(&mut bench));
}

#[test]
fn an_area_into_which_no_beam_measures_anything_is_not_free() {
    let mut bench = Bench::<Stop>::new();
    let mut blind_ahead = scan(&[]);
    blind_ahead.ranges.as_mut_slice()[200..520].fill(f32::NAN);
    bench.import("laser", &blind_ahead);
    assert!(bench.check().expect("the check succeeds").ready);
    blind_ahead.ranges.as_mut_slice()[360] = 3.0;
    bench.import("laser", &blind_ahead);
    assert!(!bench.check().expect("the check succeeds").ready);
}

#[test]
fn special_readings_are_interpreted_as_in_rep_117() {
    assert!(ready_at(f32::NEG_INFINITY), "too near to measure counts as near");
    assert!(!ready_at(f32::INFINITY), "no return");
    assert!(!ready_at(f32::NAN), "no reading, and its neighbours see the area");
    assert!(!ready_at(-0.3));
    assert!(!ready_at(0.01), "below the minimum range");
}

#[test]
fn the_area_is_modulated() {
    let mut bench = Bench::<Stop>::new();
    bench.import("laser", &scan(&[(0.9, 0.45)]));
    assert!(!bench.check().expect("the check succeeds").ready);
    bench.set("ahead", 1.0);
    assert!(
        !bench.check().expect("the check succeeds").ready,
        "still outside the width"
    );
    bench.set("half_width", 0.5);
    assert!(bench.check().expect("the check succeeds").ready);
}

#[test]
fn it_commands_zero_speed() {
    let mut bench = Bench::<Stop>::new();
    bench.iterate().expect("the iteration succeeds without a scan");
    assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
}

#[test]
fn r7_without_authority_its_command_is_refused_without_a_fault() {
    let mut bench = Bench::<Stop>::new();
    bench.set_authority(false);
    bench.iterate().expect("a refusal is not a fault");
    assert_eq!(bench.commanded::<Twist>("base"), None);
}

#[test]
fn the_panel_shows_the_area_and_the_nearest_obstacle_in_it() {
    let mut bench = Bench::<Stop>::new();
    let area = |bench: &mut Bench<Stop>| {
        let panel = bench.draw().expect("the panel is drawn");
        let areas = panel.shapes("area").iter().find_map(|shape| match shape {
            Shape::Line {
                points,
                closed: true,
                stroke,
            } => Some((points[2], stroke.color)),
            _ => None,
        });
        (areas.expect("an area"), panel)
    };
    let ((corner, color), panel) = area(&mut bench);
    assert_eq!((corner, color), ([0.6, 0.3], Color::Ink(Ink::Bad)));
    assert_eq!(panel.texts(), ["the laser does not see the area"]);
    bench.import("laser", &scan(&[]));
    let ((_, color), panel) = area(&mut bench);
    assert_eq!(color, Color::Ink(Ink::Good));
    assert_eq!(panel.texts(), ["nothing in the area"]);
    bench.import("laser", &scan(&[(0.5, 0.0), (2.0, 1.0)]));
    assert!(bench.check().expect("the check succeeds").ready);
    let ((_, color), panel) = area(&mut bench);
    assert_eq!(color, Color::Ink(Ink::Bad));
    assert!((panel.value("nearest ahead") - 0.5).abs() < 1e-6);
    bench.set("ahead", 0.4);
    let ((corner, color), _) = area(&mut bench);
    assert_eq!((corner, color), ([0.4, 0.3], Color::Ink(Ink::Good)));
}
