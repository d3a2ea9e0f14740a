//! The two schemas that turn the head: which one the ball makes READY, and which position they command.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};
use crate::{Search, Track};

fn looking(pan: f64, tilt: f64) -> PanTilt {
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
    assert!(bench.check().expect("it checks").ready);
    bench.iterate().expect("it looks");
    bench.commanded("head").expect("it commands")
}

#[test]
fn r3_of_the_two_exactly_one_is_ready_whether_the_ball_is_here_or_lost() {
    for (ball, here) in [
        (seen(0.2, 2.0), true),
        (unseen(0.2, 2.0, 0.2), true),
        (unseen(0.2, 2.0, 0.4), false),
        (unseen(0.0, 0.0, 0.0), false),
    ] {
        let mut track = Bench::<Track>::new();
        let mut search = Bench::<Search>::new();
        track.import("ball", &ball);
        search.import("ball", &ball);
        assert!(!track.check().expect("it checks").ready, "no word of the head");
        assert!(!search.check().expect("it checks").ready, "no word of the head");
        track.import("pan_tilt", &PanTilt::default());
        search.import("pan_tilt", &PanTilt::default());
        assert_eq!(track.check().expect("it checks").ready, here);
        assert_eq!(search.check().expect("it checks").ready, !here);
        for now in [seconds(0.9), seconds(1.1)] {
            track.set_now(now);
            search.set_now(now);
            let old = now > seconds(1.0);
            assert_eq!(track.check().expect("it checks").ready, here && !old);
            assert_eq!(search.check().expect("it checks").ready, !here && !old);
        }
    }
}

#[test]
fn the_head_is_sent_to_where_the_ball_is_the_faster_the_farther_it_is_aside() {
    let ball = Ball {
        elevation: -0.2,
        ..seen(0.3, 2.0)
    };
    let command = track(ball, looking(0.2, 0.0));
    assert_eq!((command.pan, command.tilt), (0.3, 0.2));
    near(command.pan_velocity, 0.4, 1e-9);
    near(command.tilt_velocity, 0.8, 1e-9);
    let command = track(ball, looking(-1.0, 0.2));
    assert_eq!(command.pan_velocity, 1.5, "as fast as it may");
    assert_eq!(command.tilt_velocity, 0.0, "held where it is right");
}

#[test]
fn noise_does_not_turn_the_head() {
    let command = track(seen(0.300, 2.0), looking(0.305, 0.005));
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
            bench.import("pan_tilt", &looking(pan, 0.0));
            assert!(bench.check().expect("it checks").ready);
            bench.iterate().expect("it looks about");
            let command: PanTilt = bench.commanded("head").expect("it commands");
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
fn it_looks_first_where_the_ball_was_then_from_side_to_side() {
    assert_eq!(legs(sweep(0.4, 60, false)), [1.0, -1.0, 1.0]);
    assert_eq!(legs(sweep(-0.4, 60, false)), [-1.0, 1.0, -1.0]);
}

#[test]
fn a_head_that_does_not_get_there_is_turned_back_all_the_same() {
    assert_eq!(legs(sweep(0.4, 70, true)), [1.0, -1.0]);
}

#[test]
fn each_search_begins_anew() {
    let mut bench = Bench::<Search>::new();
    bench.import("pan_tilt", &PanTilt::default());
    let mut side = |ball: Ball| {
        bench.import("ball", &ball);
        bench.check().expect("it checks").ready.then(|| {
            bench.iterate().expect("it looks about");
            bench.commanded::<PanTilt>("head").expect("it commands").pan
        })
    };
    let left = side(unseen(0.5, 2.0, 1.0)).expect("it is lost");
    assert!(left > 0.0);
    assert_eq!(
        side(unseen(-0.5, 2.0, 1.0)),
        Some(left),
        "a search stays with its side"
    );
    assert_eq!(side(seen(-0.5, 2.0)), None);
    assert_eq!(side(unseen(-0.5, 2.0, 1.0)), Some(-left));
}
