//! The father on the bench: which children it wakes, which it prefers and why, and when its mission ends.

use jde_schema::bench::{Bench, Decision};
use jde_schema::prelude::*;

use crate::Follower;
use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};

/// Runs one iteration at a time in seconds.
fn iterate_with(bench: &mut Bench<Follower>, now: f64, ball: Ball) -> Mission {
    bench.set_now(seconds(now));
    bench.import("ball", &ball);
    bench.iterate().expect("no fault");
    bench.exported("mission").expect("a mission")
}

#[test]
fn it_wakes_both_groups_before_the_first_picture() {
    let mut bench = Bench::<Follower>::new();
    assert!(
        bench.check().expect("no fault").ready,
        "the father has no precondition"
    );
    bench.iterate().expect("no fault");
    assert_eq!(
        bench.awake_children(),
        ["brake", "avoid", "turn", "approach", "roam", "track", "search"]
    );
    let mission: Mission = bench.exported("mission").expect("a mission");
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::RUNNING, "looking for the ball")
    );
}

#[test]
fn the_mission_is_done_after_three_seconds_at_the_ball() {
    let mut bench = Bench::<Follower>::new();
    assert_eq!(
        iterate_with(&mut bench, 1.0, seen(0.0, 2.0)).note.as_str(),
        "going to the ball"
    );
    assert_eq!(
        iterate_with(&mut bench, 2.0, seen(0.0, 0.9)).note.as_str(),
        "at the ball"
    );
    let mission = iterate_with(&mut bench, 4.9, seen(0.0, 0.9));
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::RUNNING, 0, 1)
    );
    let mission = iterate_with(&mut bench, 5.0, seen(0.0, 0.9));
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 1, 1)
    );
    let mission = iterate_with(&mut bench, 6.0, seen(0.0, 3.0));
    assert_eq!(mission.state, Mission::DONE, "a done mission stays done");
}

#[test]
fn a_ball_that_rolls_away_must_be_reached_again() {
    let mut bench = Bench::<Follower>::new();
    iterate_with(&mut bench, 1.0, seen(0.0, 0.9));
    iterate_with(&mut bench, 3.0, seen(0.0, 1.1));
    iterate_with(&mut bench, 3.5, seen(0.0, 0.9));
    assert_eq!(
        iterate_with(&mut bench, 6.0, seen(0.0, 0.9)).state,
        Mission::RUNNING
    );
    assert_eq!(iterate_with(&mut bench, 6.5, seen(0.0, 0.9)).state, Mission::DONE);
}

#[test]
fn the_mission_fails_if_the_ball_is_not_found_unless_there_is_no_limit() {
    let mut bench = Bench::<Follower>::new();
    assert_eq!(
        iterate_with(&mut bench, 1.0, unseen(0.0, 0.0, 60.0)).state,
        Mission::RUNNING
    );
    let mission = iterate_with(&mut bench, 2.0, unseen(0.0, 0.0, 120.1));
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::FAILED, "the ball was not to be found")
    );
    assert_eq!(
        iterate_with(&mut bench, 3.0, seen(0.0, 2.0)).state,
        Mission::FAILED
    );

    let mut bench = Bench::<Follower>::new();
    bench.set("give_up", 0.0);
    assert_eq!(
        iterate_with(&mut bench, 1.0, unseen(0.0, 0.0, 900.0)).state,
        Mission::RUNNING
    );
}

#[test]
fn the_mission_fails_without_pictures_and_a_sleep_restarts_the_count() {
    let mut bench = Bench::<Follower>::new();
    let iterate_at = |bench: &mut Bench<Follower>, now: f64| {
        bench.set_now(seconds(now));
        bench.iterate().expect("no fault");
        bench.exported::<Mission>("mission").expect("a mission")
    };
    bench.awake().expect("no fault");
    iterate_at(&mut bench, 1.0);
    assert_eq!(iterate_at(&mut bench, 120.9).state, Mission::RUNNING);
    bench.awake().expect("no fault");
    assert_eq!(iterate_at(&mut bench, 300.0).state, Mission::RUNNING);
    assert_eq!(
        iterate_with(&mut bench, 310.0, seen(0.0, 2.0)).state,
        Mission::RUNNING
    );
    // A second later the picture is too old to steer by.
    iterate_at(&mut bench, 320.0);
    assert_eq!(iterate_at(&mut bench, 439.9).state, Mission::RUNNING);
    let mission = iterate_at(&mut bench, 440.1);
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::FAILED, "there were no pictures")
    );

    let mut bench = Bench::<Follower>::new();
    bench.set("give_up", 0.0);
    iterate_at(&mut bench, 1.0);
    assert_eq!(iterate_at(&mut bench, 900.0).state, Mission::RUNNING);
}

