//! The father on the bench: its children, their targets, and its panel.

use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Touch};
use jde_schema::types::{Point2D, Strip, Zone};

use super::*;

mod pauses;

fn father(targets: &[Pose2D]) -> Bench<Navigate> {
    let mut bench = Bench::new();
    let poses = Seq::from_slice(targets).expect("they fit");
    bench.set("route", Route { poses });
    bench
}

fn iterate_at(bench: &mut Bench<Navigate>, x: f64, y: f64) -> Mission {
    iterate_in(bench, Pose2D::new(x, y, 0.0))
}

fn iterate_in(bench: &mut Bench<Navigate>, pose: Pose2D) -> Mission {
    let odometry = Odometry::planar(Time::default(), pose, Twist::ZERO);
    bench.import("pose", &odometry);
    bench.iterate().expect("the iteration succeeds");
    bench.exported("mission").expect("the mission is exported")
}

fn planned(bench: &Bench<Navigate>) -> Option<Pose2D> {
    target(bench).get()
}

fn target(bench: &Bench<Navigate>) -> Target {
    bench
        .modulated("plan", "target")
        .expect("the planner has a target")
}

#[test]
fn a_target_is_reached_where_the_robot_faces_as_the_target_does() {
    let goal = Pose2D::new(2.0, 0.0, 1.5);
    let mut bench = father(&[goal]);
    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).state, Mission::RUNNING);
    assert_eq!(target(&bench), Target::facing(goal));
    let turned = |theta| Pose2D::new(1.9, 0.0, theta);
    assert_eq!(iterate_in(&mut bench, turned(1.2)).state, Mission::RUNNING);
    assert_eq!(iterate_in(&mut bench, turned(1.3)).state, Mission::DONE);
    let mut any = father(&[goal]);
    any.set("yaw_goal_tolerance", core::f64::consts::PI);
    iterate_at(&mut any, 0.0, 0.0);
    assert_eq!(target(&any), Target::at(goal));
    assert_eq!(iterate_at(&mut any, 1.9, 0.0).state, Mission::DONE);
}

#[test]
fn a_chosen_target_states_whether_its_heading_counts_and_a_clicked_place_has_none() {
    let goal = Pose2D::new(2.0, 0.0, 3.0);
    for (chosen, state) in [
        (Target::at(goal), Mission::DONE),
        (Target::facing(goal), Mission::RUNNING),
    ] {
        let mut bench = father(&[]);
        bench.import("chosen", &chosen);
        assert_eq!(iterate_at(&mut bench, 1.9, 0.0).state, state);
    }
    let mut bench = father(&[goal]);
    let at = [1.0, 3.0, 0.0];
    let button = Button::Primary;
    bench
        .touch("field", Touch::Clicked { at, button })
        .expect("the gesture is handled");
    iterate_in(&mut bench, Pose2D::new(0.0, 0.0, 2.0));
    assert_eq!(target(&bench), Target::at(Pose2D::new(1.0, 3.0, 0.0)));
    iterate_in(&mut bench, Pose2D::new(1.0, 3.0, 2.0));
    assert_eq!(target(&bench), Target::facing(goal), "it was there");
}

#[test]
fn a_chosen_target_takes_none_from_the_route() {
    let route = [Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(4.0, 0.0, 0.0)];
    let mut bench = father(&route);
    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).reached, 1);
    bench.import("chosen", &Target::at(Pose2D::new(0.0, 3.0, 0.0)));
    let mission = iterate_at(&mut bench, 0.0, 3.0);
    assert_eq!(
        (mission.state, mission.reached, mission.total),
        (Mission::DONE, 1, 2)
    );
    bench.retract("chosen");
    assert_eq!(iterate_at(&mut bench, 0.0, 3.0).state, Mission::RUNNING);
    assert_eq!(target(&bench), Target::facing(route[1]));
    assert_eq!(iterate_at(&mut bench, 3.9, 0.0).reached, 2);
}

#[test]
fn it_passes_the_poses_before_the_last_whatever_their_headings() {
    let poses = [Pose2D::new(2.0, 0.0, 3.0), Pose2D::new(4.0, 0.0, 3.0)];
    let mut bench = father(&poses);
    bench.set("through_poses", true);
    bench.set("waypoint_pause_duration", 5.0);
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(target(&bench), Target::at(poses[0]));
    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).reached, 1);
    assert_eq!(target(&bench), Target::facing(poses[1]), "without a pause");
    assert_eq!(iterate_at(&mut bench, 3.9, 0.0).state, Mission::RUNNING);
    let last = Pose2D::new(3.9, 0.0, 3.0);
    assert_eq!(iterate_in(&mut bench, last).state, Mission::DONE);
}

