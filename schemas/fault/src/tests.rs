//! Schemas do nothing wrong without a request, and cause the requested fault in the requested call.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::{Device, Eye, Motor};

fn word(word: &str) -> Text<16> {
    Text::try_from(word).expect("it is short")
}

#[test]
fn who_is_not_told_drives_by_turns_and_does_nothing_wrong() {
    let mut bench = Bench::<Motor>::new();
    bench.unbind("needs");
    bench.set("off", 1.0);
    bench.set("speed", 0.2);
    assert!(bench.check().expect("it checks").ready);
    bench.iterate().expect("it iterates");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::planar(0.2, 0.0)));
    bench.set_now(Duration::from_millis(1500));
    assert!(!bench.check().expect("it checks").ready);
    assert_eq!(bench.exported::<u64>("misdeeds"), None);
}

#[test]
fn trouble_is_made_in_the_call_that_was_named_and_in_no_other() {
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
fn eyes_and_devices_fail_as_they_are_told() {
    let mut eye = Bench::<Eye>::new();
    eye.set("trouble", word("error"));
    assert!(eye.iterate().is_err());
    let mut device = Bench::<Device>::new();
    device.iterate().expect("nobody told it to");
    device.set("trouble", word("error"));
    assert!(device.iterate().is_err());
}