#[test]
fn the_mission_fails_when_the_brake_wins_too_long_and_a_release_restarts_the_count() {
    let mut bench = Bench::<Follower>::new();
    bench.iterate().expect("no fault");
    bench.set_child("brake", State::Winner);
    iterate_with(&mut bench, 1.0, seen(0.0, 2.0));
    assert_eq!(
        iterate_with(&mut bench, 120.9, seen(0.0, 2.0)).state,
        Mission::RUNNING
    );
    bench.set_child("brake", State::Checking);
    iterate_with(&mut bench, 122.0, seen(0.0, 2.0));
    bench.set_child("brake", State::Winner);
    iterate_with(&mut bench, 123.0, seen(0.0, 2.0));
    assert_eq!(
        iterate_with(&mut bench, 242.9, seen(0.0, 2.0)).state,
        Mission::RUNNING
    );
    let mission = iterate_with(&mut bench, 243.1, seen(0.0, 2.0));
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
    let mission = iterate_with(&mut bench, 1.0, seen(core::f64::consts::FRAC_PI_2, 2.0));
    near(mission.target.x, 1.0, 1e-9);
    near(mission.target.y, 1.0, 1e-9);
    near(mission.distance, 2.0, 1e-9);
    let mission = iterate_with(&mut bench, 2.0, unseen(0.0, 2.0, 1.0));
    near(mission.target.x, 1.0, 1e-9);
}

/// Returns the target of `avoid` after these balls, with the robot at the origin.
fn avoid_target(balls: &[Ball]) -> Option<Pose2D> {
    let mut bench = Bench::<Follower>::new();
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO),
    );
    for ball in balls {
        iterate_with(&mut bench, 1.0, *ball);
    }
    let target: Target = bench.modulated("avoid", "target").expect("a target");
    target.get()
}

#[test]
fn avoid_has_a_target_only_while_the_ball_is_known_and_far() {
    let target = avoid_target(&[seen(0.0, 2.0)]).expect("a target");
    near(target.x, 2.0, 1e-9);
    assert_eq!(
        avoid_target(&[seen(0.0, 2.0), seen(0.0, 1.2)]),
        None,
        "avoid must not treat the ball as an obstacle"
    );
    assert_eq!(avoid_target(&[seen(0.0, 2.0), unseen(0.0, 2.0, 1.0)]), None);
}

/// Returns the decision when these children are READY. `error` is the heading error that `avoid` reports as
/// urgency, rad.
fn decide(group: &str, ready: &[&str], error: f64) -> Decision {
    let mut bench = Bench::<Follower>::new();
    for child in ["brake", "avoid", "turn", "approach", "roam", "track", "search"] {
        let state = if ready.contains(&child) {
            State::Ready
        } else {
            State::Checking
        };
        bench.set_child(child, state);
    }
    bench.set_precondition(
        "avoid",
        Precondition::from(ready.contains(&"avoid")).urgency(error),
    );
    bench.arbitrate(group).expect("no fault")
}

#[track_caller]
fn check_choice(ready: &[&str], error: f64, child: &str, reason: &str) {
    let decision = decide("base", ready, error);
    assert_eq!(
        (decision.child.as_deref(), &*decision.reason),
        (Some(child), reason)
    );
}

#[test]
fn r3_turn_precedes_brake_and_brake_precedes_the_children_that_drive() {
    let spot = "it turns on the spot, which is safe under the brake's nose";
    let brake = "something is too near to drive on";
    check_choice(&["brake", "turn"], 0.0, "turn", spot);
    check_choice(&["turn", "approach"], 0.0, "turn", spot);
    check_choice(&["turn", "roam"], 0.0, "turn", spot);
    check_choice(&["brake", "approach"], 0.0, "brake", brake);
    check_choice(&["brake", "roam"], 0.0, "brake", brake);
    check_choice(
        &["approach", "roam"],
        0.0,
        "approach",
        "the way to the ball is free",
    );
}

#[test]
fn r3_avoid_wins_if_it_turns_on_the_spot_and_drives_only_if_brake_is_not_ready() {
    let spot = "it turns on the spot, which is safe under the brake's nose";
    let all = ["brake", "avoid", "turn", "approach"];
    check_choice(&all, 0.8, "avoid", spot);
    check_choice(&all, 0.6, "brake", "something is too near to drive on");
    let reason = "something is in the way to the ball";
    check_choice(&["avoid", "turn"], 0.6, "avoid", reason);
    check_choice(&["avoid", "approach"], 0.6, "avoid", reason);
}

#[test]
fn r3_on_absence_no_child_wins_in_either_group() {
    for group in ["base", "head"] {
        assert_eq!(decide(group, &[], 3.0).child, None);
    }
    let decision = decide("head", &["track", "search"], 0.0);
    assert_eq!(
        (decision.child.as_deref(), &*decision.reason),
        (Some("track"), "the ball is here")
    );
}