#[test]
fn it_waits_at_each_target_and_its_patience_waits_too() {
    let mut bench = father(&[Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(4.0, 0.0, 0.0)]);
    bench.set("waypoint_pause_duration", 5.0);
    bench.set("patience", 3.0);
    bench.set_now(Duration::from_secs(1));
    iterate_at(&mut bench, 2.0, 0.0);
    for second in 2..6 {
        bench.set_now(Duration::from_secs(second));
        let mission = iterate_at(&mut bench, 2.0, 0.0);
        let words = (mission.state, mission.reached, mission.note.as_str());
        assert_eq!(words, (Mission::RUNNING, 1, "waits at the target"));
        assert_eq!(planned(&bench), None);
        assert!(!bench.awake_children().contains(&"drive"));
    }
    bench.set_now(Duration::from_secs(6));
    assert_eq!(iterate_at(&mut bench, 2.0, 0.0).note.as_str(), "");
    assert_eq!(planned(&bench), Some(Pose2D::new(4.0, 0.0, 0.0)));
    let last = iterate_at(&mut bench, 4.0, 0.0);
    assert_eq!((last.state, last.note.as_str()), (Mission::DONE, ""));
}

#[test]
fn the_planner_receives_one_target_after_another() {
    let (first, second) = (Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(2.0, 2.0, 0.0));
    let mut bench = father(&[first, second]);
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::RUNNING);
    assert_eq!(planned(&bench), Some(first));
    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).reached, 1);
    assert_eq!(planned(&bench), Some(second));
    assert_eq!(iterate_at(&mut bench, 2.0, 1.9).state, Mission::DONE);
    assert_eq!(planned(&bench), None);
}

#[test]
fn when_the_target_ends_nobody_drives_and_the_next_one_waits_for_its_path() {
    let mut bench = Bench::<Navigate>::new();
    let drives = |bench: &Bench<Navigate>| bench.awake_children().contains(&"drive");
    let plan = |bench: &mut Bench<Navigate>, at: u64| {
        let mut path = Path::default();
        path.header.stamp = Duration::from_secs(at).into();
        bench.import("path", &path);
    };
    bench.set_now(Duration::from_secs(1));
    bench.import("chosen", &Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    iterate_at(&mut bench, 0.0, 0.0);
    plan(&mut bench, 2);
    bench.set_now(Duration::from_secs(3));
    iterate_at(&mut bench, 0.1, 0.0);
    assert!(drives(&bench));
    bench.retract("chosen");
    iterate_at(&mut bench, 0.2, 0.0);
    assert!(!drives(&bench), "although there still is a path");
    assert_eq!(planned(&bench), None);
    bench.set_now(Duration::from_secs(4));
    bench.import("chosen", &Target::at(Pose2D::new(-5.0, 0.0, 0.0)));
    iterate_at(&mut bench, 0.2, 0.0);
    assert!(!drives(&bench), "the path leads to the target before");
    plan(&mut bench, 5);
    iterate_at(&mut bench, 0.2, 0.0);
    assert!(drives(&bench));
}

#[test]
fn without_a_pose_somebody_may_move_to_find_it_unless_there_is_no_target() {
    let mut bench = Bench::<Navigate>::new();
    let drives = |bench: &Bench<Navigate>| bench.awake_children().contains(&"drive");
    bench.iterate().expect("it runs");
    assert!(!drives(&bench));
    bench.import("chosen", &Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    bench.iterate().expect("it runs");
    assert!(drives(&bench));
    bench.retract("chosen");
    bench.iterate().expect("it runs");
    assert!(!drives(&bench));
}

#[test]
fn at_the_end_of_a_path_near_a_target_in_an_obstacle_the_target_counts_as_reached() {
    let (first, second) = (Pose2D::new(5.0, 0.0, 0.0), Pose2D::new(5.0, 0.3, 0.0));
    let mut bench = father(&[first, second]);
    let plan = |bench: &mut Bench<Navigate>, second| {
        let mut path = Path::default();
        path.header.stamp = Duration::from_secs(second).into();
        let pose = Pose2D::new(4.5, 0.0, 0.0).into();
        let header = path.header;
        path.poses.push(PoseStamped { header, pose }).expect("it fits");
        bench.import("path", &path);
        bench.set_now(Duration::from_secs(second + 1));
    };
    iterate_at(&mut bench, 0.0, 0.0);
    plan(&mut bench, 1);
    assert_eq!(iterate_at(&mut bench, 4.4, 0.0).reached, 0, "none may end before");
    assert_eq!(
        bench.modulated::<f64>("plan", "tolerance"),
        None,
        "the planner's own is in force"
    );
    bench.set("nearby", 0.6);
    assert_eq!(
        iterate_at(&mut bench, 4.1, 0.0).reached,
        0,
        "it is not at the end"
    );
    assert_eq!(bench.modulated("plan", "tolerance"), Some(0.6));
    bench.set("nearby", 0.0);
    iterate_at(&mut bench, 4.1, 0.0);
    assert_eq!(bench.modulated("plan", "tolerance"), Some(0.0), "it follows");
    bench.set("nearby", 0.6);
    assert_eq!(iterate_at(&mut bench, 4.4, 0.0).reached, 1);
    assert_eq!(
        iterate_at(&mut bench, 4.4, 0.0).reached,
        1,
        "it is not the path to the second target"
    );
    plan(&mut bench, 3);
    assert_eq!(iterate_at(&mut bench, 4.4, 0.0).reached, 2, "it is");
}

#[test]
fn poses_that_are_no_numbers_or_jump_and_a_gap_in_time_neither_reach_nor_give_up_a_target() {
    let mut bench = father(&[Pose2D::new(9.0, 0.0, 0.0)]);
    bench.set("patience", 3.0);
    let nowhere = Odometry::planar(Time::default(), Pose2D::new(f64::NAN, 0.0, 0.0), Twist::ZERO);
    bench.import("pose", &nowhere);
    bench.iterate().expect("the iteration succeeds");
    // Of the gap of an hour, no time counts; the jump back counts as a way that takes less than its patience.
    for (second, x) in [
        (1, 0.0),
        (2, 1.0),
        (3, 2.0),
        (4, 3.0),
        (3605, 3.0),
        (3606, -500.0),
        (3607, 4.0),
    ] {
        bench.set_now(Duration::from_secs(second));
        assert_eq!(
            iterate_at(&mut bench, x, 0.0).state,
            Mission::RUNNING,
            "{second} s"
        );
        bench.import("pose", &nowhere);
        bench.iterate().expect("the iteration succeeds");
    }
    for second in 3608..3612 {
        bench.set_now(Duration::from_secs(second));
        iterate_at(&mut bench, 4.0, 0.0);
    }
    assert_eq!(iterate_at(&mut bench, 4.0, 0.0).state, Mission::FAILED);
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, line)| line.contains("it came no nearer than 5.00 m for 3 s"))
    );
}

