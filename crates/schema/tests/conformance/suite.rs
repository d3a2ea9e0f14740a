//! The suite that every `stop` must pass, in any language.

use jde_abi::describe::{Kind, Role};
use jde_abi::raw;
use jde_schema::bench::{Bench, Foreign};
use jde_schema::prelude::*;

/// Returns a scan with one beam straight ahead and one far to each side.
fn scan(ahead: f32) -> LaserScan {
    let right_angle = core::f32::consts::FRAC_PI_2;
    LaserScan {
        angle_min: -right_angle,
        angle_max: right_angle,
        angle_increment: right_angle,
        range_min: 0.1,
        range_max: 8.0,
        ranges: Seq::from_slice(&[0.5, ahead, 0.5]).expect("they fit"),
        ..LaserScan::default()
    }
}

fn bench(table: &'static raw::Schema) -> Bench<Foreign> {
    // SAFETY: the table of a plugin under test, which stays loaded.
    unsafe { Bench::foreign(table) }.expect("an instance")
}

/// Runs the whole suite.
pub(crate) fn stop_conforms(table: &'static raw::Schema) {
    it_describes_itself(table);
    it_is_not_ready_without_a_scan(table);
    it_is_ready_while_something_stands_in_its_area(table);
    it_stops_the_base(table);
    it_may_be_refused(table);
    it_sleeps_and_awakes_again(table);
    it_survives_scans_that_lie(table);
    it_refuses_pointers_to_nothing(table);
}

fn it_describes_itself(table: &'static raw::Schema) {
    let bench = bench(table);
    let about = bench.description();
    assert_eq!(
        (&*about.name, about.kind, about.period_ns),
        ("stop", Kind::Motor, 200_000_000)
    );
    assert!(!about.doc.is_empty());
    let roles: Vec<(&str, &Role)> = about.ports.iter().map(|port| (&*port.name, &port.role)).collect();
    assert!(roles.contains(&("laser", &Role::Import { trigger: true })));
    assert!(roles.contains(&("base", &Role::Actuator)));
    let laser = about
        .ports
        .iter()
        .find(|port| port.name == "laser")
        .expect("laser");
    assert!(laser.value_type.same_as(&LaserScan::describe()));
}

fn it_is_not_ready_without_a_scan(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.awake().expect("awake");
    assert!(!bench.check().expect("no fault").ready);
}

fn it_is_ready_while_something_stands_in_its_area(table: &'static raw::Schema) {
    let mut bench = bench(table);
    for (ahead, ready) in [
        (2.0, false),
        (0.5, true),
        (0.61, false),
        (f32::INFINITY, false),
        (f32::NAN, false),
    ] {
        bench.import("laser", &scan(ahead));
        assert_eq!(bench.check().expect("no fault").ready, ready, "{ahead} m ahead");
    }
    bench.import("laser", &scan(f32::NEG_INFINITY));
    assert!(
        bench.check().expect("no fault").ready,
        "REP-117: too close to measure is close"
    );
    bench.import("laser", &scan(2.0));
    bench.set("ahead", 2.5);
    assert!(bench.check().expect("no fault").ready, "its area is modulated");
    bench.set("half_width", 0.7);
    bench.set("ahead", 0.6);
    assert!(
        !bench.check().expect("no fault").ready,
        "what stands beside is not ahead"
    );
}

fn it_stops_the_base(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.import("laser", &scan(0.5));
    bench.iterate().expect("no fault");
    assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
}

fn it_may_be_refused(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.set_authority(false);
    bench.iterate().expect("to be refused is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), None);
}

fn it_sleeps_and_awakes_again(table: &'static raw::Schema) {
    let mut bench = bench(table);
    for _ in 0..3 {
        bench.awake().expect("awake");
        bench.import("laser", &scan(0.5));
        assert!(bench.check().expect("no fault").ready);
        bench.iterate().expect("no fault");
        bench.sleep().expect("sleep");
    }
}

fn it_survives_scans_that_lie(table: &'static raw::Schema) {
    let mut bench = bench(table);
    // The bytes of a scan whose length states four thousand million ranges.
    let mut lie = Words([u32::MAX; size_of::<LaserScan>() / 4]);
    lie.0[..16].fill(0);
    // SAFETY: as many bytes, aligned, of which every pattern is a scan.
    let lie = unsafe { (&raw const lie).cast::<LaserScan>().read() };
    bench.import("laser", &lie);
    assert!(!bench.check().expect("no fault").ready);
}

#[repr(C, align(8))]
struct Words([u32; size_of::<LaserScan>() / 4]);

fn it_refuses_pointers_to_nothing(table: &'static raw::Schema) {
    use core::ptr::null_mut;
    let (Some(create), Some(iterate), Some(check)) = (table.create, table.iterate, table.check) else {
        panic!("all three are there")
    };
    // SAFETY: these calls check for null before anything else.
    unsafe {
        assert!(create(table, core::ptr::null(), null_mut()).is_null());
        assert_eq!(iterate(null_mut(), null_mut()), raw::BAD_ARGUMENT);
        assert_eq!(check(null_mut(), null_mut(), null_mut()), raw::BAD_ARGUMENT);
    }
}
