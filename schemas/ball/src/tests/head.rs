//! The two schemas that turn the head: which one the ball makes READY, and which position they command.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};
use crate::{Search, Track};

fn head_at(pan: f64, tilt: f64) -> PanTilt {
    PanTilt {
        pan,
        tilt,
        ..PanTilt::default()
    }
}

fn track(ball: Ball, head: PanTilt) -> PanTilt {
    let mut bench = Bench::<Track>::new();
    bench.import("ball", &ball);
    bench.import("pan_tilt", &head);
    assert!(bench.check().expect("no fault").ready);
    bench.iterate().expect("no fault");
    bench.commanded("head").expect("a command")
}

#[test]
fn r3_exactly_one_of_track_and_search_is_ready() {
    for (ball, known) in [
        (seen(0.2, 2.0), true),
        (unseen(0.2, 2.0, 0.2), true),
        (unseen(0.2, 2.0, 0.4), false),
        (unseen(0.0, 0.0, 0.0), false),
    ] {
        let mut track = Bench::<Track>::new();
        let mut search = Bench::<Search>::new();
        track.import("ball", &ball);
        search.import("ball", &ball);
        assert!(
            !track.check().expect("no fault").ready,
            "the position of the head is unknown"
        );
        assert!(
            !search.check().expect("no fault").ready,
            "the position of the head is unknown"
        );
        track.import("pan_tilt", &PanTilt::default());
        search.import("pan_tilt", &PanTilt::default());
        assert_eq!(track.check().expect("no fault").ready, known);
        assert_eq!(search.check().expect("no fault").ready, !known);
        for now in [seconds(0.9), seconds(1.1)] {
            track.set_now(now);
            search.set_now(now);
            let old = now > seconds(1.0);
            assert_eq!(track.check().expect("no fault").ready, known && !old);
            assert_eq!(search.check().expect("no fault").ready, !known && !old);
        }
    }
}

#[test]
fn track_turns_to_the_ball_faster_if_the_error_is_larger() {
    let ball = Ball {
        elevation: -0.2,
        ..seen(0.3, 2.0)
    };
    let command = track(ball, head_at(0.2, 0.0));
    assert_eq!((command.pan, command.tilt), (0.3, 0.2));
    near(command.pan_velocity, 0.4, 1e-9);
    near(command.tilt_velocity, 0.8, 1e-9);
    let command = track(ball, head_at(-1.0, 0.2));
    assert_eq!(command.pan_velocity, 1.5, "the highest turn rate");
    assert_eq!(command.tilt_velocity, 0.0, "an axis without an error is held");
}

#[test]
fn errors_within_the_tolerance_do_not_turn_the_head() {
    let command = track(seen(0.300, 2.0), head_at(0.305, 0.005));
    assert_eq!((command.pan_velocity, command.tilt_velocity), (0.0, 0.0));
}

/// Runs a search with a head that follows. Returns the position commanded at each tenth of a second.
fn sweep(bearing: f64, steps: usize, stuck: bool) -> Vec<f64> {
    let mut bench = Bench::<Search>::new();
    bench.set("sweep", 1.0);
    let mut pan = 0.0;
    (0..steps)
        .map(|step| {
            bench.set_now(seconds(0.1 * step as f64));
            bench.import("ball", &unseen(bearing, 2.0, 1.0));
            bench.import("pan_tilt", &head_at(pan, 0.0));
            assert!(bench.check().expect("no fault").ready);
            bench.iterate().expect("no fault");
            let command: PanTilt = bench.commanded("head").expect("a command");
            let stride = 0.1 * command.pan_velocity;
            if !stuck {
                pan += (command.pan - pan).clamp(-stride, stride);
            }
            command.pan
        })
        .collect()
}

/// Removes repetitions.
fn legs(mut sides: Vec<f64>) -> Vec<f64> {
    sides.dedup();
    sides
}

#[test]
fn search_starts_on_the_side_of_the_last_ball_and_sweeps() {
    assert_eq!(legs(sweep(0.4, 60, false)), [1.0, -1.0, 1.0]);
    assert_eq!(legs(sweep(-0.4, 60, false)), [-1.0, 1.0, -1.0]);
}

#[test]
fn search_turns_back_after_a_time_if_the_head_does_not_move() {
    assert_eq!(legs(sweep(0.4, 70, true)), [1.0, -1.0]);
}

#[test]
fn each_search_starts_on_the_side_of_the_last_ball() {
    let mut bench = Bench::<Search>::new();
    bench.import("pan_tilt", &PanTilt::default());
    let mut side = |ball: Ball| {
        bench.import("ball", &ball);
        bench.check().expect("no fault").ready.then(|| {
            bench.iterate().expect("no fault");
            bench.commanded::<PanTilt>("head").expect("a command").pan
        })
    };
    let first = side(unseen(0.5, 2.0, 1.0)).expect("the ball is lost");
    assert!(first > 0.0);
    assert_eq!(
        side(unseen(-0.5, 2.0, 1.0)),
        Some(first),
        "a search keeps its side"
    );
    assert_eq!(side(seen(-0.5, 2.0)), None);
    assert_eq!(side(unseen(-0.5, 2.0, 1.0)), Some(-first));
}
