//! The motion of robots: arcs, limits, contacts, and independence of the size of time steps.

use std::f64::consts::PI;

use jde_sim::{Pose2, RobotConfig, RobotId, STEP_NS, Twist2, World};
use proptest::prelude::*;

const EMPTY: &str = "robots = { r = { start = { x = 0, y = 0 } } }";
const ROOM: &str = "
    walls   = [{ name = 'wall', points = [[0, 0], [4, 0], [4, 3], [0, 3]], closed = true }]
    boxes   = [{ name = 'box', center = [2.5, 0.8], size = [0.5, 0.4], angle_deg = 30 }]
    circles = [{ name = 'post', center = [3, 2.2], radius = 0.02 }]
    robots  = { r = { start = { x = 1, y = 1.5 } }, other = { start = { x = 2, y = 2.2 } } }";

fn world_with_robot(text: &str, config: RobotConfig) -> (World, RobotId) {
    let mut world = World::parse(text, "motion.toml", 7).unwrap();
    let robot = world.add_robot("r", config).unwrap();
    (world, robot)
}

/// Motors so strong that a command takes effect in the first step.
fn agile() -> RobotConfig {
    RobotConfig {
        linear_acceleration: 1e9,
        linear_deceleration: 1e9,
        angular_acceleration: 1e9,
        angular_deceleration: 1e9,
        ..RobotConfig::default()
    }
}

fn seconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

#[test]
fn a_constant_twist_draws_a_circle() {
    let (mut world, robot) = world_with_robot(EMPTY, agile());
    let (v, w) = (0.5, 0.8);
    world.command(robot, Twist2::new(v, w)).unwrap();
    world.advance_to(STEP_NS);
    // The robot accelerates in the first step. After it, the arc has the closed form.
    let Pose2 { x, y, heading } = world.truth(robot).pose;
    for step in 2..1000u64 {
        world.advance_to(step * STEP_NS);
        let turned = heading + w * (step - 1) as f64 * 0.01;
        let expected = [
            x + v / w * (turned.sin() - heading.sin()),
            y - v / w * (turned.cos() - heading.cos()),
        ];
        let pose = world.truth(robot).pose;
        assert!(
            (pose.x - expected[0]).abs() < 1e-9 && (pose.y - expected[1]).abs() < 1e-9,
            "{pose:?} {expected:?}"
        );
        assert!((pose.heading - turned).sin().abs() < 1e-9);
    }
}

#[test]
fn the_distance_under_acceleration_is_exact() {
    let (mut world, robot) = world_with_robot(EMPTY, RobotConfig::default());
    world.command(robot, Twist2::new(0.6, 0.0)).unwrap();
    // 2 s at 0.3 m/s² to 0.6 m/s, then 1 s at that speed.
    world.advance_to(seconds(3.0));
    let truth = world.truth(robot);
    assert!((truth.pose.x - (0.5 * 0.3 * 4.0 + 0.6)).abs() < 1e-9, "{truth:?}");
    assert!((truth.twist.linear - 0.6).abs() < 1e-12);
    // From 0.6 m/s it takes 2 s and 0.6 m to stop.
    world.command(robot, Twist2::default()).unwrap();
    world.advance_to(seconds(5.0));
    let truth = world.truth(robot);
    assert_eq!(truth.twist.linear, 0.0);
    assert!((truth.pose.x - 1.8).abs() < 1e-9, "{truth:?}");
}

#[test]
fn a_command_beyond_the_limits_is_clamped() {
    let (mut world, robot) = world_with_robot(EMPTY, agile());
    world.command(robot, Twist2::new(-50.0, 900.0)).unwrap();
    world.advance_to(seconds(1.0));
    let RobotConfig {
        max_linear,
        max_angular,
        ..
    } = *world.config(robot);
    assert_eq!(world.truth(robot).twist, Twist2::new(-max_linear, max_angular));
}