#[test]
fn a_chosen_target_takes_the_place_of_the_route_and_ends_once() {
    let (first, second) = (Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(9.0, 0.0, 0.0));
    let mut bench = father(&[Pose2D::new(0.0, 5.0, 0.0)]);
    bench.set("patience", 3.0);
    bench.import("chosen", &Target::NONE);
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::RUNNING);
    assert_eq!(planned(&bench), None, "the route does not count");
    bench.import("chosen", &Target::at(first));
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).target, first);
    let at_first = iterate_at(&mut bench, 1.9, 0.0);
    assert_eq!((at_first.state, at_first.target), (Mission::DONE, first));
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0), at_first, "once");
    bench.import("chosen", &Target::at(second));
    for second in 1..6 {
        bench.set_now(Duration::from_secs(second));
        iterate_at(&mut bench, 2.0, 0.0);
    }
    let at_second = iterate_at(&mut bench, 2.0, 0.0);
    assert_eq!((at_second.state, at_second.target), (Mission::FAILED, second));
    assert!(at_second.note.as_str().contains("no nearer than 7.00 m"));
    assert_eq!(planned(&bench), None);
    bench.import("chosen", &Target::at(first));
    assert_eq!(
        iterate_at(&mut bench, 0.0, 0.0).state,
        Mission::RUNNING,
        "chosen again"
    );
    assert_eq!(iterate_at(&mut bench, 1.9, 0.0).state, Mission::DONE);
    bench.sleep().expect("it sleeps");
    bench.awake().expect("it awakes");
    assert_eq!(
        iterate_at(&mut bench, 0.0, 0.0).state,
        Mission::RUNNING,
        "a father that awakes drives there again"
    );
}

