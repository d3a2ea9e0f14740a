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

fn stand(bench: &mut Bench<Example>, x: f64, y: f64) -> Mission {
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::new(x, y, 1.0), Twist::ZERO),
    );
    bench.iterate().expect("no fault");
    bench.exported("mission").expect("a mission")
}

/// The target of both children.
#[track_caller]
fn target(bench: &Bench<Example>) -> Option<Pose2D> {
    let modulation: Target = bench.modulated("cruise", "target").expect("a target");
    assert_eq!(
        bench.modulated("avoid", "target"),
        Some(modulation),
        "both children have the same target"
    );
    modulation.get()
}

#[test]
fn it_wakes_its_children_before_the_first_pose() {
    let mut bench = father();
    assert!(
        bench.check().expect("no fault").ready,
        "the father has no precondition"
    );
    bench.iterate().expect("no fault");
    assert_eq!(bench.awake_children(), ["brake", "avoid", "cruise"]);
    assert_eq!(bench.exported::<Mission>("mission"), None);
}

#[test]
fn both_driving_children_get_one_target_after_another() {
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
    assert_eq!(target(&bench), None, "a done mission has no target");
    assert_eq!(
        stand(&mut bench, 2.0, 0.0).state,
        Mission::DONE,
        "a done mission stays done"
    );
}

/// Holds the robot at a position for these seconds, and returns the last mission.
fn stand_for(bench: &mut Bench<Example>, seconds: core::ops::RangeInclusive<u64>, x: f64) -> Mission {
    let missions = seconds.map(|second| {
        bench.set_now(Duration::from_secs(second));
        stand(bench, x, 0.0)
    });
    missions.last().expect("at least one second")
}

#[test]
fn a_target_that_comes_no_nearer_fails_the_mission_with_a_message() {
    let mut bench = father();
    bench.set("patience", 10.0);
    assert_eq!(stand_for(&mut bench, 0..=9, 0.5).state, Mission::RUNNING);
    assert_eq!(
        stand_for(&mut bench, 10..=15, 1.0).state,
        Mission::RUNNING,
        "the robot came nearer"
    );
    assert_eq!(stand_for(&mut bench, 16..=19, 0.7).state, Mission::RUNNING);
    let mission = stand_for(&mut bench, 20..=20, 1.02);
    assert_eq!((mission.state, mission.reached), (Mission::FAILED, 0));
    assert_eq!(mission.note.as_str(), "1 target was out of reach");
    assert_eq!(target(&bench), None, "a failed mission has no target");
    let (_, message) = bench.log().last().expect("a message");
    assert_eq!(
        message,
        "gives up the target at 2.00, 0.00: it came no nearer than 1.00 m for 10 s; the mission fails"
    );
    bench.set("skips", 1_u32);
    assert_eq!(
        stand_for(&mut bench, 21..=21, 1.0).state,
        Mission::RUNNING,
        "a larger `skips` continues the mission"
    );
}

#[test]
fn it_skips_a_target_if_permitted_and_continues_with_the_next() {
    let mut bench = father();
    bench.set("patience", 10.0);
    bench.set("skips", 1_u32);
    assert_eq!(stand_for(&mut bench, 0..=10, 0.0).state, Mission::RUNNING);
    assert_eq!(target(&bench), Some(CORNERS[1]));
    stand(&mut bench, 2.0, 1.0);
    let mission = stand(&mut bench, 0.0, 1.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 2, 3)
    );
    assert_eq!(mission.note.as_str(), "1 target was out of reach");
}

