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
fn one_doubtful_scan_in_a_crowd_is_no_loss() {
    let mut robot = tracked();
    let mut crowd = scan(&robot.truth);
    crowd.ranges.as_mut_slice()[..48].fill(0.2);
    let look = |robot: &mut Robot, steps| {
        for _ in 0..steps {
            robot.bench.import("laser", &crowd);
            robot.iterate();
        }
        robot.words()
    };
    let words = look(&mut robot, 30);
    assert!(
        words.starts_with("sure to") && words.contains(": 60 %"),
        "{words}"
    );
    robot.bench.set("sure_deviation", 0.0);
    let words = look(&mut robot, 1);
    assert!(words.contains("the place is known to"), "{words}");
    robot.bench.set("sure_deviation", 0.3);
    let words = look(&mut robot, 99);
    assert!(words.contains("only 60 % of the beams agree"), "{words}");
    (0..10).for_each(|_| robot.step(0.0, 0.0));
    // A robot that was searched would have to move first.
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
