//! The father on the bench: which children it wakes, their targets, when the mission is done, and which child
//! it prefers and why.

use jde_schema::bench::{Bench, Decision};
use jde_schema::panel::{Button, Item, Shape, Touch};

use super::*;

const CORNERS: [Pose2D; 3] = [
    Pose2D::new(2.0, 0.0, 0.0),
    Pose2D::new(2.0, 1.0, 0.0),
    Pose2D::new(0.0, 1.0, 0.0),
];

/// A father with three targets.
fn father() -> Bench<Example> {
    let mut bench = Bench::new();
    let poses = Seq::from_slice(&CORNERS).expect("three fit");
    bench.set("route", Route { poses });
    bench
}

fn iterate_at(bench: &mut Bench<Example>, x: f64, y: f64) -> Mission {
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::new(x, y, 1.0), Twist::ZERO),
    );
    bench.iterate().expect("the iteration succeeds");
    bench.exported("mission").expect("the mission is exported")
}

/// The target of both children.
#[track_caller]
fn target(bench: &Bench<Example>) -> Option<Pose2D> {
    let target: Target = bench
        .modulated("cruise", "target")
        .expect("the target is modulated");
    assert_eq!(
        bench.modulated("avoid", "target"),
        Some(target),
        "both children must have the same target"
    );
    target.get()
}

#[test]
fn children_are_woken_before_the_first_pose() {
    let mut bench = father();
    assert!(
        bench.check().expect("the check succeeds").ready,
        "it has no precondition"
    );
    bench.iterate().expect("the iteration succeeds without a pose");
    assert_eq!(bench.awake_children(), ["brake", "avoid", "cruise"]);
    assert_eq!(bench.exported::<Mission>("mission"), None);
}

#[test]
fn targets_are_set_one_after_another_for_avoid_and_cruise() {
    let mut bench = father();
    let mission = iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::RUNNING, 0, 3)
    );
    assert_eq!((mission.target, mission.distance), (CORNERS[0], 2.0));
    assert_eq!(target(&bench), Some(CORNERS[0]));

    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).reached, 1);
    assert_eq!(target(&bench), Some(CORNERS[1]));
    assert_eq!(iterate_at(&mut bench, 2.0, 0.9).reached, 2);
    assert_eq!(target(&bench), Some(CORNERS[2]));

    let mission = iterate_at(&mut bench, 0.1, 1.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 3, 3)
    );
    assert_eq!((mission.target, mission.distance), (Pose2D::ORIGIN, 0.0));
    assert_eq!(target(&bench), None, "no target is set after the mission");
    assert_eq!(
        iterate_at(&mut bench, 2.0, 0.0).state,
        Mission::DONE,
        "the final state is kept"
    );
}

/// Holds the robot at a position for these seconds, and returns the last mission.
fn iterate_at_for(bench: &mut Bench<Example>, seconds: core::ops::RangeInclusive<u64>, x: f64) -> Mission {
    let missions = seconds.map(|second| {
        bench.set_now(Duration::from_secs(second));
        iterate_at(bench, x, 0.0)
    });
    missions.last().expect("the range is not empty")
}

#[test]
fn an_unreachable_target_fails_the_mission_and_is_logged() {
    let mut bench = father();
    bench.set("patience", 10.0);
    assert_eq!(iterate_at_for(&mut bench, 0..=9, 0.5).state, Mission::RUNNING);
    assert_eq!(
        iterate_at_for(&mut bench, 10..=15, 1.0).state,
        Mission::RUNNING,
        "the robot came nearer"
    );
    assert_eq!(iterate_at_for(&mut bench, 16..=19, 0.7).state, Mission::RUNNING);
    let mission = iterate_at_for(&mut bench, 20..=20, 1.02);
    assert_eq!((mission.state, mission.reached), (Mission::FAILED, 0));
    assert_eq!(mission.note.as_str(), "1 target was out of reach");
    assert_eq!(target(&bench), None, "no target is set after a failure");
    let (_, message) = bench.log().last().expect("a message is logged");
    assert_eq!(
        message,
        "gives up the target at 2.00, 0.00: it came no nearer than 1.00 m for 10 s; the mission fails"
    );
    bench.set("skips", 1_u32);
    assert_eq!(
        iterate_at_for(&mut bench, 21..=21, 1.0).state,
        Mission::RUNNING,
        "the limit was raised"
    );
}