#[test]
fn patience_may_be_unlimited_and_does_not_count_while_another_schema_drives() {
    let mut bench = father();
    bench.set("patience", 10.0);
    stand_for(&mut bench, 0..=5, 0.0);
    assert_eq!(
        stand_for(&mut bench, 1000..=1004, 0.0).state,
        Mission::RUNNING,
        "another schema drove meanwhile"
    );
    assert_eq!(stand_for(&mut bench, 1005..=1006, 0.0).state, Mission::FAILED);
    let mut bench = father();
    bench.set("patience", 0.0);
    assert_eq!(stand_for(&mut bench, 0..=1000, 0.0).state, Mission::RUNNING);
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
fn without_targets_it_runs_and_sets_no_target() {
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
fn a_mission_with_unlimited_rounds_is_never_done() {
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
        "the second target of the third round"
    );
}

#[test]
fn r8_a_new_route_takes_effect_at_once() {
    let mut bench = father();
    stand(&mut bench, 0.0, 0.0);
    let position = Pose2D::new(-1.0, -1.0, 0.0);
    bench.set(
        "route",
        Route {
            poses: Seq::from_slice(&[position]).expect("one fits"),
        },
    );
    assert_eq!(stand(&mut bench, 0.0, 0.0).total, 1);
    assert_eq!(target(&bench), Some(position));
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
    bench.arbitrate("base").expect("no fault")
}

#[track_caller]
fn check_choice(decision: Decision, child: Option<&str>, reason: &str) {
    assert_eq!((decision.child.as_deref(), &*decision.reason), (child, reason));
}

#[test]
fn r3_on_a_collision_brake_precedes_avoid_and_avoid_precedes_cruise() {
    let (brake, avoid) = ("on overlap the brake wins", "something is in the way");
    check_choice(
        decide(None, &["brake", "avoid", "cruise"], 0.0),
        Some("brake"),
        brake,
    );
    check_choice(decide(None, &["brake", "avoid"], 3.1), Some("brake"), brake);
    check_choice(decide(None, &["brake", "cruise"], 0.0), Some("brake"), brake);
    check_choice(decide(None, &["avoid", "cruise"], 0.0), Some("avoid"), avoid);
}

#[test]
fn avoid_may_win_against_brake_if_it_would_turn_on_the_spot_and_that_is_permitted() {
    let allowed = Some(0.7);
    let reason = "it turns on the spot, which is safe under the brake's nose";
    check_choice(decide(allowed, &["brake", "avoid"], 0.7), Some("avoid"), reason);
    check_choice(
        decide(allowed, &["brake", "avoid"], 0.69),
        Some("brake"),
        "on overlap the brake wins",
    );
    check_choice(
        decide(allowed, &["brake", "cruise"], 3.1),
        Some("brake"),
        "on overlap the brake wins",
    );
}

#[test]
fn r3_on_absence_no_child_wins() {
    check_choice(decide(None, &[], 3.1), None, "no child is ready");
    check_choice(decide(Some(0.7), &[], 3.1), None, "no child is ready");
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

/// Clicks on the field.
fn click(bench: &mut Bench<Example>, x: f64, y: f64) {
    let at = [x, y, 0.0];
    let button = Button::Primary;
    bench
        .touch("field", Touch::Clicked { at, button })
        .expect("no fault");
}

#[test]
fn a_clicked_target_precedes_the_rest_of_the_route() {
    let mut bench = father();
    stand(&mut bench, 0.0, 0.0);
    click(&mut bench, -1.0, 0.5);
    let mission = stand(&mut bench, 0.0, 0.5);
    let clicked = Pose2D::new(-1.0, 0.5, 0.0);
    assert_eq!((mission.target, mission.distance), (clicked, 1.0));
    assert_eq!(target(&bench), Some(clicked));
    let mission = stand(&mut bench, -0.9, 0.5);
    assert_eq!(
        (mission.target, mission.reached),
        (CORNERS[0], 0),
        "the clicked target is not part of the route"
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
    stand(&mut bench, 0.0, 0.0);
    assert!(!bench.draw().expect("no fault").can_press("clear"));
    click(&mut bench, -1.0, 0.5);
    assert!(bench.draw().expect("no fault").can_press("clear"));
    bench.touch("clear", Touch::Pressed).expect("no fault");
    stand(&mut bench, 0.0, 0.0);
    assert_eq!(target(&bench), Some(CORNERS[0]));
}

#[test]
fn the_mission_is_not_done_before_the_clicked_target_is_reached() {
    let mut bench = father();
    for corner in &CORNERS[..2] {
        stand(&mut bench, corner.x, corner.y);
    }
    click(&mut bench, 5.0, 5.0);
    assert_eq!(
        stand(&mut bench, 0.0, 1.0).reached,
        2,
        "the last target of the route follows"
    );
    let mission = stand(&mut bench, 5.0, 5.0);
    assert_eq!((mission.state, mission.target), (Mission::RUNNING, CORNERS[2]));
    assert_eq!(stand(&mut bench, 0.0, 1.0).state, Mission::DONE);
}

#[test]
fn its_panel_shows_robot_scan_areas_and_children() {
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
    bench.iterate().expect("no fault");
    let panel = bench.draw().expect("no fault");
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
    let hit = shapes.iter().any(|shape| match shape {
        Shape::Points { points, .. } => points.len() == 1 && near(points[0], [1.0, 2.0]),
        _ => false,
    });
    assert!(hit, "2 m ahead of a robot that faces along y: {shapes:#?}");
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
        panic!("a table")
    };
    let rows: Vec<_> = rows.iter().map(|row| row.join(" ")).collect();
    // The iteration woke the children that slept.
    assert_eq!(rows, ["brake checking", "avoid checking", "cruise winner"]);
}

#[test]
fn its_panel_works_without_inputs() {
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
    let panel = bench.draw().expect("no fault");
    assert_eq!(panel.texts()[1], "No target");
    assert!(
        !panel
            .shapes("field")
            .iter()
            .any(|shape| matches!(shape, Shape::Robot { .. }))
    );
}

#[test]
fn another_instance_continues_the_mission_from_the_saved_memory() {
    let mut old = father();
    for corner in &CORNERS[..2] {
        stand(&mut old, corner.x, corner.y);
    }
    click(&mut old, 5.0, 5.0);
    let mut new = father();
    new.restore(&old.save().expect("no fault")).expect("no fault");
    assert_eq!(stand(&mut new, 0.0, 0.0).reached, 2);
    stand(&mut old, 0.0, 0.0);
    let restored = target(&new).expect("a target");
    assert_eq!((restored.x, restored.y), (5.0, 5.0), "the clicked target");
    assert_eq!(target(&old), Some(restored));
}
