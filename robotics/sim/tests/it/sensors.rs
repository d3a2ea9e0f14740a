//! The laser and the sonars: directions, errors, and reading without side effects.

use jde_sim::{Footprint, LaserConfig, Pose2, RobotConfig, RobotId, SonarConfig, Twist2, World, WorldError};

const HALL: &str = "
    walls  = [{ name = 'wall', points = [[-4, -3], [6, -3], [6, 3], [-4, 3]], closed = true }]
    robots = { r = { start = { x = 0, y = 0 } }, s = { start = { x = 3, y = 0 } } }";

fn hall(seed: u64) -> (World, RobotId) {
    let mut world = World::parse(HALL, "hall.toml", seed).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

fn exact() -> LaserConfig {
    LaserConfig {
        mount: Pose2::default(),
        sigma: 0.0,
        ..LaserConfig::default()
    }
}

fn scan(world: &World, robot: RobotId, laser: &LaserConfig) -> Vec<f32> {
    let mut ranges = vec![0.0; laser.beams];
    world.laser(robot, laser, &mut ranges).unwrap();
    ranges
}

fn assert_near(found: f32, expected: f64) {
    assert!(
        (f64::from(found) - expected).abs() < 1e-5,
        "found {found}, expected {expected}"
    );
}

#[test]
fn the_default_laser_has_one_beam_per_degree_from_right_to_left() {
    let laser = LaserConfig::default();
    assert_eq!(laser.beams, 180);
    for (beam, degrees) in [(0, -90.0), (1, -89.0), (90, 0.0), (179, 89.0)] {
        assert!((laser.angle(beam).to_degrees() - degrees).abs() < 1e-9);
    }
    assert!((laser.angle_max().to_degrees() - 89.0).abs() < 1e-9);
}

#[test]
fn a_laser_measures_the_walls_of_a_hall() {
    let (world, robot) = hall(1);
    let ranges = scan(&world, robot, &exact());
    assert_near(ranges[0], 3.0);
    assert_near(ranges[90], 6.0);
    assert_near(ranges[45], 3.0 / 45f64.to_radians().sin());
    assert_near(ranges[179], 3.0 / 89f64.to_radians().sin());
}

#[test]
fn a_laser_measures_from_its_mount() {
    let (world, robot) = hall(1);
    let rear = LaserConfig {
        mount: Pose2::new(-0.2, 0.1, 180f64.to_radians()),
        ..exact()
    };
    let ranges = scan(&world, robot, &rear);
    assert_near(ranges[90], 3.8);
    assert_near(ranges[0], 2.9);
}

#[test]
fn no_return_is_plus_infinity_and_too_near_is_minus_infinity() {
    let (world, robot) = hall(1);
    let ranges = scan(
        &world,
        robot,
        &LaserConfig {
            range_max: 5.0,
            range_min: 3.5,
            ..exact()
        },
    );
    assert_eq!(ranges[90], f32::INFINITY);
    assert_eq!(ranges[0], f32::NEG_INFINITY);
    assert_near(ranges[45], 3.0 / 45f64.to_radians().sin());
}

#[test]
fn a_laser_detects_other_robots_but_not_its_own() {
    let (mut world, robot) = hall(1);
    let other = world
        .add_robot(
            "s",
            RobotConfig {
                footprint: Footprint::Circle { radius: 0.5 },
                ..RobotConfig::default()
            },
        )
        .unwrap();
    assert_near(scan(&world, robot, &exact())[90], 2.5);
    assert_near(scan(&world, other, &exact())[90], 3.0);
    let truth = world.truth(robot);
    assert!((truth.clearance - (3.0 - 0.5 - 0.25)).abs() < 1e-9, "{truth:?}");
}

#[test]
fn intensities_are_those_of_what_each_beam_meets() {
    let text = "boxes = [{ center = [2, 0], size = [0.1, 1], reflectivity = 20 }]
        walls = [{ points = [[-4, 2], [4, 2]] }]
        circles = [{ center = [0, -2], radius = 0.5, reflectivity = 0 }]
        balls = [{ center = [-2, 0], radius = 0.3 }]
        robots = { r = { start = { x = 0, y = 0 } } }";
    let mut world = World::parse(text, "intensities.toml", 3).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    let laser = LaserConfig {
        beams: 360,
        field_of_view: 360f64.to_radians(),
        intensity: 10.0,
        ..exact()
    };
    let (mut ranges, mut intensities) = (vec![0.0; 360], vec![0.0; 360]);
    let buffers = (&mut ranges[..], &mut intensities[..]);
    world.laser_with_intensities(robot, &laser, buffers).unwrap();
    assert_eq!(ranges, scan(&world, robot, &laser), "the same ranges");
    // Ahead a reflector, to the left a wall, behind a ball, to the right what reflects nothing.
    let mean = |beams: std::ops::Range<usize>| {
        let count = beams.len() as f64;
        intensities[beams]
            .iter()
            .map(|value| f64::from(*value))
            .sum::<f64>()
            / count
    };
    for (middle, expected) in [(180, 200.0), (270, 5.0), (355, 5.0), (90, 0.0)] {
        let found = mean(middle - 2..middle + 2);
        assert!((found - expected).abs() <= 0.08 * expected, "{middle}: {found}");
    }
    assert_eq!((ranges[135], intensities[135]), (f32::INFINITY, 0.0), "no return");
    let short = (&mut ranges[..], &mut intensities[1..]);
    assert!(world.laser_with_intensities(robot, &laser, short).is_err());
}

#[test]
fn noise_has_the_configured_mean_and_deviation() {
    let (mut world, robot) = hall(5);
    let noisy = LaserConfig {
        sigma: 0.03,
        ..exact()
    };
    let truth = scan(&world, robot, &exact());
    let mut errors = Vec::new();
    for step in 1..=200u64 {
        world.advance_to(step * jde_sim::STEP_NS);
        let ranges = scan(&world, robot, &noisy);
        errors.extend(
            ranges
                .iter()
                .zip(&truth)
                .map(|(range, truth)| f64::from(range - truth)),
        );
    }
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let deviation = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt();
    let beyond = errors.iter().filter(|error| error.abs() > 2.0 * 0.03).count() as f64 / count;
    // 36000 draws: five standard errors of the mean, of the deviation, and of the 4.55 % beyond two sigma.
    assert!(mean.abs() < 5.0 * 0.03 / count.sqrt(), "mean {mean}");
    assert!(
        (deviation / 0.03 - 1.0).abs() < 5.0 / (2.0 * count).sqrt(),
        "deviation {deviation}"
    );
    assert!(
        (beyond - 0.0455).abs() < 5.0 * (0.0455f64 * 0.9545 / count).sqrt(),
        "beyond two sigma {beyond}"
    );
    // The errors of neighbouring beams, and of the same beam in the next scan, are independent.
    let correlation = |lag: usize| {
        errors.iter().zip(&errors[lag..]).map(|(a, b)| a * b).sum::<f64>() / count / 0.03f64.powi(2)
    };
    assert!(correlation(1).abs() < 5.0 / count.sqrt() && correlation(180).abs() < 5.0 / count.sqrt());
}

#[test]
fn reading_a_sensor_has_no_side_effects() {
    let (mut read_often, robot) = hall(9);
    let (mut read_once, _) = hall(9);
    let (laser, ring) = (LaserConfig::default(), SonarConfig::default());
    let mut echoes = [0.0; 16];
    for world in [&mut read_often, &mut read_once] {
        world.command(robot, Twist2::new(0.3, 0.4)).unwrap();
    }
    for step in 1..100u64 {
        read_often.advance_to(step * jde_sim::STEP_NS);
        let first = scan(&read_often, robot, &laser);
        read_often.sonars(robot, &ring, &mut echoes).unwrap();
        assert_eq!(first, scan(&read_often, robot, &laser));
    }
    read_once.advance_to(read_often.now());
    assert_eq!(scan(&read_once, robot, &laser), scan(&read_often, robot, &laser));
    assert_eq!(read_once.odometry(robot), read_often.odometry(robot));
}

#[test]
fn the_same_seed_gives_the_same_measurements_and_another_seed_others() {
    let run = |seed| {
        let (mut world, robot) = hall(seed);
        world.command(robot, Twist2::new(0.4, 0.3)).unwrap();
        world.advance_to(20_000_000_000);
        let bits: Vec<u32> = scan(&world, robot, &LaserConfig::default())
            .iter()
            .map(|r| r.to_bits())
            .collect();
        (
            bits,
            world.odometry(robot),
            world.encoders(robot),
            world.truth(robot),
        )
    };
    assert_eq!(run(3), run(3));
    let ((scan_a, odometry_a, encoders_a, truth_a), (scan_b, odometry_b, encoders_b, truth_b)) =
        (run(3), run(4));
    assert!(scan_a != scan_b && odometry_a != odometry_b && encoders_a != encoders_b);
    assert_eq!(truth_a, truth_b, "the seed affects the measurements only");
}

#[test]
fn streams_and_robots_have_independent_errors() {
    let (mut world, robot) = hall(9);
    let errors = |world: &World, robot, stream| -> Vec<f32> {
        let noisy = scan(
            world,
            robot,
            &LaserConfig {
                stream,
                sigma: 0.05,
                ..exact()
            },
        );
        noisy
            .iter()
            .zip(scan(world, robot, &exact()))
            .map(|(a, b)| a - b)
            .collect()
    };
    assert_ne!(errors(&world, robot, 0), errors(&world, robot, 1));
    let other = world.add_robot("s", RobotConfig::default()).unwrap();
    assert_ne!(errors(&world, robot, 0)[..80], errors(&world, other, 0)[..80]);
}

#[test]
fn the_order_in_which_robots_are_added_makes_no_difference() {
    let run = |names: [&str; 2]| {
        let mut world = World::parse(HALL, "hall.toml", 2).unwrap();
        for name in names {
            let robot = world.add_robot(name, RobotConfig::default()).unwrap();
            world
                .command(robot, Twist2::new(0.5, if name == "r" { 0.1 } else { -0.3 }))
                .unwrap();
        }
        world.advance_to(30_000_000_000);
        world
            .robots()
            .map(|(id, name)| (name.to_owned(), world.truth(id), world.odometry(id)))
            .collect::<Vec<_>>()
    };
    assert_eq!(run(["r", "s"]), run(["s", "r"]));
}

#[test]
fn a_sonar_reports_the_nearest_thing_in_its_cone() {
    // A post of 6 cm, 14 degrees off the axis of the sonar that points straight left from (0.069, 0.136).
    let angle = 104f64.to_radians();
    let (x, y) = (0.069 + 2.0 * angle.cos(), 0.136 + 2.0 * angle.sin());
    let text = format!(
        "circles = [{{ center = [{x}, {y}], radius = 0.03 }}]\nrobots = {{ r = {{ start = {{ x = 0, y = 0 }} }} }}"
    );
    let mut world = World::parse(&text, "post.toml", 0).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    let ring = SonarConfig {
        sigma: 0.0,
        ..SonarConfig::default()
    };
    let mut echoes = [0.0; 16];
    world.sonars(robot, &ring, &mut echoes).unwrap();
    assert!((f64::from(echoes[0]) - 1.97).abs() < 0.005, "{echoes:?}");
    let narrow = SonarConfig {
        cone: 20f64.to_radians(),
        ..ring
    };
    world.sonars(robot, &narrow, &mut echoes).unwrap();
    assert_eq!(echoes[0], f32::INFINITY);
}

#[test]
fn a_sonar_detects_a_pole_anywhere_in_its_cone() {
    let ring = SonarConfig {
        sigma: 0.0,
        ..SonarConfig::default()
    };
    // A pole of 1 cm, 4 m from the sonar that points straight left, degree by degree.
    for degrees in 76..=104 {
        let angle = f64::from(degrees).to_radians();
        let (x, y) = (0.069 + 4.0 * angle.cos(), 0.136 + 4.0 * angle.sin());
        let text = format!(
            "circles = [{{ center = [{x}, {y}], radius = 0.005 }}]\nrobots = {{ r = {{ start = {{ x = 0, y = 0 }} }} }}"
        );
        let mut world = World::parse(&text, "pole.toml", 0).unwrap();
        let robot = world.add_robot("r", RobotConfig::default()).unwrap();
        let mut echoes = [0.0; 16];
        world.sonars(robot, &ring, &mut echoes).unwrap();
        assert!(
            (f64::from(echoes[0]) - 3.995).abs() < 1e-3,
            "{degrees}: {}",
            echoes[0]
        );
    }
}

#[test]
fn the_ring_of_a_p3dx_is_symmetric_and_goes_clockwise() {
    let mounts = SonarConfig::default().mounts;
    assert_eq!(mounts.len(), 16);
    for half in [&mounts[..8], &mounts[8..]] {
        for (left, right) in half.iter().zip(half.iter().rev()) {
            assert!(
                (left.x, left.y, left.heading) == (right.x, -right.y, -right.heading),
                "{left:?} {right:?}"
            );
        }
    }
    assert_eq!((mounts[0].x, mounts[0].y), (0.069, 0.136));
    assert_eq!((mounts[8].x, mounts[8].y), (-0.157, -0.136));
}

#[test]
fn a_buffer_of_the_wrong_length_and_invalid_values_are_refused() {
    let (world, robot) = hall(1);
    let refused = world.laser(robot, &LaserConfig::default(), &mut [0.0; 181]);
    assert_eq!(
        refused,
        Err(WorldError::BadBuffer {
            sensor: "laser",
            given: 181,
            expected: 180
        })
    );
    let invalid = LaserConfig {
        sigma: f64::NAN,
        ..LaserConfig::default()
    };
    let error = world
        .laser(robot, &invalid, &mut [0.0; 180])
        .unwrap_err()
        .to_string();
    assert!(error.contains("laser sigma is NaN"), "{error}");
    let invalid = SonarConfig {
        range_max: 0.0,
        ..SonarConfig::default()
    };
    assert!(
        world
            .sonars(robot, &invalid, &mut [0.0; 16])
            .unwrap_err()
            .to_string()
            .contains("range_max")
    );
}
