//! Line sensors: what a cell sees where, its noise, and how a robot file describes it.

use jde_sim::{LineSensorConfig, Pose2, RobotConfig, RobotId, RobotModel, World};

const STEP: u64 = jde_sim::STEP_NS;

/// A white floor with a black line of 2 cm along x, and a robot at the origin that faces along x.
fn world() -> (World, RobotId) {
    let text = "floor = '#ffffff'
        [[floor_lines]]
        points = [[-3, 0], [3, 0]]
        color  = '#000000'
        [robots.r]
        start = { x = 0, y = 0 }";
    let mut world = World::parse(text, "line.toml", 7).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

fn sensor(mounts: &[[f64; 2]], sigma: f64) -> LineSensorConfig {
    LineSensorConfig {
        mounts: mounts.to_vec(),
        spot: 0.004,
        sigma,
        stream: 0,
    }
}

fn read(world: &World, robot: RobotId, sensor: &LineSensorConfig) -> Vec<f32> {
    let mut brightness = vec![0.5; sensor.mounts.len()];
    world.line_sensor(robot, sensor, &mut brightness).unwrap();
    brightness
}

#[test]
fn a_cell_sees_the_part_of_its_spot_that_the_line_covers() {
    let (mut world, robot) = world();
    let cells = [
        [0.1, 0.05],
        [0.1, 0.012],
        [0.1, 0.011],
        [0.1, 0.01],
        [0.1, 0.009],
        [0.1, 0.0],
        [0.1, -0.01],
        [0.1, -0.013],
    ];
    let expected = [1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.5, 1.0];
    for turn in [0.0, std::f64::consts::PI] {
        world.place(robot, Pose2::new(0.5, 0.0, turn)).unwrap();
        for (found, expected) in read(&world, robot, &sensor(&cells, 0.0)).iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-6,
                "{found} instead of {expected} at {turn}"
            );
        }
    }
    // Across the line, a cell ahead of the robot leaves it.
    world
        .place(robot, Pose2::new(0.5, 0.0, std::f64::consts::FRAC_PI_2))
        .unwrap();
    let found = read(
        &world,
        robot,
        &sensor(&[[0.1, 0.0], [0.0, 0.1], [0.01, 0.0]], 0.0),
    );
    assert!(
        found[0] == 1.0 && found[1] < 1e-6 && (found[2] - 0.5).abs() < 1e-6,
        "{found:?}"
    );
}

#[test]
fn noise_has_its_sigma_and_disturbs_no_other_sensor() {
    let (mut world, robot) = world();
    // Half on the line, so that the limits of brightness are far.
    let sensor = sensor(&[[0.1, 0.01], [0.0, -0.01]], 0.05);
    let laser = jde_sim::LaserConfig::default();
    let (mut errors, mut ranges) = (Vec::new(), vec![0.0; laser.beams]);
    for _ in 0..2000 {
        world.advance_to(world.now() + STEP);
        world.laser(robot, &laser, &mut ranges).unwrap();
        let before = ranges.clone();
        let found = read(&world, robot, &sensor);
        assert_eq!(found, read(&world, robot, &sensor), "twice at one instant");
        errors.extend(found.iter().map(|found| f64::from(*found) - 0.5));
        world.laser(robot, &laser, &mut ranges).unwrap();
        assert_eq!(before, ranges);
    }
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let sigma = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
    assert!(
        mean.abs() < 0.003 && (sigma - 0.05).abs() < 0.003,
        "{mean} {sigma}"
    );
    // On the line, the noise does not lead below black.
    let dark = read(&world, robot, &self::sensor(&[[0.0, 0.0]; 200], 0.05));
    assert!(dark.iter().all(|brightness| (0.0..0.5).contains(brightness)) && dark.contains(&0.0));
}

#[test]
fn a_file_states_cells_spot_noise_and_rate_and_its_faults_have_lines() {
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
[line_sensor]
";
    let parse = |line: &str| RobotModel::parse(&format!("{robot}{line}"), "r.toml");
    let line = parse("mounts = [[0.1, 0.01], [0.1, -0.01]]\nspot = 0.01\nrate = 50\nnoise = 0.02");
    let line = line.unwrap().line_sensor.expect("it has one");
    assert_eq!(line.config.mounts, [[0.1, 0.01], [0.1, -0.01]]);
    assert_eq!((line.config.spot, line.config.sigma), (0.01, 0.02));
    assert_eq!(line.period, Some(std::time::Duration::from_millis(20)));
    for (wrong, parts) in [
        (
            "spot = 0.01",
            &["r.toml:13:", "`mounts` of `line_sensor` of the robot is missing"][..],
        ),
        ("mounts = []", &["r.toml:14:", "expected points"]),
        (
            "mounts = [[0, 0]]\nnoise = 2",
            &[
                "r.toml:15:",
                "`noise` of `line_sensor` of the robot is 2: expected 0 to 1",
            ],
        ),
        (
            "mounts = [[0, 0]]\nspots = 0.01",
            &["r.toml:15:", "did you mean `spot`?"],
        ),
    ] {
        let error = parse(wrong).expect_err("it has a fault");
        let faults: Vec<String> = error.faults().iter().map(ToString::to_string).collect();
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(parts.iter().all(|part| faults[0].contains(part)), "{}", faults[0]);
    }
}

#[test]
fn invalid_numbers_and_buffers_are_refused() {
    let (world, robot) = world();
    let valid = sensor(&[[0.1, 0.0]], 0.01);
    for (wrong, part) in [
        (sensor(&[], 0.0), "mounts"),
        (sensor(&[[f64::NAN, 0.0]], 0.0), "mount x"),
        (sensor(&[[0.0, 0.0]], -1.0), "sigma"),
        (
            LineSensorConfig {
                spot: 0.0,
                ..valid.clone()
            },
            "spot",
        ),
    ] {
        let mut brightness = vec![0.0; wrong.mounts.len()];
        let error = world.line_sensor(robot, &wrong, &mut brightness).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    assert!(world.line_sensor(robot, &valid, &mut [0.0; 2]).is_err());
}
