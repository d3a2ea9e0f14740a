//! The head: it turns at the wished rate, and turns on as little as possible after the wish ends.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::{Head, Look};

fn bench_with_head_at(pan: f64, tilt: f64) -> Bench<Head> {
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
    bench.check().expect("no fault").ready
}

fn commanded(bench: &mut Bench<Head>) -> PanTilt {
    bench.iterate().expect("no fault");
    bench.commanded("head").expect("a command")
}

#[test]
fn it_is_ready_while_there_is_a_wish_and_the_position_of_the_head_is_known() {
    let mut bench = bench_with_head_at(0.0, 0.0);
    assert!(!ready(&mut bench));
    bench.set("want", Look::at(0.0, 0.1));
    assert!(ready(&mut bench));
    bench.set_now(ms(501));
    assert!(!ready(&mut bench), "the wish has expired");
    bench.set("want", Look::at(0.0, 0.1));
    bench.retract("pan_tilt");
    assert!(!ready(&mut bench), "the position of the head is unknown");
}

#[test]
fn it_commands_a_position_with_a_small_lead_at_the_wished_speed() {
    let mut bench = bench_with_head_at(0.5, -0.2);
    bench.set("want", Look::at(-0.4, 0.2));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.4, 0.2));
    assert!(head.pan < 0.5 && head.pan > 0.4, "to the right, and not far");
    assert!(head.tilt > -0.2 && head.tilt < -0.1, "down, and not far");
}

#[test]
fn an_axis_without_a_wish_is_held() {
    let mut bench = bench_with_head_at(0.5, -0.2);
    bench.set("want", Look::at(0.4, 0.0));
    assert_eq!(commanded(&mut bench).tilt_velocity, 0.0);
    bench.set_now(ms(501));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.0, 0.0));
}

#[test]
fn a_wish_does_not_exceed_the_limit() {
    let mut bench = bench_with_head_at(0.0, 0.0);
    bench.set("want", Look::at(9.0, -9.0));
    let head = commanded(&mut bench);
    assert_eq!((head.pan_velocity, head.tilt_velocity), (0.8, 0.8));
}
