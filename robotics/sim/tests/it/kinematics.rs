//! Kinematics: omnidirectional robots, cars, and motors that lag.

use std::f64::consts::FRAC_PI_2;

use jde_sim::{Footprint, Kinematics, Pose2, RobotConfig, RobotId, STEP_NS, Twist2, World};
use proptest::prelude::*;

const ROOM: &str = "
    walls  = [{ name = 'wall', points = [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed = true }]
    robots = { r = { start = { x = 0, y = 0, heading_deg = 90 } } }";
const EMPTY: &str = "robots = { r = { start = { x = 0, y = 0, heading_deg = 90 } } }";

const WHEELBASE: f64 = 0.3;

/// Motors so strong that a command takes effect in the first step, and perfect wheels.
fn agile(kinematics: Kinematics) -> RobotConfig {
    RobotConfig {
        kinematics,
        linear_acceleration: 1e9,
        linear_deceleration: 1e9,
        angular_acceleration: 1e9,
        angular_deceleration: 1e9,
        wheel_scale_sigma: 0.0,
        slip_sigma: 0.0,
        ..RobotConfig::default()
    }
}

fn omnidirectional() -> RobotConfig {
    agile(Kinematics::Omnidirectional {
        max_lateral: 0.5,
        lateral_acceleration: 1e9,
    })
}

fn car() -> RobotConfig {
    agile(Kinematics::Car {
        wheelbase: WHEELBASE,
        max_steering: 0.5,
        steering_rate: 1e9,
    })
}

fn world_with(text: &str, config: RobotConfig) -> (World, RobotId) {
    let mut world = World::parse(text, "kinematics.toml", 7).unwrap();
    let robot = world.add_robot("r", config).unwrap();
    (world, robot)
}

fn run(world: &mut World, seconds: f64) {
    world.advance_to(world.now() + (seconds * 1e9).round() as u64);
}

fn sideways(linear: f64, lateral: f64, angular: f64) -> Twist2 {
    Twist2 {
        linear,
        lateral,
        angular,
    }
}

#[track_caller]
fn near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} is not {expected}"
    );
}

#[test]
fn an_omnidirectional_robot_moves_to_the_side_within_its_limit() {
    let (mut world, robot) = world_with(EMPTY, omnidirectional());
    world.command(robot, sideways(0.0, 2.0, 0.0)).unwrap();
    run(&mut world, 2.0);
    let truth = world.truth(robot);
    // It faces along y, so its left is at negative x. Half of the first step is lost.
    near(truth.pose.x, -0.9975, 1e-9);
    near(truth.pose.y, 0.0, 1e-9);
    near(truth.pose.heading, FRAC_PI_2, 0.0);
    assert_eq!(truth.twist, sideways(0.0, 0.5, 0.0));
    near(truth.travelled, 0.9975, 1e-9);
    near(world.odometry(robot).pose.y, 0.9975, 1e-4);
    near(world.odometry(robot).twist.lateral, 0.5, 1e-3);
}

#[test]
fn an_omnidirectional_robot_that_turns_while_it_moves_sideways_circles_a_point_ahead_or_behind() {
    let (mut world, robot) = world_with(EMPTY, omnidirectional());
    world.command(robot, sideways(0.0, 0.4, 0.8)).unwrap();
    world.advance_to(STEP_NS);
    let start = world.truth(robot).pose;
    // The velocity to the left and a left turn: the centre is 0.5 m behind.
    let center = start.compose(Pose2::new(-0.5, 0.0, 0.0));
    for _ in 0..500 {
        run(&mut world, 0.01);
        near(world.truth(robot).pose.distance(center), 0.5, 1e-9);
    }
    let expected = world.odometry(robot).pose;
    let pose = Pose2::new(0.0, 0.0, FRAC_PI_2).compose(expected);
    assert!(pose.distance(world.truth(robot).pose) < 1e-3);
}

#[test]
fn a_differential_robot_ignores_a_lateral_command() {
    let (mut world, robot) = world_with(EMPTY, agile(Kinematics::Differential));
    world.command(robot, sideways(0.2, 0.4, 0.0)).unwrap();
    run(&mut world, 1.0);
    assert_eq!(world.truth(robot).twist, Twist2::new(0.2, 0.0));
}

#[test]
fn a_robot_that_moves_sideways_stops_at_a_wall() {
    let (mut world, robot) = world_with(ROOM, omnidirectional());
    world.command(robot, sideways(0.0, 0.5, 0.0)).unwrap();
    run(&mut world, 8.0);
    let truth = world.truth(robot);
    near(truth.pose.x, -2.75, 1e-6);
    assert!(
        truth.stalled && truth.collisions == 1 && truth.twist == Twist2::default(),
        "{truth:?}"
    );
}

#[test]
fn a_car_drives_the_curvature_of_the_command_at_any_speed() {
    for (linear, angular) in [(0.5, 0.4), (-0.5, 0.4), (50.0, -40.0)] {
        let (mut world, robot) = world_with(EMPTY, car());
        world.command(robot, Twist2::new(linear, angular)).unwrap();
        run(&mut world, 0.02);
        let pose = world.truth(robot).pose;
        let radius = linear / angular;
        let center = pose.compose(Pose2::new(0.0, radius, 0.0));
        for _ in 0..200 {
            run(&mut world, 0.01);
            near(world.truth(robot).pose.distance(center), radius.abs(), 1e-9);
        }
        let truth = world.truth(robot);
        near(truth.twist.linear, linear.clamp(-1.2, 1.2), 1e-12);
        near(truth.twist.angular, truth.twist.linear / radius, 1e-12);
    }
}

