//! The father on the bench: whom it wakes, whom it prefers and why, and when its mission is over.

use jde_schema::bench::{Bench, Decision};
use jde_schema::prelude::*;

use crate::Follower;
use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};

/// Looks once, at a time in seconds.
fn look(bench: &mut Bench<Follower>, now: f64, ball: Ball) -> Mission {
    bench.set_now(seconds(now));
    bench.import("ball", &ball);
    bench.iterate().expect("it leads");
    bench.exported("mission").expect("it says how far it is")
}

#[test]
fn it_wakes_both_groups_even_before_there_is_a_picture() {
    let mut bench = Bench::<Follower>::new();
    assert!(bench.check().expect("it checks").ready, "it has no precondition");
    bench.iterate().expect("it waits");
    assert_eq!(
        bench.awake_children(),
        ["turn", "brake", "approach", "roam", "track", "search"]
    );
    let mission: Mission = bench.exported("mission").expect("it says how far it is");
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::RUNNING, "looking for the ball")
    );
}

#[test]
fn the_mission_is_done_after_three_seconds_at_the_ball() {
    let mut bench = Bench::<Follower>::new();
    assert_eq!(
        look(&mut bench, 1.0, seen(0.0, 2.0)).note.as_str(),
        "going to the ball"
    );
    assert_eq!(look(&mut bench, 2.0, seen(0.0, 0.9)).note.as_str(), "at the ball");
    let mission = look(&mut bench, 4.9, seen(0.0, 0.9));
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::RUNNING, 0, 1)
    );
    let mission = look(&mut bench, 5.0, seen(0.0, 0.9));
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 1, 1)
    );
    let mission = look(&mut bench, 6.0, seen(0.0, 3.0));
    assert_eq!(mission.state, Mission::DONE, "and nothing takes it back");
}

#[test]
fn a_ball_that_rolls_away_is_to_be_reached_anew() {
    let mut bench = Bench::<Follower>::new();
    look(&mut bench, 1.0, seen(0.0, 0.9));
    look(&mut bench, 3.0, seen(0.0, 1.1));
    look(&mut bench, 3.5, seen(0.0, 0.9));
    assert_eq!(look(&mut bench, 6.0, seen(0.0, 0.9)).state, Mission::RUNNING);
    assert_eq!(look(&mut bench, 6.5, seen(0.0, 0.9)).state, Mission::DONE);
}

#[test]
fn it_gives_up_a_ball_that_is_not_to_be_found_unless_told_not_to() {
    let mut bench = Bench::<Follower>::new();
    assert_eq!(
        look(&mut bench, 1.0, unseen(0.0, 0.0, 60.0)).state,
        Mission::RUNNING
    );
    let mission = look(&mut bench, 2.0, unseen(0.0, 0.0, 120.1));
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::FAILED, "the ball was not to be found")
    );
    assert_eq!(look(&mut bench, 3.0, seen(0.0, 2.0)).state, Mission::FAILED);

    let mut bench = Bench::<Follower>::new();
    bench.set("give_up", 0.0);
    assert_eq!(
        look(&mut bench, 1.0, unseen(0.0, 0.0, 900.0)).state,
        Mission::RUNNING
    );
}

#[test]
fn it_gives_up_when_the_brake_holds_the_base_too_long_and_counts_anew_when_it_let_go() {
    let mut bench = Bench::<Follower>::new();
    bench.iterate().expect("it wakes its children");
    bench.set_child("brake", State::Winner);
    look(&mut bench, 1.0, seen(0.0, 2.0));
    assert_eq!(look(&mut bench, 120.9, seen(0.0, 2.0)).state, Mission::RUNNING);
    bench.set_child("brake", State::Checking);
    look(&mut bench, 122.0, seen(0.0, 2.0));
    bench.set_child("brake", State::Winner);
    look(&mut bench, 123.0, seen(0.0, 2.0));
    assert_eq!(look(&mut bench, 242.9, seen(0.0, 2.0)).state, Mission::RUNNING);
    let mission = look(&mut bench, 243.1, seen(0.0, 2.0));
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::FAILED, "something stayed in the way to the ball")
    );
}

#[test]
fn the_target_is_the_ball_in_the_frame_of_the_odometry() {
    let mut bench = Bench::<Follower>::new();
    let pose = Pose2D::new(3.0, 1.0, core::f64::consts::FRAC_PI_2);
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
    let mission = look(&mut bench, 1.0, seen(core::f64::consts::FRAC_PI_2, 2.0));
    near(mission.target.x, 1.0, 1e-9);
    near(mission.target.y, 1.0, 1e-9);
    near(mission.distance, 2.0, 1e-9);
    let mission = look(&mut bench, 2.0, unseen(0.0, 2.0, 1.0));
    near(mission.target.x, 1.0, 1e-9);
}

fn decided(group: &str, ready: &[&str]) -> Decision {
    let mut bench = Bench::<Follower>::new();
    for child in ["turn", "brake", "approach", "roam", "track", "search"] {
        let state = if ready.contains(&child) {
            State::Ready
        } else {
            State::Checking
        };
        bench.set_child(child, state);
    }
    bench.arbitrate(group).expect("it decides")
}

#[track_caller]
fn chooses(decision: Decision, child: Option<&str>, reason: &str) {
    assert_eq!((decision.child.as_deref(), &*decision.reason), (child, reason));
}

#[test]
fn r3_who_turns_goes_before_the_brake_and_the_brake_before_who_drives() {
    let spot = "who turns on the spot touches nothing";
    chooses(
        decided("base", &["turn", "brake", "approach"]),
        Some("turn"),
        spot,
    );
    chooses(decided("base", &["turn", "brake"]), Some("turn"), spot);
    chooses(
        decided("base", &["brake", "approach"]),
        Some("brake"),
        "something is too near to drive on",
    );
    chooses(decided("base", &["turn", "roam"]), Some("turn"), spot);
    chooses(
        decided("base", &["brake", "roam"]),
        Some("brake"),
        "something is too near to drive on",
    );
    chooses(
        decided("base", &["approach", "roam"]),
        Some("approach"),
        "the way to the ball is free",
    );
    chooses(decided("base", &[]), None, "no child is ready");
    chooses(
        decided("head", &["track", "search"]),
        Some("track"),
        "the ball is here",
    );
}