#[test]
fn a_command_that_is_not_finite_is_refused_and_changes_nothing() {
    let (mut world, robot) = world_with_robot(EMPTY, agile());
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    for invalid in [Twist2::new(f64::NAN, 0.0), Twist2::new(0.0, f64::INFINITY)] {
        let error = world.command(robot, invalid).unwrap_err().to_string();
        assert!(error.contains("robot `r`") && error.contains("finite"), "{error}");
    }
    world.advance_to(seconds(1.0));
    assert_eq!(world.truth(robot).twist, Twist2::new(0.5, 0.0));
}

#[test]
fn a_world_can_be_shared_between_threads() {
    fn shared<T: Send + Sync>(_: &T) {}
    shared(&world_with_robot(EMPTY, agile()).0);
}

#[test]
fn advancing_to_the_current_or_an_earlier_time_has_no_effect() {
    let (mut world, robot) = world_with_robot(EMPTY, RobotConfig::default());
    world.command(robot, Twist2::new(0.3, 0.1)).unwrap();
    world.advance_to(seconds(1.0));
    let before = world.truth(robot);
    world.advance_to(seconds(1.0));
    world.advance_to(seconds(0.2));
    assert_eq!((world.truth(robot), world.now()), (before, seconds(1.0)));
}

#[test]
fn a_robot_stops_at_a_wall_and_the_contact_counts_once() {
    let (mut world, robot) = world_with_robot(ROOM, agile());
    world.command(robot, Twist2::new(-1.0, 0.0)).unwrap();
    world.advance_to(seconds(5.0));
    let truth = world.truth(robot);
    assert!((truth.pose.x - 0.25).abs() < 1e-6, "{truth:?}");
    assert!(
        truth.contact && truth.stalled && truth.collisions == 1 && truth.twist.linear == 0.0,
        "{truth:?}"
    );
    let encoders = world.encoders(robot);
    world.advance_to(seconds(6.0));
    assert_eq!(world.encoders(robot), encoders, "the wheels stop with the robot");
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    world.advance_to(seconds(6.5));
    assert!(!world.truth(robot).contact && !world.truth(robot).stalled);
    world.command(robot, Twist2::new(-0.5, 0.0)).unwrap();
    world.advance_to(seconds(9.0));
    assert_eq!(world.truth(robot).collisions, 2);
}

#[test]
fn a_robot_that_moves_2_mm_away_is_still_in_the_same_contact() {
    let (mut world, robot) = world_with_robot(ROOM, agile());
    world.command(robot, Twist2::new(-1.0, 0.0)).unwrap();
    world.advance_to(seconds(5.0));
    // The robot moves one millimetre while it accelerates and one while it brakes.
    for speed in [0.2, 0.0] {
        world.command(robot, Twist2::new(speed, 0.0)).unwrap();
        world.advance_to(world.now() + STEP_NS);
    }
    let truth = world.truth(robot);
    assert!(
        (truth.clearance - 0.002).abs() < 1e-6 && truth.contact,
        "{truth:?}"
    );
    world.command(robot, Twist2::new(-0.2, 0.0)).unwrap();
    world.advance_to(seconds(6.0));
    assert_eq!(world.truth(robot).collisions, 1);
}

#[test]
fn a_robot_can_turn_on_the_spot_while_it_touches() {
    let (mut world, robot) = world_with_robot(ROOM, agile());
    world.command(robot, Twist2::new(-1.0, 0.0)).unwrap();
    world.advance_to(seconds(5.0));
    world.command(robot, Twist2::new(0.0, 1.0)).unwrap();
    world.advance_to(seconds(5.0 + PI));
    let truth = world.truth(robot);
    assert!(
        truth.pose.heading.abs() > 3.0 && truth.collisions == 1 && !truth.stalled,
        "{truth:?}"
    );
}