#[test]
fn a_car_turns_no_tighter_than_its_steering_and_never_on_the_spot() {
    let (mut world, robot) = world_with(EMPTY, car());
    world.command(robot, Twist2::new(0.3, 10.0)).unwrap();
    run(&mut world, 1.0);
    near(
        world.truth(robot).twist.angular,
        0.3 * 0.5f64.tan() / WHEELBASE,
        1e-12,
    );
    world.command(robot, Twist2::new(0.0, 1.0)).unwrap();
    run(&mut world, 1.0);
    let before = world.truth(robot);
    assert_eq!(before.twist, Twist2::default());
    run(&mut world, 1.0);
    assert_eq!(world.truth(robot), before);
}

#[test]
fn a_car_at_a_wall_neither_drives_nor_turns() {
    let (mut world, robot) = world_with(ROOM, car());
    world.command(robot, Twist2::new(0.5, 0.05)).unwrap();
    run(&mut world, 12.0);
    let before = world.truth(robot);
    assert!(
        before.stalled && before.collisions == 1 && before.twist == Twist2::default(),
        "{before:?}"
    );
    let odometry = world.odometry(robot).pose;
    run(&mut world, 1.0);
    assert_eq!(
        (world.truth(robot).pose, world.odometry(robot).pose),
        (before.pose, odometry)
    );
}

#[test]
fn steered_wheels_turn_at_their_rate() {
    let config = agile(Kinematics::Car {
        wheelbase: WHEELBASE,
        max_steering: 0.5,
        steering_rate: 0.5,
    });
    let (mut world, robot) = world_with(EMPTY, config);
    world.command(robot, Twist2::new(1.0, 100.0)).unwrap();
    run(&mut world, 0.4);
    near(world.truth(robot).twist.angular, 0.2f64.tan() / WHEELBASE, 1e-9);
    run(&mut world, 1.0);
    near(world.truth(robot).twist.angular, 0.5f64.tan() / WHEELBASE, 1e-9);
}

#[test]
fn a_lagging_motor_follows_an_exponential_and_comes_to_rest() {
    let config = RobotConfig {
        lag: 0.2,
        ..agile(Kinematics::Differential)
    };
    let (mut world, robot) = world_with(EMPTY, config);
    world.command(robot, Twist2::new(0.5, 1.0)).unwrap();
    run(&mut world, 0.2);
    let reached = 1.0 - (-1.0f64).exp();
    near(world.truth(robot).twist.linear, 0.5 * reached, 1e-9);
    near(world.truth(robot).twist.angular, reached, 1e-9);
    world.command(robot, Twist2::default()).unwrap();
    run(&mut world, 5.0);
    assert_eq!(world.truth(robot).twist, Twist2::default());
}

#[test]
fn numbers_out_of_range_are_refused() {
    let invalid = [f64::NAN, f64::INFINITY, 0.0, -1.0];
    for value in invalid {
        let car = |wheelbase, max_steering, steering_rate| Kinematics::Car {
            wheelbase,
            max_steering,
            steering_rate,
        };
        let omni = |max_lateral, lateral_acceleration| Kinematics::Omnidirectional {
            max_lateral,
            lateral_acceleration,
        };
        for kinematics in [
            car(value, 0.5, 1.0),
            car(0.3, value, 1.0),
            car(0.3, 0.5, value),
            omni(value, 1.0),
            omni(1.0, value),
        ] {
            let config = RobotConfig {
                kinematics,
                ..RobotConfig::default()
            };
            assert!(config.check().is_err(), "{kinematics:?}");
        }
    }
    assert!(
        RobotConfig {
            lag: -1.0,
            ..RobotConfig::default()
        }
        .check()
        .is_err()
    );
    let (mut world, robot) = world_with(EMPTY, omnidirectional());
    assert!(world.command(robot, sideways(0.0, f64::NAN, 0.0)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn no_kinematics_overlap_anything_or_exceed_their_limits(
        commands in proptest::collection::vec((-2.0..2.0f64, -2.0..2.0f64, -4.0..4.0f64), 1..30),
        kind in 0..4u8,
        polygon in any::<bool>(),
    ) {
        let mut config = match kind {
            0 => agile(Kinematics::Differential),
            1 => omnidirectional(),
            2 => car(),
            _ => RobotConfig { lag: 0.15, ..omnidirectional() },
        };
        if polygon {
            config.footprint = Footprint::polygon(&[[0.5, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.5, -0.2]]).unwrap();
        }
        let (mut world, robot) = world_with(ROOM, config.clone());
        for (linear, lateral, angular) in commands {
            world.command(robot, sideways(linear, lateral, angular)).unwrap();
            for _ in 0..60 {
                run(&mut world, 0.01);
                let truth = world.truth(robot);
                prop_assert!(truth.min_clearance >= 0.0, "{:?}", truth);
                prop_assert!(truth.twist.linear.abs() <= config.max_linear && truth.twist.lateral.abs() <= 0.5);
                prop_assert!(truth.twist.angular.abs() <= config.max_angular);
                if kind == 2 {
                    let tightest = 0.5f64.tan() / WHEELBASE * truth.twist.linear.abs();
                    prop_assert!(truth.twist.angular.abs() <= tightest + 1e-12, "{:?}", truth);
                }
            }
        }
    }
}
