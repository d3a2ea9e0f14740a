//! The father on the bench: whom it wakes, where it sends them, when the mission is done, and whom it prefers and why.

use jde_schema::bench::{Bench, Decision};

use super::*;

const CORNERS: [Pose2D; 3] = [
    Pose2D::new(2.0, 0.0, 0.0),
    Pose2D::new(2.0, 1.0, 0.0),
    Pose2D::new(0.0, 1.0, 0.0),
];

/// A father with three targets and a robot that can be put anywhere.
fn father() -> Bench<Example> {
    let mut bench = Bench::new();
    let poses = Seq::from_slice(&CORNERS).expect("three fit");
    bench.set("route", Route { poses });
    bench
}

fn stand(bench: &mut Bench<Example>, x: f64, y: f64) -> Mission {
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::new(x, y, 1.0), Twist::ZERO),
    );
    bench.iterate().expect("it leads");
    bench.exported("mission").expect("it says how far it is")
}

/// Where both children are to go.
#[track_caller]
fn target(bench: &Bench<Example>) -> Option<Pose2D> {
    let wanted: Target = bench.modulated("cruise", "target").expect("it was told");
    assert_eq!(
        bench.modulated("avoid", "target"),
        Some(wanted),
        "both go to one place"
    );
    wanted.get()
}

#[test]
fn it_wakes_its_children_even_before_it_knows_where_it_is() {
    let mut bench = father();
    assert!(bench.check().expect("it checks").ready, "it has no precondition");
    bench.iterate().expect("it waits for a pose");
    assert_eq!(bench.awake_children(), ["brake", "avoid", "cruise"]);
    assert_eq!(bench.exported::<Mission>("mission"), None);
}

#[test]
fn targets_are_given_one_after_another_to_both_who_approach_them() {
    let mut bench = father();
    let mission = stand(&mut bench, 0.0, 0.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::RUNNING, 0, 3)
    );
    assert_eq!((mission.target, mission.distance), (CORNERS[0], 2.0));
    assert_eq!(target(&bench), Some(CORNERS[0]));

    assert_eq!(stand(&mut bench, 1.9, 0.0).reached, 1);
    assert_eq!(target(&bench), Some(CORNERS[1]));
    assert_eq!(stand(&mut bench, 2.0, 0.9).reached, 2);
    assert_eq!(target(&bench), Some(CORNERS[2]));

    let mission = stand(&mut bench, 0.1, 1.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 3, 3)
    );
    assert_eq!((mission.target, mission.distance), (Pose2D::ORIGIN, 0.0));
    assert_eq!(target(&bench), None, "nobody drives on once all is done");
    assert_eq!(
        stand(&mut bench, 2.0, 0.0).state,
        Mission::DONE,
        "and nothing takes it back"
    );
}

#[test]
fn a_target_is_reached_within_the_tolerance_of_2007() {
    let mut bench = father();
    assert_eq!(stand(&mut bench, 2.301, 0.0).reached, 0);
    assert_eq!(stand(&mut bench, 2.299, 0.0).reached, 1);
    let mut bench = father();
    bench.set("tolerance", 0.1);
    assert_eq!(stand(&mut bench, 2.2, 0.0).reached, 0);
    assert_eq!(stand(&mut bench, 2.05, 0.0).reached, 1);
}

#[test]
fn without_targets_it_runs_on_and_wants_nothing() {
    let mut bench = Bench::<Example>::new();
    for rounds in [1_u32, 0] {
        bench.set("rounds", rounds);
        let mission = stand(&mut bench, 0.0, 0.0);
        assert_eq!(
            (mission.state, mission.reached, mission.total),
            (Mission::RUNNING, 0, 0)
        );
        assert_eq!(target(&bench), None);
    }
}

#[test]
fn targets_count_over_all_rounds() {
    let mut bench = father();
    bench.set("rounds", 2_u32);
    for reached in 1..=6 {
        let corner = CORNERS[(reached as usize - 1) % 3];
        let mission = stand(&mut bench, corner.x, corner.y);
        let state = if reached == 6 {
            Mission::DONE
        } else {
            Mission::RUNNING
        };
        assert_eq!(
            (mission.state, mission.reached, mission.total),
            (state, reached, 6)
        );
    }
    assert_eq!(target(&bench), None);
}

#[test]
fn rounds_without_end_are_never_done() {
    let mut bench = father();
    bench.set("rounds", 0_u32);
    for reached in 1..=7 {
        let corner = CORNERS[(reached as usize - 1) % 3];
        let mission = stand(&mut bench, corner.x, corner.y);
        assert_eq!(
            (mission.state, mission.reached, mission.total),
            (Mission::RUNNING, reached, 0)
        );
    }
    assert_eq!(
        target(&bench),
        Some(CORNERS[1]),
        "on to the second target of the third round"
    );
}

#[test]
fn r8_a_route_written_anew_counts_at_once() {
    let mut bench = father();
    stand(&mut bench, 0.0, 0.0);
    let elsewhere = Pose2D::new(-1.0, -1.0, 0.0);
    bench.set(
        "route",
        Route {
            poses: Seq::from_slice(&[elsewhere]).expect("one fits"),
        },
    );
    assert_eq!(stand(&mut bench, 0.0, 0.0).total, 1);
    assert_eq!(target(&bench), Some(elsewhere));
}

/// What it decides when these are ready, with the heading error that `avoid` offers, rad.
fn decided(turning: Option<f64>, ready: &[&str], error: f64) -> Decision {
    let mut bench = father();
    if let Some(turning) = turning {
        bench.set("turning", turning);
    }
    for child in ["brake", "avoid", "cruise"] {
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
    bench.arbitrate("base").expect("it decides")
}

#[track_caller]
fn chooses(decision: Decision, child: Option<&str>, reason: &str) {
    assert_eq!((decision.child.as_deref(), &*decision.reason), (child, reason));
}

#[test]
fn r3_on_overlap_the_brake_wins_then_who_avoids_then_who_cruises() {
    let (brake, avoid) = ("on overlap the brake wins", "something is in the way");
    chooses(
        decided(None, &["brake", "avoid", "cruise"], 0.0),
        Some("brake"),
        brake,
    );
    chooses(decided(None, &["brake", "avoid"], 3.1), Some("brake"), brake);
    chooses(decided(None, &["brake", "cruise"], 0.0), Some("brake"), brake);
    chooses(decided(None, &["avoid", "cruise"], 0.0), Some("avoid"), avoid);
}

#[test]
fn an_avoider_that_would_turn_on_the_spot_may_win_where_that_is_allowed() {
    let allowed = Some(0.7);
    let reason = "it turns on the spot, which is safe under the brake's nose";
    chooses(decided(allowed, &["brake", "avoid"], 0.7), Some("avoid"), reason);
    chooses(
        decided(allowed, &["brake", "avoid"], 0.69),
        Some("brake"),
        "on overlap the brake wins",
    );
    chooses(
        decided(allowed, &["brake", "cruise"], 3.1),
        Some("brake"),
        "on overlap the brake wins",
    );
}

#[test]
fn r3_on_absence_nobody_wins() {
    chooses(decided(None, &[], 3.1), None, "no child is ready");
    chooses(decided(Some(0.7), &[], 3.1), None, "no child is ready");
}

#[test]
fn r7_it_commands_no_actuator_itself() {
    let bench = father();
    let actuators = bench
        .description()
        .ports
        .iter()
        .filter(|port| port.name == "base");
    assert_eq!(actuators.count(), 0);
}