#[test]
fn two_robots_that_collide_stop_and_both_count_the_collision() {
    let (mut world, robot) = world_with_robot(ROOM, agile());
    let other = world.add_robot("other", agile()).unwrap();
    let (a, b) = (world.truth(robot).pose, world.truth(other).pose);
    world
        .command(robot, Twist2::new(0.0, f64::atan2(b.y - a.y, b.x - a.x)))
        .unwrap();
    world.advance_to(seconds(1.0));
    world.command(robot, Twist2::new(0.4, 0.0)).unwrap();
    world.advance_to(seconds(6.0));
    let (truth, other_truth) = (world.truth(robot), world.truth(other));
    assert!(
        (truth.pose.distance(other_truth.pose) - 0.5).abs() < 1e-6,
        "{truth:?} {other_truth:?}"
    );
    assert_eq!(
        (truth.collisions, other_truth.collisions, other_truth.stalled),
        (1, 1, false)
    );
}

fn command() -> impl Strategy<Value = (f64, f64, u64)> {
    (-1.5..1.5f64, -3.0..3.0f64, 1..800_000_000u64)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn robots_never_overlap_anything(commands in proptest::collection::vec((command(), command()), 1..40), strong in any::<bool>()) {
        let config = if strong { agile() } else { RobotConfig::default() };
        let (mut world, robot) = world_with_robot(ROOM, config.clone());
        let other = world.add_robot("other", config).unwrap();
        for ((v, w, pause), (other_v, other_w, _)) in commands {
            world.command(robot, Twist2::new(v, w)).unwrap();
            world.command(other, Twist2::new(other_v, other_w)).unwrap();
            for time in (world.now()..=world.now() + pause).step_by(STEP_NS as usize) {
                world.advance_to(time);
                for id in [robot, other] {
                    let truth = world.truth(id);
                    prop_assert!(truth.min_clearance >= 0.0, "{:?}", truth);
                    prop_assert!(truth.pose.x >= 0.25 && truth.pose.x <= 3.75, "{:?}", truth);
                    prop_assert!(truth.pose.y >= 0.25 && truth.pose.y <= 2.75, "{:?}", truth);
                }
                prop_assert!(world.truth(robot).pose.distance(world.truth(other).pose) >= 0.5);
            }
        }
    }

    #[test]
    fn speeds_change_no_faster_than_the_motors_allow(commands in proptest::collection::vec(command(), 1..20)) {
        let config = RobotConfig { linear_deceleration: 0.7, angular_deceleration: 3.0, ..RobotConfig::default() };
        let (mut world, robot) = world_with_robot(EMPTY, config.clone());
        let fits = |before: f64, after: f64, gain: f64, loss: f64| {
            let limit = if after.abs() > before.abs() { gain } else { loss };
            (after - before).abs() <= limit * 0.01 + 1e-12 && before * after >= 0.0
        };
        for (v, w, pause) in commands {
            world.command(robot, Twist2::new(v, w)).unwrap();
            for _ in 0..pause / STEP_NS {
                let before = world.truth(robot).twist;
                world.advance_to(world.now() + STEP_NS);
                let after = world.truth(robot).twist;
                prop_assert!(fits(before.linear, after.linear, config.linear_acceleration, 0.7), "{:?} {:?}", before, after);
                prop_assert!(fits(before.angular, after.angular, config.angular_acceleration, 3.0), "{:?} {:?}", before, after);
                prop_assert!(after.linear.abs() <= config.max_linear && after.angular.abs() <= config.max_angular);
            }
        }
    }

    #[test]
    fn a_run_does_not_depend_on_the_size_of_its_time_steps(
        commands in proptest::collection::vec(command(), 1..10),
        slices in proptest::collection::vec(1..200_000_000u64, 1..40),
    ) {
        let run = |slices: &[u64]| {
            let (mut world, robot) = world_with_robot(ROOM, RobotConfig::default());
            let mut end = 0;
            let mut slices = slices.iter().cycle();
            for (v, w, pause) in &commands {
                world.command(robot, Twist2::new(*v, *w)).unwrap();
                let start = end;
                end += pause / STEP_NS * STEP_NS;
                let mut time = start;
                while time < end {
                    time = (time + slices.next().unwrap()).min(end);
                    world.advance_to(time);
                }
                world.advance_to(end);
            }
            (world.now(), world.truth(robot), world.odometry(robot), world.encoders(robot))
        };
        prop_assert_eq!(run(&slices), run(&[u64::MAX / 4]));
    }
}