#[test]
fn a_permitted_skip_continues_with_the_next_target() {
    let mut bench = father();
    bench.set("patience", 10.0);
    bench.set("skips", 1_u32);
    assert_eq!(iterate_at_for(&mut bench, 0..=10, 0.0).state, Mission::RUNNING);
    assert_eq!(target(&bench), Some(CORNERS[1]));
    iterate_at(&mut bench, 2.0, 1.0);
    let mission = iterate_at(&mut bench, 0.0, 1.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 2, 3)
    );
    assert_eq!(mission.note.as_str(), "1 target was out of reach");
}

#[test]
fn time_is_not_counted_without_a_limit_or_while_another_schema_drives() {
    let mut bench = father();
    bench.set("patience", 10.0);
    iterate_at_for(&mut bench, 0..=5, 0.0);
    assert_eq!(
        iterate_at_for(&mut bench, 1000..=1004, 0.0).state,
        Mission::RUNNING,
        "another schema drove meanwhile"
    );
    assert_eq!(
        iterate_at_for(&mut bench, 1005..=1006, 0.0).state,
        Mission::FAILED
    );
    let mut bench = father();
    bench.set("patience", 0.0);
    assert_eq!(iterate_at_for(&mut bench, 0..=1000, 0.0).state, Mission::RUNNING);
}

#[test]
fn a_target_is_reached_within_the_tolerance_of_2007() {
    let mut bench = father();
    assert_eq!(iterate_at(&mut bench, 2.301, 0.0).reached, 0);
    assert_eq!(iterate_at(&mut bench, 2.299, 0.0).reached, 1);
    let mut bench = father();
    bench.set("tolerance", 0.1);
    assert_eq!(iterate_at(&mut bench, 2.2, 0.0).reached, 0);
    assert_eq!(iterate_at(&mut bench, 2.05, 0.0).reached, 1);
}

