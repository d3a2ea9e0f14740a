//! When a robot is searched on the map, and when it is sure again.

use super::*;

#[test]
fn it_is_found_anywhere_and_then_sure() {
    let mut robot = Robot::new(START, None);
    robot.step(0.0, 0.0);
    robot.says_nothing("");
    robot.drive(60);
    robot.is_right();
}

#[test]
fn a_robot_that_is_carried_away_is_lost_and_found_again() {
    let mut robot = tracked();
    let carried = Pose2D::new(4.5, 3.0, -2.0);
    // The odometry notices nothing.
    robot.start = carried.transform(&robot.truth.localize(&robot.start));
    robot.truth = carried;
    (0..8).for_each(|_| robot.step(0.0, 0.02));
    robot.says_nothing("not sure");
    robot.drive(80);
    robot.is_right();
}

#[test]
fn a_robot_that_is_sure_again_is_not_searched_any_more() {
    let mut robot = tracked();
    robot.bench.set("search_step", 1000_u32);
    let truth = robot.truth;
    // Something stands before the laser.
    let mut hidden = scan(&truth);
    hidden.ranges.as_mut_slice().fill(0.2);
    for _ in 0..12 {
        robot.bench.import("laser", &hidden);
        robot.iterate();
    }
    robot.says_nothing("not sure: only");
    (0..15).for_each(|_| robot.step(0.0, 0.0));
    for _ in 0..40 {
        robot.step(0.0, 0.0);
        robot.is_right();
    }
}

#[test]
fn a_crowd_that_hides_a_part_is_no_loss_and_one_that_hides_most_is() {
    let mut robot = tracked();
    let look = |robot: &mut Robot, hidden: usize, steps| {
        let mut crowd = scan(&robot.truth);
        crowd.ranges.as_mut_slice()[..hidden].fill(0.2);
        for _ in 0..steps {
            robot.bench.import("odometry", &robot.odometry());
            robot.bench.import("laser", &crowd);
            robot.iterate();
        }
        robot.words()
    };
    for (hidden, agree) in [(48, ": 60 %"), (72, ": 40 %")] {
        let words = look(&mut robot, hidden, 60);
        assert!(words.starts_with("sure to") && words.contains(agree), "{words}");
        robot.is_right();
    }
    robot.bench.set("sure_deviation", 0.0);
    let words = look(&mut robot, 72, 1);
    assert!(words.contains("the place is known to"), "{words}");
    robot.bench.set("sure_deviation", 0.3);
    look(&mut robot, 72, 60);
    robot.is_right();
    look(&mut robot, 100, 60);
    robot.says_nothing("not sure");
    robot.drive(60);
    robot.is_right();
}

/// The scan is one that is there once; the search needs some iterations.
#[test]
fn a_search_needs_no_new_scans() {
    let mut robot = Robot::new(START, None);
    robot.bench.set("search_step", 5000_u32);
    robot.step(0.0, 0.0);
    robot.says_nothing("searched on the map");
    (0..9).for_each(|_| robot.iterate());
    robot.says_nothing("not been compared");
    robot.step(0.0, 0.0);
    robot.says_nothing("must move by another 1.0 m");
    robot.drive(60);
    robot.is_right();
}

#[test]
fn a_wrong_initial_pose_is_not_believed() {
    for wrong in [
        Pose2D::new(4.6, 3.0, 2.0),
        Pose2D::new(-30.0, 1.0, 0.0),
        Pose2D::new(1e9, 0.0, 0.0),
        Pose2D::new(3.8, 1.0, 0.0),
    ] {
        let mut robot = Robot::new(START, Some(wrong));
        for _ in 0..80 {
            robot.step(0.06, 0.1);
            let away = robot.pose().map(|pose| pose.pose2d().distance_to(&robot.truth));
            assert!(
                away.is_none_or(|away| away < 0.3),
                "{wrong:?}: sure and {away:?} m away"
            );
        }
        robot.is_right();
    }
}

/// A place that is not sure does not become what a person said, by another map or by a reload.
#[test]
fn a_place_that_is_not_known_is_searched_on_the_next_map_and_after_a_reload() {
    let mut robot = Robot::new(START, Some(START));
    robot.step(0.0, 0.0);
    let touch = Touch::Clicked {
        at: [1.4, 1.4, 0.0],
        button: Button::Primary,
    };
    robot.bench.touch("map", touch).expect("the gesture is handled");
    (0..3).for_each(|_| robot.step(0.0, 0.0));
    robot.says_nothing("must move by another 1.0 m");
    let saved = robot.bench.save().expect("it saves");
    let mut reloaded = Robot::new(START, Some(START));
    reloaded.bench.restore(&saved).expect("it restores");
    for robot in [&mut robot, &mut reloaded] {
        robot.bench.set("search_step", 1000_u32);
        robot.bench.import("map", &*room());
        robot.step(0.0, 0.0);
        robot.says_nothing("searched on the map");
    }
}
