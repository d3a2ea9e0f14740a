//! What is not known is not exported: sensors that lie, contradict each other or fall silent, and robots that were carried.

use super::*;

#[test]
fn a_robot_that_was_carried_and_turned_is_where_its_antenna_and_its_compass_say() {
    let mut robot = Robot::new(&["odom", "imu", "position"]);
    robot.compass = Some(0.001);
    robot.antenna = 1.0;
    robot.bench.set("antenna_x", 1.0);
    robot.bench.set("imu_heading", HeadingUse::Absolute);
    robot.go_with_fixes(60, 0.0, 0.0);
    robot.is_right(0.1);
    robot.truth = robot.truth.transform(&Pose2D::new(10.0, 5.0, 2.0));
    for _ in 0..200 {
        robot.go_with_fixes(1, 0.3, 0.2);
        let Some(odometry) = robot.odometry() else {
            continue;
        };
        let error = robot.truth.localize(&odometry.pose2d());
        let is_before = error.x.hypot(error.y) > 8.0;
        assert!(
            is_before || error.theta.abs() < 0.2,
            "{error:?}: {}",
            robot.words()
        );
    }
    robot.is_right(0.3);
}

#[test]
fn a_compass_that_states_that_it_knows_no_heading_gives_none() {
    for variance in [-1.0, core::f64::consts::PI.powi(2)] {
        let mut robot = Robot::new(&["odom", "imu", "position"]);
        robot.compass = Some(variance);
        robot.bench.set("imu_heading", HeadingUse::Absolute);
        robot.go_with_fixes(60, 0.0, 0.0);
        assert_eq!(robot.odometry(), None);
        robot.says(if variance < 0.0 {
            "no orientation"
        } else {
            "does not know the heading"
        });
    }
}

#[test]
fn a_place_that_is_old_begins_nothing() {
    let mut robot = Robot::new(&["odom", "imu", "pose"]);
    robot.pose(1.0);
    robot.now += Duration::from_secs(20);
    robot.step(0.0, 0.0);
    assert_eq!(robot.odometry(), None);
    robot.says("s old");
    robot.pose(1.0);
    robot.go(3, 0.0, 0.0);
    robot.is_right(0.05);
}

#[test]
fn positions_and_poses_that_contradict_each_other_are_no_place() {
    let mut robot = Robot::new(&["odom", "imu", "pose", "position"]);
    for _ in 0..60 {
        robot.pose(1.0);
        robot.go_with_fixes(1, 0.0, 0.0);
    }
    robot.is_right(0.1);
    robot.truth.x += 10.0;
    for _ in 0..200 {
        robot.pose(1.0);
        robot.go_with_fixes(1, 0.0, 0.0);
        let Some(odometry) = robot.odometry() else {
            continue;
        };
        assert!((odometry.pose2d().x - 1.0).abs() < 0.2, "{}", robot.words());
    }
    assert_eq!(robot.odometry(), None);
    robot.says("contradict each other");
}

#[test]
fn a_gyro_that_shows_no_turn_is_not_believed_although_its_unit_lives() {
    for (speed, rate, steps) in [(0.3, 0.2, 100), (0.3, 0.4, 150), (0.0, 0.06, 400)] {
        let mut robot = Robot::wheels_and_imu();
        robot.go(60, 0.0, 0.0);
        // Not to the bit: its last one may be noise.
        robot.scale = 0.0;
        robot.go(steps, speed, rate);
        assert_eq!(robot.odometry(), None, "{speed} {rate}: {}", robot.words());
        robot.says("wheels and gyro contradict each other");
    }
    for (speed, rate) in [(0.3, 0.2), (0.3, 0.4), (0.0, 1.0)] {
        // To the bit, while the accelerations are noise: the wheels go on, if they can.
        let mut robot = Robot::wheels_and_imu();
        robot.go(60, 0.0, 0.0);
        robot.frozen = Some(BIAS);
        robot.go(60, speed, rate);
        robot.says("turn rates of the IMU repeat themselves");
        match robot.odometry() {
            Some(odometry) => {
                let shown = odometry.twist.twist.angular.z;
                assert!((shown - rate).abs() < 0.07, "{speed} {rate}: {shown}");
            }
            // Before it was noticed, the constants were spoilt.
            None => robot.says("wheels and gyro contradict each other"),
        }
    }
}

#[test]
fn an_imu_upside_down_contradicts_the_wheels() {
    let mut robot = Robot::wheels_and_imu();
    robot.scale = -1.0;
    robot.go(60, 0.0, 0.0);
    robot.go(120, 0.3, 0.5);
    assert_eq!(robot.odometry(), None);
    robot.says("wheels and gyro contradict each other");
    robot.go(120, 0.0, 0.0);
    assert_eq!(robot.odometry(), None, "nobody knows its heading");
}

