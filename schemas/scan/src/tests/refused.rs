//! Values and settings that contradict themselves are said in words, and are no freedom.

use super::*;

#[test]
fn a_floor_that_is_nearer_than_it_can_be_is_none() {
    for range in [0.01, f32::NEG_INFINITY] {
        let mut bench = bench();
        bench.import("cliff", &floor(range));
        assert_eq!(
            words(&mut bench),
            "`cliff`: it does not measure the floor",
            "{range}"
        );
    }
    let mut bench = bench();
    let mut far = floor(0.2);
    far.min_range = 0.1;
    bench.import("cliff", &far);
    assert!(words(&mut bench).starts_with("`cliff`: it measures from 0.1"));
}

#[test]
fn a_cliff_sensor_of_a_fixed_distance_tells_whether_the_floor_is_nearer_than_that() {
    let fixed = |distance: f32, range: f32| Range {
        min_range: distance,
        max_range: distance,
        ..floor(range)
    };
    for (range, is_cliff) in [(f32::NEG_INFINITY, false), (f32::INFINITY, true)] {
        let mut bench = bench();
        bench.import("cliff", &fixed(0.08, range));
        let scan = merged(&mut bench).expect("a scan");
        assert_eq!(toward(&scan, 0.0) < 0.22, is_cliff, "{range}");
    }
    let mut bench = bench();
    bench.import("cliff", &fixed(0.04, f32::NEG_INFINITY));
    assert!(words(&mut bench).starts_with("`cliff`: it notices what is nearer than 0.04"));
}

#[test]
fn a_ring_whose_numbers_contradict_each_other_ends_the_scan() {
    let said = |change: fn(&mut RangeRing)| {
        let mut bench = bench();
        let mut ring = sonars(1.0);
        change(&mut ring);
        bench.import("sonars", &ring);
        words(&mut bench)
    };
    assert_eq!(
        said(|ring| ring.ranges.push(0.3).expect("two")),
        "`sonars`: it states 1 poses and 2 ranges"
    );
    assert_eq!(
        said(|ring| ring.poses.as_mut_slice()[0].x = f64::NAN),
        "`sonars`: a pose of it is not finite"
    );
    assert_eq!(
        said(|ring| ring.field_of_view = f32::NAN),
        "`sonars`: its field of view is NaN rad"
    );
}

#[test]
fn a_setting_that_a_sensor_does_not_read_is_refused() {
    let default = Mounting::DEFAULT;
    let mount = Mounting {
        mount: Pose2D::new(0.1, 0.0, 0.0),
        ..default
    };
    let floor = Mounting {
        floor: 0.05,
        ..default
    };
    let most = Mounting {
        obstacle_max_range: 1.0,
        ..default
    };
    let view = Mounting {
        field_of_view: 1.0,
        ..default
    };
    let said = |entry: Entry| {
        let laser = Entry::new::<LaserScan>("sensors", "laser");
        let mut bench = Bench::<Merge>::with_lists(&[laser, entry]);
        let problems = bench.inspect().expect("it inspects").into_iter();
        problems
            .map(|problem| problem.words)
            .collect::<Vec<_>>()
            .join("; ")
    };
    let one = |settings: &Mounting| said(Entry::new::<Range>("sensors", "it").settings(settings));
    let ring = |settings: &Mounting| said(Entry::new::<RangeRing>("sensors", "it").settings(settings));
    let laser = |settings: &Mounting| said(Entry::new::<LaserScan>("sensors", "it").settings(settings));
    let bumpers = |settings: &Mounting| said(Entry::new::<Bumpers>("sensors", "it").settings(settings));
    for fine in [
        laser(&mount),
        one(&mount),
        one(&floor),
        ring(&most),
        bumpers(&view),
    ] {
        assert_eq!(fine, "");
    }
    for (words, name) in [
        (ring(&mount), "mount"),
        (bumpers(&mount), "mount"),
        (laser(&floor), "floor"),
        (bumpers(&floor), "floor"),
        (laser(&most), "obstacle_max_range"),
        (one(&view), "field_of_view"),
    ] {
        assert_eq!(words, format!("`it` does not read `{name}`: leave it out"));
    }
}
