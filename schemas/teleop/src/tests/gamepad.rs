//! The gamepad: the dead-man's button, a pad that goes and comes back, and what is no wish.

use jde_joy::Joy;
use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use super::ms;
use crate::Gamepad;

const ENABLE_BUTTON: usize = 9;
const TURBO_BUTTON: usize = 10;

fn joy(held: &[usize], axes: [f32; 4]) -> Joy {
    let buttons: Vec<i32> = (0..15).map(|number| i32::from(held.contains(&number))).collect();
    Joy {
        axes: Seq::from_slice(&axes).expect("it fits"),
        buttons: Seq::from_slice(&buttons).expect("it fits"),
        ..Joy::default()
    }
}

fn ready(bench: &mut Bench<Gamepad>) -> bool {
    bench.check().expect("the check succeeds").ready
}

/// A pad that was seen released.
fn bench() -> Bench<Gamepad> {
    let mut bench = Bench::new();
    hold(&mut bench, &[], [0.0; 4]);
    assert!(!ready(&mut bench));
    bench
}

fn hold(bench: &mut Bench<Gamepad>, buttons: &[usize], axes: [f32; 4]) {
    bench.import("joy", &joy(buttons, axes));
}

/// What it commands once it has accelerated.
fn commanded(bench: &mut Bench<Gamepad>) -> Twist {
    for step in 0..200 {
        bench.set_now(ms(50 * step));
        bench.iterate().expect("the iteration succeeds");
    }
    bench.commanded("base").expect("a command is sent")
}

#[test]
fn it_is_ready_while_the_button_is_held_and_only_then() {
    let mut bench = bench();
    hold(&mut bench, &[], [1.0; 4]);
    assert!(!ready(&mut bench), "a stick alone is no wish");
    hold(&mut bench, &[0, 1, 2, TURBO_BUTTON], [1.0; 4]);
    assert!(!ready(&mut bench), "another button");
    hold(&mut bench, &[ENABLE_BUTTON], [0.0; 4]);
    assert!(ready(&mut bench), "a wish to stand still");
    hold(&mut bench, &[], [0.0, 1.0, 0.0, 0.0]);
    assert!(!ready(&mut bench));
    assert_eq!(commanded(&mut bench), Twist::ZERO, "if it is forced nevertheless");
}

#[test]
fn the_sticks_are_speeds() {
    let mut bench = bench();
    hold(&mut bench, &[ENABLE_BUTTON], [0.5, 1.0, 0.0, 0.0]);
    assert_eq!(commanded(&mut bench), Twist::planar(0.5, 0.5));
    bench.set("enable_turbo_button", TURBO_BUTTON as i32);
    hold(&mut bench, &[TURBO_BUTTON], [0.5, 1.0, 0.0, 0.0]);
    bench.set("scale_linear_turbo", 0.8);
    assert!(ready(&mut bench), "the turbo button is a dead-man's button too");
    assert_eq!(commanded(&mut bench), Twist::planar(0.8, 0.5));
    bench.set("axis_linear", 3);
    bench.set("axis_angular", -1);
    bench.set("axis_linear_y", 2);
    bench.set("scale_linear", -0.3);
    hold(&mut bench, &[ENABLE_BUTTON], [1.0, 1.0, -1.0, 0.5]);
    let twist = commanded(&mut bench);
    assert_eq!(
        (twist.linear.x, twist.linear.y, twist.angular.z),
        (-0.15, 0.3, 0.0)
    );
}

#[test]
fn a_speed_increases_step_by_step_and_decreases_at_once() {
    let mut bench = bench();
    bench.set("acceleration", 1.0);
    hold(&mut bench, &[ENABLE_BUTTON], [0.0, 1.0, 0.0, 0.0]);
    let step = |bench: &mut Bench<Gamepad>, time| {
        bench.set_now(ms(time));
        bench.iterate().expect("the iteration succeeds");
        bench
            .commanded::<Twist>("base")
            .expect("a command is sent")
            .linear
            .x
    };
    assert!((step(&mut bench, 1000) - 0.05).abs() < 1e-9);
    assert!((step(&mut bench, 1050) - 0.1).abs() < 1e-9);
    hold(&mut bench, &[ENABLE_BUTTON], [0.0; 4]);
    assert_eq!(step(&mut bench, 1100), 0.0);
}

#[test]
fn a_pad_that_is_gone_is_a_release_and_needs_the_button_anew() {
    let mut bench = bench();
    let ahead = [0.0, 1.0, 0.0, 0.0];
    hold(&mut bench, &[ENABLE_BUTTON], ahead);
    assert!(ready(&mut bench));
    bench.retract("joy");
    assert!(!ready(&mut bench), "unplugged, or its driver is dead");
    assert_eq!(commanded(&mut bench), Twist::ZERO);
    hold(&mut bench, &[ENABLE_BUTTON], ahead);
    assert!(!ready(&mut bench), "it came back with the button held");
    assert_eq!(commanded(&mut bench), Twist::ZERO);
    hold(&mut bench, &[], ahead);
    assert!(!ready(&mut bench));
    hold(&mut bench, &[ENABLE_BUTTON], ahead);
    assert!(ready(&mut bench), "pressed anew");
}

#[test]
fn a_button_that_is_held_from_the_start_does_not_drive() {
    let mut bench = Bench::<Gamepad>::new();
    hold(&mut bench, &[ENABLE_BUTTON], [1.0; 4]);
    assert!(!ready(&mut bench));
    let mut bench = self::bench();
    hold(&mut bench, &[ENABLE_BUTTON], [1.0; 4]);
    assert!(ready(&mut bench));
    bench.sleep().expect("it sleeps");
    bench.awake().expect("it awakes");
    assert!(!ready(&mut bench), "nor one that is held through a sleep");
}

#[test]
fn a_position_that_is_not_finite_is_no_wish() {
    let mut bench = bench();
    for axes in [[f32::NAN, 0.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0, 0.0]] {
        hold(&mut bench, &[ENABLE_BUTTON], axes);
        assert!(!ready(&mut bench));
        assert_eq!(commanded(&mut bench), Twist::ZERO);
    }
    hold(&mut bench, &[ENABLE_BUTTON], [0.0, 0.0, f32::NAN, 0.0]);
    assert!(ready(&mut bench), "it reads no such axis");
    hold(&mut bench, &[ENABLE_BUTTON], [0.0, 9.0, 0.0, 0.0]);
    assert_eq!(
        commanded(&mut bench),
        Twist::planar(0.5, 0.0),
        "no axis goes beyond its end"
    );
}

#[test]
fn a_number_that_the_pad_does_not_have_is_said_once_and_drives_nothing() {
    let mut bench = Bench::<Gamepad>::new();
    bench.set("axis_linear", 5);
    bench.set("enable_turbo_button", 20);
    for held in [&[][..], &[ENABLE_BUTTON], &[]] {
        hold(&mut bench, held, [1.0; 4]);
        assert!(!ready(&mut bench));
    }
    let said: Vec<_> = bench.log().iter().map(|line| format!("{line:?}")).collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].contains("axis_linear is 5, and the pad has 4 axes"),
        "{said:?}"
    );
    assert!(
        said[0].contains("enable_turbo_button is 20, and the pad has 15 buttons"),
        "{said:?}"
    );
}
