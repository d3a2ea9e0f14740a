//! The father: when it is READY, and its arbitration of a group for which there is no wish.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::{Drive, Look, Pilot};

fn ready(bench: &mut Bench<Pilot>) -> bool {
    bench.check().expect("it checks").ready
}

#[test]
fn it_is_ready_while_anything_is_wanted_of_either() {
    let mut bench = Bench::<Pilot>::new();
    assert!(!ready(&mut bench), "nobody has wanted anything yet");
    bench.import("drive", &Drive::at(Twist::ZERO));
    bench.import("look", &Look::NONE);
    assert!(ready(&mut bench), "to stand still");
    bench.set_now(ms(501));
    assert!(!ready(&mut bench), "whoever wanted it is gone");
    bench.import("look", &Look::at(0.1, 0.0));
    assert!(ready(&mut bench), "to look around");
}

#[test]
fn it_wakes_both() {
    let mut bench = Bench::<Pilot>::new();
    bench.iterate().expect("it wakes them");
    assert_eq!(bench.awake_children(), ["base", "head"]);
}

#[test]
fn r3_where_nothing_is_wanted_the_base_stands_and_the_head_is_left_alone() {
    let mut bench = Bench::<Pilot>::new();
    bench.set_child("base", State::Checking);
    bench.set_child("head", State::Checking);
    let base = bench.arbitrate("base").expect("it decides");
    assert_eq!(base.child.as_deref(), Some("base"));
    let head = bench.arbitrate("head").expect("it decides");
    assert_eq!(
        (head.child, head.reason.as_str()),
        (None, "nothing is wanted of the head")
    );
}
