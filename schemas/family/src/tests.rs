//! The rooms of the children, their overlap, and the order in which the father declares them.

use jde_schema::bench::Bench;

use super::*;

/// A scan of 180 beams. The beam straight ahead reads `room`; the others read a wall at the side.
fn scan(room: f32) -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -core::f32::consts::FRAC_PI_2,
        angle_increment: 1_f32.to_radians(),
        range_max: 8.0,
        ..LaserScan::default()
    };
    scan.ranges.resize(180).fill(0.7);
    scan.ranges.as_mut_slice()[90] = room;
    scan.state_last_angle();
    scan
}

/// Which of the two children are READY with this much room.
fn ready(room: f32) -> (bool, bool) {
    let (mut first, mut second) = (Bench::<Hijo1>::new(), Bench::<Hijo2>::new());
    first.import("laser", &scan(room));
    second.import("laser", &scan(room));
    (
        first.check().expect("the check succeeds").ready,
        second.check().expect("the check succeeds").ready,
    )
}

#[test]
fn both_children_are_ready_from_4_5_to_5_metres() {
    for (room, expected) in [
        (0.99, (false, false)),
        (1.0, (false, true)),
        (4.49, (false, true)),
        (4.5, (true, true)),
        (5.0, (true, true)),
        (5.01, (true, false)),
        (8.0, (true, false)),
    ] {
        assert_eq!(ready(room), expected, "{room} m");
    }
}

#[test]
fn a_beam_without_a_return_counts_as_the_maximum_range() {
    assert_eq!(ready(f32::INFINITY), (true, false));
    assert_eq!(ready(f32::NEG_INFINITY), (false, false), "too near to measure");
    assert_eq!(ready(f32::NAN), (false, false), "no reading");
}

#[test]
fn without_a_scan_no_child_is_ready() {
    assert!(!Bench::<Hijo1>::new().check().expect("the check succeeds").ready);
    assert!(!Bench::<Hijo2>::new().check().expect("the check succeeds").ready);
    let mut bench = Bench::<Hijo1>::new();
    bench.import("laser", &LaserScan::default());
    assert!(
        !bench.check().expect("the check succeeds").ready,
        "a scan without beams"
    );
}

#[test]
fn the_first_child_is_fast_and_the_second_slow() {
    let (mut first, mut second) = (Bench::<Hijo1>::new(), Bench::<Hijo2>::new());
    first.iterate().expect("the iteration succeeds");
    second.iterate().expect("the iteration succeeds");
    assert_eq!(first.commanded("base"), Some(Twist::planar(0.2, 0.0)));
    assert_eq!(second.commanded("base"), Some(Twist::planar(0.1, 0.0)));
}

#[test]
fn r4_the_father_wakes_both_and_uses_the_priority_of_their_declaration() {
    let mut bench = Bench::<Padre>::new();
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.awake_children(), ["first", "second"]);
    assert_eq!(bench.policy("first"), None, "priority is the default");
    let groups: Vec<&str> = bench
        .description()
        .children
        .iter()
        .map(|child| &*child.group)
        .collect();
    assert_eq!(groups, ["base", "base"], "they compete");
}

#[test]
fn all_three_run_once_a_second() {
    let second = Duration::from_secs(1).as_nanos() as u64;
    assert_eq!(Bench::<Padre>::new().description().period_ns, second);
    assert_eq!(Bench::<Hijo1>::new().description().period_ns, second);
    assert_eq!(Bench::<Hijo2>::new().description().period_ns, second);
}
