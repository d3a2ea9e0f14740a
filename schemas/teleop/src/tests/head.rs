//! The head: it turns at the wished rate, and turns on as little as possible after the wish ends.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::{Head, Look};

fn looking(pan: f64, tilt: f64) -> Bench<Head> {
    let mut bench = Bench::new();
    let now = PanTilt {
        pan,
        tilt,
        ..PanTilt::default()
    };
    bench.import("pan_tilt", &now);
    bench
}

fn ready(bench: &mut Bench<Head>) -> bool {
    bench.check().expect("it checks").ready
}

fn commanded(bench: &mut Bench<Head>) -> PanTilt {
    bench.iterate().expect("it turns");
    bench.commanded("head").expect("it commands")
}

#[test]
fn it_is_ready_while_something_is_wanted_and_the_head_is_heard() {
    let mut bench = looking(0.0, 0.0);
    assert!(!ready(&mut bench));
    bench.set("want", Look::at(0.0, 0.1));
    assert!(ready(&mut bench));
    bench.set_now(ms(501));
    assert!(!ready(&mut bench), "whoever wanted it is gone");
    bench.set("want", Look::at(0.0, 0.1));
    bench.retract("pan_tilt");
    assert!(!ready(&mut bench), "no word of the head");
}

#[test]
fn it_sends_the_head_a_little_ahead_of_where_it_looks_at_the_speed_that_is_wanted() {
    let mut bench = looking(0.5, -0.2);
    bench.set("want", Look::at(-0.4, 0.2));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.4, 0.2));
    assert!(head.pan < 0.5 && head.pan > 0.4, "to the right, and not far");
    assert!(head.tilt > -0.2 && head.tilt < -0.1, "down, and not far");
}

#[test]
fn an_axis_of_which_nothing_is_wanted_is_held() {
    let mut bench = looking(0.5, -0.2);
    bench.set("want", Look::at(0.4, 0.0));
    assert_eq!(commanded(&mut bench).tilt_velocity, 0.0);
    bench.set_now(ms(501));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.0, 0.0));
}

#[test]
fn no_wish_makes_it_faster_than_its_limit() {
    let mut bench = looking(0.0, 0.0);
    bench.set("want", Look::at(9.0, -9.0));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.8, 0.8));
}
