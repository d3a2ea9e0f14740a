//! The inertial unit and the position sensor: what they measure of a motion, their statistics, and outages.

use jde_sim::{
    ImuConfig, ImuReading, LaserConfig, Pose2, PositionConfig, RobotConfig, RobotId, RobotModel, STEP_NS,
    Twist2, World,
};

const GRAVITY: f64 = 9.80665;

fn world() -> (World, RobotId) {
    let text = "bounds = { min = [-50, -50], max = [50, 50] }\n[robots.r]\nstart = { x = 0, y = 0 }";
    let mut world = World::parse(text, "open.toml", 11).unwrap();
    let config = RobotConfig {
        linear_acceleration: 0.5,
        angular_acceleration: 2.0,
        ..RobotConfig::default()
    };
    let robot = world.add_robot("r", config).unwrap();
    (world, robot)
}

fn exact() -> ImuConfig {
    ImuConfig {
        gyro_sigma: 0.0,
        gyro_bias: 0.0,
        accelerometer_sigma: 0.0,
        accelerometer_bias: 0.0,
        ..ImuConfig::default()
    }
}

#[track_caller]
fn near(found: ImuReading, turn: f64, [ahead, left]: [f64; 2]) {
    let pairs = found.angular_velocity.iter().chain(&found.linear_acceleration);
    for (found, expected) in pairs.zip([0.0, 0.0, turn, ahead, left, GRAVITY]) {
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
}

fn run(world: &mut World, robot: RobotId, twist: Twist2, seconds: f64) {
    world.command(robot, twist).unwrap();
    world.advance_to(world.now() + (seconds * 1e9) as u64);
}

#[test]
fn it_measures_accelerations_turn_rates_and_gravity() {
    let (mut world, robot) = world();
    let imu = exact();
    near(world.imu(robot, &imu).unwrap(), 0.0, [0.0, 0.0]);
    run(&mut world, robot, Twist2::new(1.0, 0.0), 1.0);
    near(world.imu(robot, &imu).unwrap(), 0.0, [0.5, 0.0]);
    run(&mut world, robot, Twist2::new(1.0, 0.0), 2.0);
    near(world.imu(robot, &imu).unwrap(), 0.0, [0.0, 0.0]);
    // In a bend to the left, the acceleration v·ω is to the left.
    run(&mut world, robot, Twist2::new(1.0, 0.8), 2.0);
    near(world.imu(robot, &imu).unwrap(), 0.8, [0.0, 0.8]);
    run(&mut world, robot, Twist2::new(0.0, 0.0), 0.2);
    let braking = world.imu(robot, &imu).unwrap();
    assert!(braking.linear_acceleration[0] < -0.29, "{braking:?}");
}

#[test]
fn away_from_the_centre_it_measures_its_own_acceleration_along_its_own_axes() {
    let (mut world, robot) = world();
    let ahead = ImuConfig {
        mount: Pose2::new(0.2, 0.1, 0.0),
        ..exact()
    };
    run(&mut world, robot, Twist2::new(0.0, 1.5), 0.2);
    // The turn rate grows by 2 rad/s² and is 0.4 rad/s.
    near(
        world.imu(robot, &ahead).unwrap(),
        0.4,
        [-2.0 * 0.1 - 0.16 * 0.2, 2.0 * 0.2 - 0.16 * 0.1],
    );
    run(&mut world, robot, Twist2::new(0.0, 1.5), 2.0);
    let turned = ImuConfig {
        mount: Pose2::new(0.2, 0.0, std::f64::consts::FRAC_PI_2),
        ..exact()
    };
    // The centre of the turn is to the left of a unit ahead of it that faces left.
    near(world.imu(robot, &turned).unwrap(), 1.5, [0.0, 2.25 * 0.2]);
}

#[test]
fn noise_has_its_sigma_and_each_axis_one_bias() {
    let imu = ImuConfig {
        gyro_sigma: 0.01,
        gyro_bias: 0.1,
        accelerometer_sigma: 0.05,
        accelerometer_bias: 0.5,
        ..ImuConfig::default()
    };
    let count = 4000;
    let (mut world, robot) = world();
    let mut sums = [[0.0; 2]; 6];
    for _ in 0..count {
        world.advance_to(world.now() + STEP_NS);
        let ImuReading {
            angular_velocity: [a, b, c],
            linear_acceleration: [d, e, f],
        } = world.imu(robot, &imu).unwrap();
        for (sums, value) in sums.iter_mut().zip([a, b, c, d, e, f - GRAVITY]) {
            *sums = [sums[0] + value, sums[1] + value * value];
        }
    }
    let statistics = sums.map(|[sum, squares]| {
        let mean = sum / f64::from(count);
        (mean, (squares / f64::from(count) - mean * mean).sqrt())
    });
    for (axis, (mean, sigma)) in statistics.into_iter().enumerate() {
        let (expected, bias) = if axis < 3 { (0.01, 0.1) } else { (0.05, 0.5) };
        assert!((sigma / expected - 1.0).abs() < 0.05, "axis {axis}: {sigma}");
        assert!(
            mean.abs() < 4.0 * bias && mean.abs() > 0.01 * bias,
            "axis {axis}: {mean}"
        );
    }
    // Over many robots, the biases have their own sigma.
    let squares: f64 = (0..300)
        .map(|seed| {
            let mut world = World::parse("[robots.r]\nstart = { x = 0, y = 0 }", "w.toml", seed).unwrap();
            let robot = world.add_robot("r", RobotConfig::default()).unwrap();
            let still = ImuConfig {
                gyro_sigma: 0.0,
                ..imu.clone()
            };
            world.imu(robot, &still).unwrap().angular_velocity[2].powi(2)
        })
        .sum();
    let sigma = (squares / 300.0).sqrt();
    assert!((sigma / 0.1 - 1.0).abs() < 0.15, "{sigma}");
}

#[test]
fn a_fix_has_its_sigma_at_the_antenna_and_the_frame_of_the_world() {
    let (mut world, robot) = world();
    world
        .place(robot, Pose2::new(3.0, -2.0, std::f64::consts::FRAC_PI_2))
        .unwrap();
    let sensor = PositionConfig {
        mount: [0.5, 0.25],
        sigma: 0.2,
        ..PositionConfig::default()
    };
    let mut errors = [[0.0; 2]; 2];
    let count = 4000;
    for _ in 0..count {
        world.advance_to(world.now() + STEP_NS);
        let fix = world
            .position(robot, &sensor)
            .unwrap()
            .expect("there is no outage");
        for (axis, antenna) in [2.75, -1.5].into_iter().enumerate() {
            let error = fix[axis] - antenna;
            errors[axis] = [errors[axis][0] + error, errors[axis][1] + error * error];
        }
    }
    for [sum, squares] in errors {
        let (mean, sigma) = (sum / f64::from(count), (squares / f64::from(count)).sqrt());
        assert!(
            mean.abs() < 0.02 && (sigma / 0.2 - 1.0).abs() < 0.05,
            "{mean} {sigma}"
        );
    }
}

#[test]
fn outages_have_their_share_and_last_whole_spans() {
    let (mut world, robot) = world();
    let sensor = PositionConfig {
        outage: 0.3,
        outage_time: 0.5,
        ..PositionConfig::default()
    };
    let mut spans = Vec::new();
    for _ in 0..600 {
        let mut fixes = 0;
        for _ in 0..50 {
            fixes += usize::from(world.position(robot, &sensor).unwrap().is_some());
            world.advance_to(world.now() + STEP_NS);
        }
        assert!(fixes == 0 || fixes == 50, "{fixes} fixes in a span");
        spans.push(fixes == 0);
    }
    let share = spans.iter().filter(|out| **out).count() as f64 / 600.0;
    assert!((share - 0.3).abs() < 0.06, "{share}");
}

#[test]
fn they_disturb_no_other_sensor_and_read_the_same_twice() {
    let (mut world, robot) = world();
    let laser = LaserConfig::default();
    let mut other = self::world().0;
    run(&mut world, robot, Twist2::new(0.5, 0.3), 1.0);
    run(&mut other, robot, Twist2::new(0.5, 0.3), 1.0);
    let (imu, position) = (ImuConfig::default(), PositionConfig::default());
    assert_eq!(world.imu(robot, &imu), world.imu(robot, &imu));
    assert_eq!(world.position(robot, &position), world.position(robot, &position));
    let mut ranges = [vec![0.0; laser.beams], vec![0.0; laser.beams]];
    world.laser(robot, &laser, &mut ranges[0]).unwrap();
    other.laser(robot, &laser, &mut ranges[1]).unwrap();
    assert_eq!(ranges[0], ranges[1]);
    assert_eq!(world.odometry(robot), other.odometry(robot));
}

#[test]
fn a_file_describes_them_and_its_faults_have_lines() {
    let robot = "
[footprint]
radius = 0.1
[drive]
kinematics = 'differential'
max_speed = 0.5
acceleration = 1
max_turn_deg = 90
turn_acceleration_deg = 180
[odometry]
track = 0.2
ticks_per_mm = 10
[imu]
mount = { x = 0.1, y = 0, heading_deg = 180 }
gyro_noise_deg = 1
accelerometer_bias = 0.3
rate = 100
[position]
mount = [0.1, 0]
noise = 1.5
outage = 0.2
rate = 5
";
    let model = RobotModel::parse(robot, "r.toml").unwrap();
    let (imu, position) = (
        model.imu.expect("it has one"),
        model.position.expect("it has one"),
    );
    assert_eq!(imu.period, Some(std::time::Duration::from_millis(10)));
    assert!((imu.config.gyro_sigma - 1f64.to_radians()).abs() < 1e-12);
    assert_eq!(imu.config.accelerometer_bias, 0.3);
    assert_eq!(
        imu.config.accelerometer_sigma,
        ImuConfig::default().accelerometer_sigma
    );
    assert_eq!((position.config.mount, position.config.sigma), ([0.1, 0.0], 1.5));
    assert_eq!((position.config.outage, position.config.outage_time), (0.2, 10.0));
    for (line, by, part) in [
        (
            "gyro_noise_deg = 1",
            "gyro_noise = 1",
            "r.toml:15:1: unknown key `gyro_noise` in `imu` of the robot\n    help: did you mean `gyro_noise_deg`?",
        ),
        (
            "outage = 0.2",
            "outage = 20",
            "r.toml:21:10: `outage` of `position` of the robot is 20: expected 0 to 1",
        ),
        (
            "noise = 1.5",
            "noise = -1",
            "r.toml:20:9: `noise` of `position` of the robot is -1: expected 0 to 1000 m",
        ),
    ] {
        let error = RobotModel::parse(&robot.replace(line, by), "r.toml").expect_err("it has a fault");
        assert!(error.to_string().contains(part), "{error}");
    }
    let (world, robot) = world();
    let wrong = ImuConfig {
        gyro_bias: f64::NAN,
        ..ImuConfig::default()
    };
    assert!(world.imu(robot, &wrong).is_err());
    let wrong = PositionConfig {
        outage: 2.0,
        ..PositionConfig::default()
    };
    assert!(world.position(robot, &wrong).is_err());
}
