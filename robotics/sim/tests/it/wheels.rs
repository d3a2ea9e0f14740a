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

#[test]
fn the_covariance_of_the_odometry_is_that_of_its_errors() {
    let text = "robots = { r = { start = { x = 0, y = 0 } } }";
    let runs = 400;
    let (mut squared, mut heading) = (0.0, 0.0);
    for seed in 0..runs {
        let config = RobotConfig {
            // So small that the propagation to first order holds.
            wheel_scale_sigma: 0.001,
            slip_sigma: 0.0005,
            ..RobotConfig::default()
        };
        let mut world = World::parse(text, "open.toml", seed).unwrap();
        let robot = world.add_robot("r", config).unwrap();
        for (until, angular) in [(4, 0.3), (8, -0.5), (12, 0.0)] {
            world.command(robot, Twist2::new(0.5, angular)).unwrap();
            world.advance_to(until * 1_000_000_000);
        }
        let (truth, measured) = (world.truth(robot).pose, world.odometry(robot).pose);
        let turn = (measured.heading - truth.heading).sin().asin();
        let error = [measured.x - truth.x, measured.y - truth.y, turn];
        let covariance = world.odometry_covariance(robot).pose;
        squared += normalized(error, covariance) / f64::from(runs as u32);
        heading += turn * turn / covariance[2][2] / f64::from(runs as u32);
    }
    // Means of distributions of 3 degrees of freedom and of 1, within five standard errors.
    let within = |mean: f64, degrees: f64| {
        (mean - degrees).abs() < 5.0 * (2.0 * degrees / f64::from(runs as u32)).sqrt()
    };
    assert!(
        within(squared, 3.0) && within(heading, 1.0),
        "{squared} {heading}"
    );
}

#[test]
fn a_reset_odometry_has_no_error_and_one_at_rest_only_that_of_its_ticks() {
    let text = "robots = { r = { start = { x = 0, y = 0 } } }";
    let mut world = World::parse(text, "open.toml", 3).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    world.command(robot, Twist2::new(0.5, 0.3)).unwrap();
    world.advance_to(5_000_000_000);
    let driven = world.odometry_covariance(robot);
    assert!(driven.pose[0][0] > 0.0 && driven.twist[0][0] > 0.0, "{driven:?}");
    world.command(robot, Twist2::default()).unwrap();
    world.advance_to(10_000_000_000);
    world.reset_odometry(robot);
    let rest = world.odometry_covariance(robot);
    assert_eq!(rest.pose, [[0.0; 3]; 3]);
    assert!(
        0.0 < rest.twist[0][0] && rest.twist[0][0] < driven.twist[0][0],
        "{rest:?}"
    );
}

/// Returns the error's square in units of its covariance, by Cramer's rule.
fn normalized(error: [f64; 3], covariance: [[f64; 3]; 3]) -> f64 {
    let determinant = |m: [[f64; 3]; 3]| {
        let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    let whole = determinant(covariance);
    let solved = [0, 1, 2].map(|column| {
        let mut replaced = covariance;
        for (row, error) in replaced.iter_mut().zip(error) {
            row[column] = error;
        }
        determinant(replaced) / whole
    });
    error
        .iter()
        .zip(solved)
        .map(|(error, solved)| error * solved)
        .sum()
}
