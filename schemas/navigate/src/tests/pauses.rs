//! While another schema drives, or a person, and after it; targets that are no places, and headings that are not reached.

use super::*;

fn at(bench: &mut Bench<Navigate>, second: u64) -> Mission {
    bench.set_now(Duration::from_secs(second));
    iterate_at(bench, 0.0, 0.0)
}

fn drives(bench: &Bench<Navigate>) -> bool {
    bench.awake_children().contains(&"drive")
}

fn failed(target: Pose2D) -> Mission {
    Mission {
        state: Mission::FAILED,
        target,
        ..Mission::default()
    }
}

#[test]
fn while_it_sleeps_the_planner_has_no_target() {
    let goal = Pose2D::new(2.0, 0.0, 0.0);
    let mut bench = father(&[goal]);
    bench.awake().expect("it awakes");
    iterate_at(&mut bench, 0.0, 0.0);
    bench.sleep().expect("it sleeps");
    assert_eq!(planned(&bench), None);
    bench.awake().expect("it awakes");
    iterate_at(&mut bench, 0.0, 0.0);
    assert_eq!(planned(&bench), Some(goal));
}

#[test]
fn while_a_sibling_drives_the_planner_has_no_target_and_what_failed_gives_up_none() {
    let goal = Pose2D::new(2.0, 0.0, 0.0);
    let mut bench = father(&[goal]);
    at(&mut bench, 1);
    bench.check().expect("it checks");
    assert_eq!(planned(&bench), Some(goal), "it is its turn");
    bench.set_now(Duration::from_secs(2));
    bench.import("planning", &failed(goal));
    bench.set_now(Duration::from_secs(3));
    bench.check().expect("it checks");
    assert_eq!(planned(&bench), None);
    assert_eq!(at(&mut bench, 40).state, Mission::RUNNING);
    assert_eq!(planned(&bench), Some(goal));
    bench.set_now(Duration::from_secs(41));
    bench.import("planning", &failed(goal));
    assert_eq!(at(&mut bench, 41).state, Mission::FAILED, "it fails again");
}

#[test]
fn after_a_pause_nobody_drives_before_the_planner_has_answered() {
    let state = |bench: &mut Bench<Navigate>, second, words| {
        bench.set_now(Duration::from_secs(second));
        bench.import("state", &Text::<160>::new(words));
    };
    let mut bench = father(&[Pose2D::new(2.0, 0.0, 0.0)]);
    state(&mut bench, 1, "a path of 2 m");
    at(&mut bench, 1);
    assert!(drives(&bench));
    for second in [1, 3] {
        bench.set_now(Duration::from_secs(second));
        bench.check().expect("it checks");
    }
    state(&mut bench, 4, "no target");
    at(&mut bench, 5);
    assert!(!drives(&bench));
    state(&mut bench, 6, "no way leads to the goal");
    at(&mut bench, 6);
    assert!(drives(&bench), "somebody may look for a way");
}

#[test]
fn a_chosen_target_that_is_no_place_is_given_up_once() {
    let mut bench = father(&[]);
    bench.import("chosen", &Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    at(&mut bench, 1);
    bench.import("chosen", &Target::at(Pose2D::new(f64::NAN, 0.0, 0.0)));
    for second in 2..5 {
        assert_eq!(at(&mut bench, second).state, Mission::FAILED);
        assert_eq!(planned(&bench), None, "not the former one");
        assert!(!drives(&bench));
    }
    let said = bench.log().iter().filter(|(_, line)| line.contains("not finite"));
    assert_eq!(said.count(), 1);
    bench.import("chosen", &Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    assert_eq!(at(&mut bench, 5).state, Mission::RUNNING);
}

#[test]
fn a_chosen_target_whose_heading_begins_to_count_is_turned_to() {
    let goal = Pose2D::new(0.0, 0.1, 3.0);
    let mut bench = father(&[]);
    bench.import("chosen", &Target::at(goal));
    assert_eq!(at(&mut bench, 1).state, Mission::DONE);
    bench.import("chosen", &Target::facing(goal));
    assert_eq!(at(&mut bench, 2).state, Mission::RUNNING);
    assert_eq!(target(&bench), Target::facing(goal));
}

#[test]
fn a_heading_that_nothing_turns_to_is_the_reason_to_give_up() {
    let mut bench = father(&[Pose2D::new(0.1, 0.0, 0.5)]);
    bench.set("patience", 3.0);
    let states: Vec<u8> = (1..6).map(|second| at(&mut bench, second).state).collect();
    assert_eq!(states.last(), Some(&Mission::FAILED));
    let says = |line: &str| line.contains("it is there, but 29 deg off its heading: `yaw_goal_tolerance`");
    assert!(
        bench.log().iter().any(|(_, line)| says(line)),
        "{:?}",
        bench.log()
    );
}