#[test]
fn without_targets_the_mission_runs_and_no_target_is_set() {
    let mut bench = Bench::<Example>::new();
    for rounds in [1_u32, 0] {
        bench.set("rounds", rounds);
        let mission = iterate_at(&mut bench, 0.0, 0.0);
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
        let mission = iterate_at(&mut bench, corner.x, corner.y);
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
fn unlimited_rounds_are_never_done() {
    let mut bench = father();
    bench.set("rounds", 0_u32);
    for reached in 1..=7 {
        let corner = CORNERS[(reached as usize - 1) % 3];
        let mission = iterate_at(&mut bench, corner.x, corner.y);
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
fn r8_a_new_route_applies_at_once() {
    let mut bench = father();
    iterate_at(&mut bench, 0.0, 0.0);
    let other = Pose2D::new(-1.0, -1.0, 0.0);
    bench.set(
        "route",
        Route {
            poses: Seq::from_slice(&[other]).expect("one fits"),
        },
    );
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).total, 1);
    assert_eq!(target(&bench), Some(other));
}

/// The decision when these children are READY. `error` is the heading error that `avoid` reports as urgency,
/// rad.
fn decide(turning: Option<f64>, ready: &[&str], error: f64) -> Decision {
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
    bench.arbitrate("base").expect("the arbitration succeeds")
}

#[track_caller]
fn assert_choice(decision: Decision, child: Option<&str>, reason: &str) {
    assert_eq!((decision.child.as_deref(), &*decision.reason), (child, reason));
}

#[test]
fn r3_on_overlap_the_brake_precedes_avoid_and_avoid_precedes_cruise() {
    let (brake, avoid) = ("on overlap the brake wins", "something is in the way");
    assert_choice(
        decide(None, &["brake", "avoid", "cruise"], 0.0),
        Some("brake"),
        brake,
    );
    assert_choice(decide(None, &["brake", "avoid"], 3.1), Some("brake"), brake);
    assert_choice(decide(None, &["brake", "cruise"], 0.0), Some("brake"), brake);
    assert_choice(decide(None, &["avoid", "cruise"], 0.0), Some("avoid"), avoid);
}

#[test]
fn an_avoider_that_would_turn_on_the_spot_may_win_where_that_is_allowed() {
    let allowed = Some(0.7);
    let reason = "it turns on the spot, which is safe under the brake's nose";
    assert_choice(decide(allowed, &["brake", "avoid"], 0.7), Some("avoid"), reason);
    assert_choice(
        decide(allowed, &["brake", "avoid"], 0.69),
        Some("brake"),
        "on overlap the brake wins",
    );
    assert_choice(
        decide(allowed, &["brake", "cruise"], 3.1),
        Some("brake"),
        "on overlap the brake wins",
    );
}

#[test]
fn r3_on_absence_no_child_wins() {
    assert_choice(decide(None, &[], 3.1), None, "no child is ready");
    assert_choice(decide(Some(0.7), &[], 3.1), None, "no child is ready");
}

#[test]
fn r7_the_schema_has_no_actuator() {
    let bench = father();
    let actuators = bench
        .description()
        .ports
        .iter()
        .filter(|port| port.name == "base");
    assert_eq!(actuators.count(), 0);
}

/// Clicks on the field.
fn click(bench: &mut Bench<Example>, x: f64, y: f64) {
    let at = [x, y, 0.0];
    let button = Button::Primary;
    bench
        .touch("field", Touch::Clicked { at, button })
        .expect("the canvas accepts clicks");
}

#[test]
fn a_clicked_target_precedes_the_rest_of_the_route() {
    let mut bench = father();
    iterate_at(&mut bench, 0.0, 0.0);
    click(&mut bench, -1.0, 0.5);
    let mission = iterate_at(&mut bench, 0.0, 0.5);
    let clicked = Pose2D::new(-1.0, 0.5, 0.0);
    assert_eq!((mission.target, mission.distance), (clicked, 1.0));
    assert_eq!(target(&bench), Some(clicked));
    let mission = iterate_at(&mut bench, -0.9, 0.5);
    assert_eq!(
        (mission.target, mission.reached),
        (CORNERS[0], 0),
        "a clicked target is not counted"
    );
    assert_eq!(target(&bench), Some(CORNERS[0]), "the route continues");
    let messages: Vec<_> = bench.log().iter().map(|(_, text)| &**text).collect();
    assert_eq!(
        messages,
        [
            "ana@laptop sends the robot to -1.00, 0.50 first",
            "reached the target of ana@laptop at -1.00, 0.50",
        ]
    );
}

#[test]
fn a_clicked_target_can_be_cleared() {
    let mut bench = father();
    iterate_at(&mut bench, 0.0, 0.0);
    assert!(!bench.draw().expect("the panel is drawn").can_press("clear"));
    click(&mut bench, -1.0, 0.5);
    assert!(bench.draw().expect("the panel is drawn").can_press("clear"));
    bench
        .touch("clear", Touch::Pressed)
        .expect("the button is enabled");
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(target(&bench), Some(CORNERS[0]));
}

#[test]
fn the_mission_is_not_done_before_a_clicked_target_is_reached() {
    let mut bench = father();
    for corner in &CORNERS[..2] {
        iterate_at(&mut bench, corner.x, corner.y);
    }
    click(&mut bench, 5.0, 5.0);
    assert_eq!(
        iterate_at(&mut bench, 0.0, 1.0).reached,
        2,
        "the clicked target comes first"
    );
    let mission = iterate_at(&mut bench, 5.0, 5.0);
    assert_eq!((mission.state, mission.target), (Mission::RUNNING, CORNERS[2]));
    assert_eq!(iterate_at(&mut bench, 0.0, 1.0).state, Mission::DONE);
}

#[test]
fn the_panel_shows_the_robot_the_scan_and_the_areas() {
    let mut bench = father();
    bench.import(
        "laser",
        &LaserScan {
            angle_increment: 0.1,
            range_max: 8.0,
            ranges: Seq::from_slice(&[2.0]).expect("one fits"),
            ..LaserScan::default()
        },
    );
    for (port, value) in [
        ("avoid_ahead", 3.0),
        ("avoid_half_width", 1.0),
        ("brake_ahead", 0.6),
        ("brake_half_width", 0.3),
    ] {
        bench.import(port, &value);
    }
    let pose = Pose2D::new(1.0, 0.0, core::f64::consts::FRAC_PI_2);
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
    bench.set_child("cruise", State::Winner);
    bench.iterate().expect("the iteration succeeds");
    let panel = bench.draw().expect("the panel is drawn");
    assert_eq!(panel.texts()[1], "To target 1 of 3, 1.00 m away");

    let near = |[x, y]: [f64; 2], expected: [f64; 2]| (x - expected[0]).hypot(y - expected[1]) < 1e-6;
    let shapes = panel.shapes("field");
    let robot = shapes.iter().any(|shape| match shape {
        Shape::Robot { pose: [x, y, theta] } => {
            near([*x, *y], [1.0, 0.0]) && (theta - pose.theta).abs() < 1e-6
        }
        _ => false,
    });
    assert!(robot, "{shapes:#?}");
    let has_point = shapes.iter().any(|shape| match shape {
        Shape::Points { points, .. } => points.len() == 1 && near(points[0], [1.0, 2.0]),
        _ => false,
    });
    assert!(has_point, "2 m ahead of a robot that faces along y: {shapes:#?}");
    let areas = shapes.iter().filter_map(|shape| match shape {
        Shape::Line {
            points, closed: true, ..
        } => Some(points[1]),
        _ => None,
    });
    let corners: Vec<_> = areas.collect();
    assert!(
        near(corners[0], [2.0, 3.0]) && near(corners[1], [1.3, 0.6]),
        "{corners:?}"
    );
    let Item::Table { rows, .. } = panel.widget("children") else {
        panic!("expected a table")
    };
    let rows: Vec<_> = rows.iter().map(|row| row.join(" ")).collect();
    // The iteration woke the children that slept.
    assert_eq!(rows, ["brake checking", "avoid checking", "cruise winner"]);
}

#[test]
fn the_panel_works_without_any_values() {
    let mut bench = Bench::<Example>::new();
    for port in [
        "laser",
        "avoid_ahead",
        "avoid_half_width",
        "brake_ahead",
        "brake_half_width",
    ] {
        bench.unbind(port);
    }
    let panel = bench.draw().expect("the panel is drawn");
    assert_eq!(panel.texts()[1], "No target");
    assert!(
        !panel
            .shapes("field")
            .iter()
            .any(|shape| matches!(shape, Shape::Robot { .. }))
    );
}

#[test]
fn another_build_continues_from_the_saved_state() {
    let mut old = father();
    for corner in &CORNERS[..2] {
        iterate_at(&mut old, corner.x, corner.y);
    }
    click(&mut old, 5.0, 5.0);
    let mut new = father();
    new.restore(&old.save().expect("saving succeeds"))
        .expect("restoring succeeds");
    assert_eq!(iterate_at(&mut new, 0.0, 0.0).reached, 2);
    iterate_at(&mut old, 0.0, 0.0);
    let target_of_new = target(&new).expect("there is a target");
    assert_eq!(
        (target_of_new.x, target_of_new.y),
        (5.0, 5.0),
        "the clicked target must be kept"
    );
    assert_eq!(target(&old), Some(target_of_new));
}
