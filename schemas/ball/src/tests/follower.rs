//! The father on the bench: which children it wakes, which it prefers and why, and when its mission ends.

use jde_schema::bench::{Bench, Decision};
use jde_schema::prelude::*;

use crate::Follower;
use crate::ball::Ball;
use crate::tests::{near, seconds, seen, unseen};

/// Runs one iteration at a time in seconds.
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
        ["brake", "avoid", "turn", "approach", "roam", "track", "search"]
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
fn it_gives_up_when_nothing_says_whether_there_is_a_ball_and_counts_anew_after_a_sleep() {
    let mut bench = Bench::<Follower>::new();
    let blind = |bench: &mut Bench<Follower>, now: f64| {
        bench.set_now(seconds(now));
        bench.iterate().expect("it waits");
        bench
            .exported::<Mission>("mission")
            .expect("it says how far it is")
    };
    bench.awake().expect("it wakes");
    blind(&mut bench, 1.0);
    assert_eq!(blind(&mut bench, 120.9).state, Mission::RUNNING);
    bench.awake().expect("it wakes again");
    assert_eq!(blind(&mut bench, 300.0).state, Mission::RUNNING);
    assert_eq!(look(&mut bench, 310.0, seen(0.0, 2.0)).state, Mission::RUNNING);
    // A second later the picture is too old to steer by.
    blind(&mut bench, 320.0);
    assert_eq!(blind(&mut bench, 439.9).state, Mission::RUNNING);
    let mission = blind(&mut bench, 440.1);
    assert_eq!(
        (mission.state, mission.note.as_str()),
        (Mission::FAILED, "there were no pictures")
    );

    let mut bench = Bench::<Follower>::new();
    bench.set("give_up", 0.0);
    blind(&mut bench, 1.0);
    assert_eq!(blind(&mut bench, 900.0).state, Mission::RUNNING);
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

/// Target of `avoid` after these balls, with the robot at the origin.
fn avoided(balls: &[Ball]) -> Option<Pose2D> {
    let mut bench = Bench::<Follower>::new();
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO),
    );
    for ball in balls {
        look(&mut bench, 1.0, *ball);
    }
    let target: Target = bench.modulated("avoid", "target").expect("it was told");
    target.get()
}

#[test]
fn who_avoids_is_sent_to_a_ball_that_is_here_and_far() {
    let target = avoided(&[seen(0.0, 2.0)]).expect("it is far");
    near(target.x, 2.0, 1e-9);
    assert_eq!(
        avoided(&[seen(0.0, 2.0), seen(0.0, 1.2)]),
        None,
        "the ball itself is not to be avoided"
    );
    assert_eq!(avoided(&[seen(0.0, 2.0), unseen(0.0, 2.0, 1.0)]), None);
}

/// The decision when these children are READY. `error` is the heading error that `avoid` reports as urgency,
/// rad.
fn decided(group: &str, ready: &[&str], error: f64) -> Decision {
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
    bench.arbitrate(group).expect("it decides")
}

#[track_caller]
fn chooses(ready: &[&str], error: f64, child: &str, reason: &str) {
    let decision = decided("base", ready, error);
    assert_eq!(
        (decision.child.as_deref(), &*decision.reason),
        (Some(child), reason)
    );
}

#[test]
fn r3_of_the_base_who_turns_goes_before_the_brake_and_the_brake_before_who_drives() {
    let spot = "it turns on the spot, which is safe under the brake's nose";
    let brake = "something is too near to drive on";
    chooses(&["brake", "turn"], 0.0, "turn", spot);
    chooses(&["turn", "approach"], 0.0, "turn", spot);
    chooses(&["turn", "roam"], 0.0, "turn", spot);
    chooses(&["brake", "approach"], 0.0, "brake", brake);
    chooses(&["brake", "roam"], 0.0, "brake", brake);
    chooses(
        &["approach", "roam"],
        0.0,
        "approach",
        "the way to the ball is free",
    );
}

#[test]
fn r3_who_avoids_turns_before_all_and_drives_only_without_the_brake() {
    let spot = "it turns on the spot, which is safe under the brake's nose";
    let all = ["brake", "avoid", "turn", "approach"];
    chooses(&all, 0.8, "avoid", spot);
    chooses(&all, 0.6, "brake", "something is too near to drive on");
    let way = "something is in the way to the ball";
    chooses(&["avoid", "turn"], 0.6, "avoid", way);
    chooses(&["avoid", "approach"], 0.6, "avoid", way);
}

#[test]
fn r3_on_absence_nobody_wins_in_either_group() {
    for group in ["base", "head"] {
        assert_eq!(decided(group, &[], 3.0).child, None);
    }
    let decision = decided("head", &["track", "search"], 0.0);
    assert_eq!(
        (decision.child.as_deref(), &*decision.reason),
        (Some("track"), "the ball is here")
    );
}