#[test]
fn wheels_that_fall_silent_at_standstill_leave_no_odometry() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.has_wheels = false;
    robot.go(30, 0.0, 0.0);
    assert_eq!(robot.odometry(), None);
    robot.says("the speed may be off");
}

#[test]
fn a_bias_that_changed_is_learned_anew_at_standstill_and_a_hand_is_none() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.bias += 0.04;
    robot.go(40, 0.0, 0.0);
    assert_eq!(robot.odometry(), None);
    robot.says("although the wheels stand");
    robot.go(200, 0.0, 0.0);
    let bias: f64 = robot.bench.exported("gyro_bias").expect("a bias");
    assert!((bias - robot.bias).abs() < 0.002, "{bias}");
    let before = robot.odometry().expect("it stands").pose2d().theta;
    robot.go(100, 0.0, 0.0);
    let after = robot.odometry().expect("it stands").pose2d().theta;
    assert!((after - before).abs() < 0.005, "{before} {after}");
    // A hand turns it to and fro.
    for step in 0..100 {
        let by_hand = 0.1 * (f64::from(step) * 0.1).sin();
        robot.bias += by_hand;
        robot.step(0.0, 0.0);
        robot.bias -= by_hand;
    }
    robot.go(100, 0.0, 0.0);
    let bias: f64 = robot.bench.exported("gyro_bias").expect("a bias");
    assert!((bias - robot.bias).abs() < 0.003, "{bias}");
}

#[test]
fn without_positions_for_long_a_place_is_not_known() {
    let mut robot = Robot::new(&["odom", "imu", "position"]);
    robot
        .bench
        .set("initial_pose", Start::at(Pose2D::new(1.0, 2.0, 0.5)));
    robot.bench.set("max_position_deviation", 0.3);
    robot.go_with_fixes(60, 0.0, 0.0);
    robot.is_right(0.1);
    robot.go(600, 0.5, 0.0);
    assert_eq!(robot.odometry(), None, "{}", robot.words());
    robot.says("the position may be off");
}

#[test]
fn an_imu_that_measures_too_seldom_to_notice_slip_says_so() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    for step in 0..60 {
        robot.has_imu = step % 5 == 0;
        robot.step(0.3, 0.1);
    }
    robot.says("too seldom");
    robot.is_right(0.1);
}

#[test]
fn after_a_reload_what_was_not_known_is_not_exact() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.go(100, 0.3, 0.2);
    let before = robot.odometry().expect("a pose").pose.covariance;
    let saved = robot.bench.save().expect("it saves");
    for jump in [0.0, 5.0] {
        let mut next = Robot::wheels_and_imu();
        next.bench.restore(&saved).expect("it restores");
        next.bench.awake().expect("it awakes");
        (next.now, next.wheels) = (robot.now, robot.wheels);
        next.wheels.x += jump;
        next.go(2, 0.0, 0.0);
        let odometry = next.odometry().expect("a pose");
        let after = odometry.pose.covariance;
        if jump > 0.0 {
            // Its wheels count anew: where it was is not known.
            let begun = odometry.pose2d();
            assert!(begun.distance_to(&next.wheels) < 0.01, "{begun:?}");
        } else {
            assert!(after[0] >= 0.9 * before[0].max(before[7]), "{after:?} {before:?}");
            assert!(after[35] >= 0.9 * before[35], "{after:?} {before:?}");
        }
    }
}

#[test]
fn a_pose_that_repeats_itself_while_the_wheels_move_is_none() {
    let mut robot = Robot::new(&["odom", "imu", "pose"]);
    for _ in 0..60 {
        robot.pose(1.0);
        robot.go(1, 0.0, 0.0);
    }
    for _ in 0..200 {
        robot.pose(1.0);
        robot.go(1, 0.3, 0.0);
    }
    robot.says("the poses repeat themselves");
    robot.is_right(0.35);
}

#[test]
fn after_a_jump_during_a_sleep_an_initial_pose_holds_no_more() {
    let mut robot = Robot::wheels_and_imu();
    robot
        .bench
        .set("initial_pose", Start::at(Pose2D::new(1.0, 2.0, 0.5)));
    robot.go(60, 0.0, 0.0);
    robot.is_right(0.01);
    robot.bench.sleep().expect("it sleeps");
    robot.bench.awake().expect("it awakes");
    robot.go(10, 0.0, 0.0);
    robot.is_right(0.01);
    robot.bench.sleep().expect("it sleeps");
    robot.wheels.x += 5.0;
    robot.bench.awake().expect("it awakes");
    robot.go(10, 0.0, 0.0);
    assert_eq!(robot.odometry(), None);
    robot.says("is not known");
}
