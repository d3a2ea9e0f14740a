//! The measurements of the wheels: odometry, ticks, drift and slip.

use jde_sim::{OdometryOrigin, Pose2, RobotConfig, Twist2, World};

#[test]
fn odometry_drifts_from_the_truth_with_the_ticks() {
    let config = RobotConfig {
        wheel_scale_sigma: 0.01,
        slip_sigma: 0.002,
        odometry_origin: OdometryOrigin::StartPose,
        ..RobotConfig::default()
    };
    let text = "robots = { r = { start = { x = 3, y = -1, heading_deg = 45 } } }";
    let mut world = World::parse(text, "open.toml", 8).unwrap();
    let robot = world.add_robot("r", config).unwrap();
    assert_eq!(world.odometry(robot).pose, world.truth(robot).pose);
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    world.advance_to(60_000_000_000);
    let (truth, odometry, ticks) = (world.truth(robot), world.odometry(robot), world.encoders(robot));
    let drift = truth.pose.distance(odometry.pose);
    assert!(drift > 0.01 && drift < 0.2 * truth.travelled, "{drift}");
    assert_ne!(ticks.left, ticks.right);
    let rolled = (ticks.left + ticks.right) as f64 / 2.0 / 128_000.0;
    assert!((rolled / truth.travelled - 1.0).abs() < 0.05, "{rolled}");
}

#[test]
fn odometry_of_perfect_wheels_is_exact_to_a_tick() {
    let config = RobotConfig {
        wheel_scale_sigma: 0.0,
        slip_sigma: 0.0,
        ..RobotConfig::default()
    };
    let text = "robots = { r = { start = { x = 3, y = -1, heading_deg = 45 } } }";
    let mut world = World::parse(text, "open.toml", 8).unwrap();
    let robot = world.add_robot("r", config).unwrap();
    let start = world.truth(robot).pose;
    assert_eq!(world.odometry(robot).pose, Pose2::default());
    world.command(robot, Twist2::new(0.5, 0.2)).unwrap();
    world.advance_to(20_000_000_000);
    let estimated = start.compose(world.odometry(robot).pose);
    let pose = world.truth(robot).pose;
    assert!(
        estimated.distance(pose) < 1e-3 && (estimated.heading - pose.heading).sin().abs() < 1e-4,
        "{estimated:?}"
    );
}

#[test]
fn the_deviation_of_slip_grows_with_the_root_of_the_distance() {
    let config = RobotConfig {
        wheel_scale_sigma: 0.0,
        slip_sigma: 0.01,
        ..RobotConfig::default()
    };
    let text = "robots = { r = { start = { x = 0, y = 0 } } }";
    let mut squares = [0.0; 2];
    let runs = 400;
    for seed in 0..runs {
        let mut world = World::parse(text, "open.toml", seed).unwrap();
        let robot = world.add_robot("r", config.clone()).unwrap();
        world.command(robot, Twist2::new(1.0, 0.0)).unwrap();
        for (index, time) in [5_000_000_000, 20_000_000_000].into_iter().enumerate() {
            world.advance_to(time);
            let distance = world.truth(robot).travelled;
            let error = world.encoders(robot).left as f64 / 128_000.0 - distance;
            squares[index] += error * error / distance / runs as f64;
        }
    }
    // The variance per metre is 1e-4, within five standard errors.
    for variance in squares {
        assert!(
            (variance / 1e-4 - 1.0).abs() < 5.0 * (2.0 / runs as f64).sqrt(),
            "{squares:?}"
        );
    }
}
