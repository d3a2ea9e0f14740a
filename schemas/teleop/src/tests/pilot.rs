//! The father: when it is READY, and its arbitration of a group for which there is no wish.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::{Drive, Look, Pilot};

fn ready(bench: &mut Bench<Pilot>) -> bool {
    bench.check().expect("no fault").ready
}

#[test]
fn it_is_ready_while_there_is_a_wish_for_base_or_head() {
    let mut bench = Bench::<Pilot>::new();
    assert!(!ready(&mut bench), "there is no wish");
    bench.import("drive", &Drive::at(Twist::ZERO));
    bench.import("look", &Look::NONE);
    assert!(ready(&mut bench), "a wish to stand still");
    bench.set_now(ms(501));
    assert!(!ready(&mut bench), "the wish has expired");
    bench.import("look", &Look::at(0.1, 0.0));
    assert!(ready(&mut bench), "a wish for the head");
}

#[test]
fn it_wakes_both_children() {
    let mut bench = Bench::<Pilot>::new();
    bench.iterate().expect("no fault");
    assert_eq!(bench.awake_children(), ["base", "head"]);
}

#[test]
fn r3_without_a_wish_the_base_stops_and_the_head_has_no_winner() {
    let mut bench = Bench::<Pilot>::new();
    bench.set_child("base", State::Checking);
    bench.set_child("head", State::Checking);
    let base = bench.arbitrate("base").expect("no fault");
    assert_eq!(base.child.as_deref(), Some("base"));
    let head = bench.arbitrate("head").expect("no fault");
    assert_eq!(
        (head.child, head.reason.as_str()),
        (None, "nothing is wanted of the head")
    );
}
