//! The base: the dead-man's switch, and the limits.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::{Base, Drive};

fn ready(bench: &mut Bench<Base>) -> bool {
    bench.check().expect("no fault").ready
}

fn commanded(bench: &mut Bench<Base>) -> Twist {
    bench.iterate().expect("no fault");
    bench.commanded("base").expect("a command")
}

fn set_wish(bench: &mut Bench<Base>, linear: f64, angular: f64) {
    bench.set("want", Drive::at(Twist::planar(linear, angular)));
}

#[test]
fn it_is_ready_while_there_is_a_wish_also_to_stand_still() {
    let mut bench = Bench::<Base>::new();
    assert!(!ready(&mut bench), "there is no wish");
    set_wish(&mut bench, 0.0, 0.0);
    assert!(ready(&mut bench), "a wish to stand still");
    bench.set("want", Drive::NONE);
    assert!(!ready(&mut bench));
}

#[test]
fn a_wish_that_is_not_renewed_counts_for_half_a_second() {
    let mut bench = Bench::<Base>::new();
    set_wish(&mut bench, 0.2, 0.0);
    bench.set_now(ms(500));
    assert!(ready(&mut bench));
    bench.set_now(ms(501));
    assert!(!ready(&mut bench), "the wish has expired");
    set_wish(&mut bench, 0.2, 0.0);
    assert!(ready(&mut bench), "the wish is renewed");
    bench.set("patience", 0.1);
    bench.set_now(ms(602));
    assert!(!ready(&mut bench), "the patience is modulated");
}

#[test]
fn without_a_valid_wish_it_commands_zero_speed() {
    let mut bench = Bench::<Base>::new();
    assert_eq!(commanded(&mut bench), Twist::ZERO);
    set_wish(&mut bench, 0.2, 0.1);
    bench.set_now(ms(501));
    assert_eq!(commanded(&mut bench), Twist::ZERO);
}

#[test]
fn a_wish_does_not_exceed_the_limits() {
    let mut bench = Bench::<Base>::new();
    let fast = Twist {
        linear: Vector3 {
            x: 9.0,
            y: -9.0,
            z: 0.0,
        },
        ..Twist::planar(0.0, -9.0)
    };
    for step in 0..100 {
        bench.set_now(ms(50 * step));
        bench.set("want", Drive::at(fast));
        let twist = commanded(&mut bench);
        assert!(twist.linear.x <= 0.5 && twist.linear.y >= -0.5 && twist.angular.z >= -1.0);
    }
    let twist = commanded(&mut bench);
    assert_eq!(
        (twist.linear.x, twist.linear.y, twist.angular.z),
        (0.5, -0.5, -1.0)
    );
    bench.set("fast", 0.1);
    bench.set("turn", 0.2);
    let twist = commanded(&mut bench);
    assert_eq!(
        (twist.linear.x, twist.linear.y, twist.angular.z),
        (0.1, -0.1, -0.2)
    );
}

#[test]
fn it_accelerates_step_by_step_and_slows_down_at_once() {
    let mut bench = Bench::<Base>::new();
    let mut speeds = Vec::new();
    for step in 0..20 {
        bench.set_now(ms(50 * step));
        set_wish(&mut bench, 0.3, 0.0);
        speeds.push(commanded(&mut bench).linear.x);
    }
    let steps: Vec<_> = speeds.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(
        steps.iter().all(|step| (0.0..0.0301).contains(step)),
        "{speeds:?}"
    );
    assert!((speeds[0] - 0.03).abs() < 1e-9 && (speeds[19] - 0.3).abs() < 1e-9);
    set_wish(&mut bench, 0.1, 0.0);
    assert_eq!(commanded(&mut bench).linear.x, 0.1, "slower at once");
    bench.set_now(ms(1000));
    set_wish(&mut bench, -0.3, 0.0);
    assert!(
        (commanded(&mut bench).linear.x + 0.03).abs() < 1e-9,
        "backward from zero speed"
    );
}

#[test]
fn after_a_pause_it_accelerates_from_zero_speed() {
    let mut bench = Bench::<Base>::new();
    for step in 0..20 {
        bench.set_now(ms(50 * step));
        set_wish(&mut bench, 0.3, 0.0);
        commanded(&mut bench);
    }
    bench.set_now(ms(3000));
    set_wish(&mut bench, 0.3, 0.0);
    assert!((commanded(&mut bench).linear.x - 0.03).abs() < 1e-9);
}
