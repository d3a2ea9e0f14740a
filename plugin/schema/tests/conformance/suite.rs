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
    describes_itself(table);
    is_not_ready_without_a_scan(table);
    is_ready_while_an_obstacle_is_in_its_area(table);
    stops_the_base(table);
    a_refused_command_is_no_fault(table);
    sleeps_and_awakes_again(table);
    survives_a_scan_with_a_wrong_length(table);
    refuses_null_pointers(table);
}

fn describes_itself(table: &'static raw::Schema) {
    let bench = bench(table);
    let about = bench.description();
    assert_eq!(
        (&*about.name, about.kind, about.period_ns),
        ("stop", Kind::Motor, 200_000_000)
    );
    assert!(!about.doc.is_empty());
    let roles: Vec<(&str, &Role)> = about.ports.iter().map(|port| (&*port.name, &port.role)).collect();
    assert!(roles.contains(&("laser", &Role::Import)));
    assert!(roles.contains(&("base", &Role::Actuator)));
    let laser = about
        .ports
        .iter()
        .find(|port| port.name == "laser")
        .expect("laser");
    assert!(laser.value_type.same_as(&LaserScan::describe()));
}

fn is_not_ready_without_a_scan(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.awake().expect("awake");
    assert!(!bench.check().expect("no fault").ready);
}

fn is_ready_while_an_obstacle_is_in_its_area(table: &'static raw::Schema) {
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
        "REP-117: minus infinity is too close to measure"
    );
    bench.import("laser", &scan(2.0));
    bench.set("ahead", 2.5);
    assert!(
        bench.check().expect("no fault").ready,
        "`ahead` does not change the area"
    );
    bench.set("half_width", 0.7);
    bench.set("ahead", 0.6);
    assert!(
        !bench.check().expect("no fault").ready,
        "an obstacle beside the area counts"
    );
}

fn stops_the_base(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.import("laser", &scan(0.5));
    bench.iterate().expect("no fault");
    assert_eq!(bench.commanded("base"), Some(Twist::ZERO));
}

fn a_refused_command_is_no_fault(table: &'static raw::Schema) {
    let mut bench = bench(table);
    bench.set_authority(false);
    bench.iterate().expect("a refusal is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), None);
}

fn sleeps_and_awakes_again(table: &'static raw::Schema) {
    let mut bench = bench(table);
    for _ in 0..3 {
        bench.awake().expect("awake");
        bench.import("laser", &scan(0.5));
        assert!(bench.check().expect("no fault").ready);
        bench.iterate().expect("no fault");
        bench.sleep().expect("sleep");
    }
}

fn survives_a_scan_with_a_wrong_length(table: &'static raw::Schema) {
    let mut bench = bench(table);
    // The bytes of a scan that states 2^32 - 1 ranges.
    let mut words = Words([u32::MAX; size_of::<LaserScan>() / 4]);
    words.0[..16].fill(0);
    // SAFETY: as many bytes as a scan has, aligned for it; every pattern of them is a valid scan.
    let scan = unsafe { (&raw const words).cast::<LaserScan>().read() };
    bench.import("laser", &scan);
    assert!(!bench.check().expect("no fault").ready);
}

#[repr(C, align(8))]
struct Words([u32; size_of::<LaserScan>() / 4]);

fn refuses_null_pointers(table: &'static raw::Schema) {
    use core::ptr::null_mut;
    let (Some(create), Some(iterate), Some(check)) = (table.create, table.iterate, table.check) else {
        panic!("the table has all three")
    };
    // SAFETY: these calls check for null before anything else.
    unsafe {
        assert!(create(table, core::ptr::null(), null_mut()).is_null());
        assert_eq!(iterate(null_mut(), null_mut()), raw::BAD_ARGUMENT);
        assert_eq!(check(null_mut(), null_mut(), null_mut()), raw::BAD_ARGUMENT);
    }
}