#[test]
fn a_chosen_target_that_ended_may_be_chosen_again_after_another_one_or_none() {
    let (first, second) = (Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(9.0, 0.0, 0.0));
    for between in [Target::at(second), Target::NONE] {
        let mut bench = father(&[]);
        bench.import("chosen", &Target::at(first));
        assert_eq!(iterate_at(&mut bench, 1.9, 0.0).state, Mission::DONE);
        bench.import("chosen", &between);
        let mission = iterate_at(&mut bench, 3.0, 0.0);
        assert_eq!(
            (mission.state, planned(&bench)),
            (Mission::RUNNING, between.get())
        );
        bench.import("chosen", &Target::at(first));
        let mission = iterate_at(&mut bench, 3.0, 0.0);
        assert_eq!((mission.state, planned(&bench)), (Mission::RUNNING, Some(first)));
    }
}

#[test]
fn a_route_that_failed_says_nothing_of_a_chosen_target() {
    let chosen = Pose2D::new(2.0, 0.0, 0.0);
    let mut bench = father(&[Pose2D::new(9.0, 0.0, 0.0)]);
    bench.set("patience", 1.0);
    for second in 0..3 {
        bench.set_now(Duration::from_secs(second));
        iterate_at(&mut bench, 0.0, 0.0);
    }
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::FAILED);
    bench.import("chosen", &Target::at(chosen));
    let mission = iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!((mission.state, mission.target), (Mission::RUNNING, chosen));
    assert_eq!(mission.note.as_str(), "");
}

#[test]
fn a_click_on_the_field_sends_the_robot_there_first() {
    let target = Pose2D::new(2.0, 0.0, 0.0);
    let mut bench = father(&[target]);
    let touch = Touch::Clicked {
        at: [1.0, 3.0, 0.0],
        button: Button::Primary,
    };
    bench.touch("field", touch).expect("the gesture is handled");
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(planned(&bench), Some(Pose2D::new(1.0, 3.0, 0.0)));
    bench
        .touch("clear", Touch::Pressed)
        .expect("the gesture is handled");
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(planned(&bench), Some(target));
}

#[test]
fn the_field_shows_the_zones_and_lanes_of_the_planner() {
    let mut bench = father(&[]);
    iterate_at(&mut bench, 0.0, 0.0);
    let count = |bench: &mut Bench<Navigate>| bench.draw().expect("the panel is drawn").shapes("field").len();
    let before = count(&mut bench);
    let points = Seq::from_slice(&[Point2D { x: 1.0, y: 1.0 }; 3]).expect("they fit");
    let zones = [Zone { corners: points }].into_iter().collect();
    let lanes = [Strip { width: 0.6, points }].into_iter().collect();
    bench.import("zones", &Zones { zones });
    bench.import("lanes", &Lanes { lanes });
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(count(&mut bench), before + 2);
}

#[test]
fn a_recovery_that_fails_gives_up_its_target_once_and_no_other() {
    let (first, second) = (Pose2D::new(2.0, 0.0, 0.0), Pose2D::new(2.0, 2.0, 0.0));
    let mut bench = father(&[first, second]);
    bench.set("skips", 1_u32);
    let recover = |bench: &mut Bench<Navigate>, state, target| {
        let note = Text::new("in vain: turned");
        bench.import(
            "recovery",
            &Mission {
                state,
                target,
                note,
                ..Mission::default()
            },
        );
    };
    recover(&mut bench, Mission::RUNNING, first);
    iterate_at(&mut bench, 0.0, 0.0);
    recover(&mut bench, Mission::FAILED, second);
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(planned(&bench), Some(first), "another target");
    recover(&mut bench, Mission::FAILED, first);
    bench.import("state", &Text::<160>::new("no way leads to the goal"));
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::RUNNING);
    assert_eq!(planned(&bench), Some(second), "once");
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, line)| line.contains("in vain: turned (no way leads to the goal)"))
    );
    recover(&mut bench, Mission::FAILED, second);
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::FAILED);
}

#[test]
fn a_planner_that_fails_gives_up_its_target_in_its_words() {
    let target = Pose2D::new(1000.0, 1000.0, 0.0);
    let mut bench = father(&[target]);
    bench.import("state", &Text::<160>::new("the goal is outside the map"));
    iterate_at(&mut bench, 0.0, 0.0);
    let failed = Mission {
        state: Mission::FAILED,
        target,
        note: Text::new("the goal is outside the map"),
        ..Mission::default()
    };
    bench.import("planning", &failed);
    assert_eq!(iterate_at(&mut bench, 0.0, 0.0).state, Mission::FAILED);
    let said = |line: &str| {
        line.contains(
            "gives up the target at 1000.00, 1000.00: the goal is outside the map; the mission fails",
        )
    };
    assert!(
        bench.log().iter().any(|(_, line)| said(line)),
        "{:?}",
        bench.log()
    );
}
