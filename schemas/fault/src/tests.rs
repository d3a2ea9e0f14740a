//! Schemas do nothing wrong without a request, and cause the requested fault in the requested call.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::{Device, Eye, Motor};

fn text(text: &str) -> Text<16> {
    Text::try_from(text).expect("the text fits")
}

#[test]
fn without_a_request_a_motor_schema_is_ready_periodically_and_causes_no_fault() {
    let mut bench = Bench::<Motor>::new();
    bench.unbind("needs");
    bench.set("off", 1.0);
    bench.set("speed", 0.2);
    assert!(bench.check().expect("the check succeeds").ready);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::planar(0.2, 0.0)));
    bench.set_now(Duration::from_millis(1500));
    assert!(!bench.check().expect("the check succeeds").ready);
    assert_eq!(bench.exported::<u64>("misdeeds"), None);
}

#[test]
fn a_fault_is_caused_only_in_the_requested_call() {
    let mut bench = Bench::<Motor>::new();
    bench.set("trouble", text("error"));
    bench.set("place", text("iterate"));
    assert!(bench.check().is_ok());
    assert!(bench.iterate().is_err());
    bench.set("place", text("check"));
    assert!(bench.check().is_err());
    bench.set("place", text("nowhere"));
    assert!(bench.check().is_ok() && bench.iterate().is_ok());
    bench.set("trouble", text("nonsense"));
    bench.set("place", text("check"));
    assert!(bench.check().is_ok());
}

#[test]
fn eyes_and_devices_cause_requested_faults() {
    let mut eye = Bench::<Eye>::new();
    eye.set("trouble", text("error"));
    assert!(eye.iterate().is_err());
    let mut device = Bench::<Device>::new();
    device.iterate().expect("no fault is requested");
    device.set("trouble", text("error"));
    assert!(device.iterate().is_err());
}
