//! Schemas do nothing wrong without a request, and cause the requested fault in the requested call.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::{Device, Eye, Motor};

fn word(text: &str) -> Text<16> {
    Text::try_from(text).expect("at most 16 bytes")
}

#[test]
fn a_motor_without_a_request_is_ready_periodically_and_causes_no_fault() {
    let mut bench = Bench::<Motor>::new();
    bench.unbind("needs");
    bench.set("off", 1.0);
    bench.set("speed", 0.2);
    assert!(bench.check().expect("no fault").ready);
    bench.iterate().expect("no fault");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::planar(0.2, 0.0)));
    bench.set_now(Duration::from_millis(1500));
    assert!(!bench.check().expect("no fault").ready);
    assert_eq!(bench.exported::<u64>("misdeeds"), None);
}

#[test]
fn a_fault_is_caused_only_in_the_requested_call() {
    let mut bench = Bench::<Motor>::new();
    bench.set("trouble", word("error"));
    bench.set("place", word("iterate"));
    assert!(bench.check().is_ok());
    assert!(bench.iterate().is_err());
    bench.set("place", word("check"));
    assert!(bench.check().is_err());
    bench.set("place", word("nowhere"));
    assert!(bench.check().is_ok() && bench.iterate().is_ok());
    bench.set("trouble", word("nonsense"));
    bench.set("place", word("check"));
    assert!(bench.check().is_ok());
}

#[test]
fn eyes_and_devices_cause_the_requested_fault() {
    let mut eye = Bench::<Eye>::new();
    eye.set("trouble", word("error"));
    assert!(eye.iterate().is_err());
    let mut device = Bench::<Device>::new();
    device.iterate().expect("no fault is requested");
    device.set("trouble", word("error"));
    assert!(device.iterate().is_err());
}
