//! What real robots do wrong and files may ask for: friction, skidding, lasers that turn and lose beams, surfaces that light
//! passes or never leaves, measurements that arrive late.

use std::f64::consts::TAU;
use std::time::Duration;

use jde_sim::{
    Delivery, Kinematics, LaserConfig, LaserTurn, NoReturn, Pose2, RobotConfig, RobotId, SonarConfig, Twist2,
    World, WorldError, wrap_angle,
};
use proptest::prelude::*;

const STEP: u64 = 10_000_000;

const HALL: &str = "
    walls   = [{ name = 'wall', points = [[-4, -3], [6, -3], [6, 3], [-4, 3]], closed = true }]
    circles = [{ name = 'post', center = [2, 1], radius = 0.2 }]
    robots  = { r = { start = { x = 0, y = 0 } } }";

fn exact_wheels() -> RobotConfig {
    RobotConfig {
        wheel_scale_sigma: 0.0,
        slip_sigma: 0.0,
        linear_acceleration: 1e3,
        linear_deceleration: 1e3,
        angular_acceleration: 1e3,
        angular_deceleration: 1e3,
        ..RobotConfig::default()
    }
}

fn hall(seed: u64, config: RobotConfig) -> (World, RobotId) {
    let mut world = World::parse(HALL, "hall.toml", seed).unwrap();
    let robot = world.add_robot("r", config).unwrap();
    (world, robot)
}

fn exact_laser() -> LaserConfig {
    LaserConfig {
        mount: Pose2::new(0.1, -0.05, 0.3),
        beams: 120,
        field_of_view: TAU,
        sigma: 0.0,
        range_max: 20.0,
        ..LaserConfig::default()
    }
}

fn scan(world: &World, robot: RobotId, laser: &LaserConfig) -> Vec<f32> {
    let mut ranges = vec![0.0; laser.beams];
    world.laser(robot, laser, &mut ranges).unwrap();
    ranges
}

fn kinematics() -> impl Strategy<Value = Kinematics> {
    prop_oneof![
        Just(Kinematics::Differential),
        Just(Kinematics::Omnidirectional {
            max_lateral: 1.0,
            lateral_acceleration: 1e3,
        }),
        Just(Kinematics::Car {
            wheelbase: 0.3,
            max_steering: 0.4,
            steering_rate: 10.0,
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn a_command_within_the_dead_band_moves_no_base_and_one_beyond_it_does(
        kinematics in kinematics(),
        [ahead, left, turn] in [-0.99..0.99f64, -0.99..0.99f64, -0.99..0.99f64],
        beyond in 1.0..3.0f64,
    ) {
        let config = RobotConfig { kinematics, dead_band: 0.05, turn_dead_band: 0.2, ..exact_wheels() };
        let moved = |linear: f64, lateral: f64, angular: f64| {
            let (mut world, robot) = hall(1, config.clone());
            world.command(robot, Twist2 { linear, lateral, angular }).unwrap();
            world.advance_to(50 * STEP);
            world.truth(robot).pose != Pose2::default()
        };
        let (ahead, left, turn) = (0.05 * ahead, 0.05 * left, 0.2 * turn);
        prop_assert!(!moved(ahead, left, turn));
        prop_assert!(moved(0.05 * beyond, left, turn), "as fast as the band");
        let is_car = matches!(config.kinematics, Kinematics::Car { .. });
        prop_assert_eq!(moved(ahead, left, 0.2 * beyond), !is_car, "a turn moves the base");
    }

    #[test]
    fn a_base_that_skids_turns_less_than_its_wheels_say(
        skid in 0.0..0.9f64,
        turn in prop_oneof![-2.0..-0.1f64, 0.1..2.0f64],
        ahead in -0.3..0.3f64,
        lag in 0.0..0.3f64,
    ) {
        let config = RobotConfig { skid, lag, ..exact_wheels() };
        let (mut world, robot) = hall(2, config);
        world.command(robot, Twist2::new(ahead, turn)).unwrap();
        let (mut turned, mut measured) = (0.0, 0.0);
        for step in 1..=100 {
            let before = (world.truth(robot).pose, world.odometry(robot).pose);
            world.advance_to(step * STEP);
            turned += wrap_angle(world.truth(robot).pose.heading - before.0.heading);
            measured += wrap_angle(world.odometry(robot).pose.heading - before.1.heading);
        }
        prop_assert!((turned - (1.0 - skid) * measured).abs() < 1e-3, "{} {}", turned, measured);
        let rate = world.odometry(robot).twist.angular;
        prop_assert!((world.truth(robot).twist.angular - (1.0 - skid) * rate).abs() < 0.01);
        prop_assert!(measured * turn > 0.0);
    }

    #[test]
    fn each_beam_of_a_turning_laser_is_measured_from_where_the_robot_was(
        clockwise: bool,
        ahead in -0.5..0.5f64,
        turn in -2.0..2.0f64,
        field_of_view in 1.0..TAU,
    ) {
        let config = RobotConfig { trail: 0.2, ..exact_wheels() };
        let (mut world, robot) = hall(3, config);
        world.command(robot, Twist2::new(ahead, turn)).unwrap();
        let mut poses = vec![Pose2::default()];
        for step in 1..=40 {
            world.advance_to(step * STEP);
            poses.push(world.truth(robot).pose);
        }
        let laser = LaserConfig {
            field_of_view,
            turn: Some(LaserTurn { period: 0.18, clockwise }),
            ..exact_laser()
        };
        let ranges = scan(&world, robot, &laser);
        prop_assert!((laser.age(0) - 0.18 * field_of_view / TAU * 119.0 / 120.0).abs() < 1e-12);
        prop_assert_eq!(laser.age(119), 0.0);
        for (beam, range) in ranges.into_iter().enumerate() {
            let steps = 40.0 - laser.age(beam) / 0.01;
            let (before, part) = (poses[steps as usize], steps.fract());
            let after = poses[(steps as usize + 1).min(40)];
            let pose = Pose2::new(
                before.x + part * (after.x - before.x),
                before.y + part * (after.y - before.y),
                before.heading + part * wrap_angle(after.heading - before.heading),
            );
            let from = pose.compose(laser.mount);
            let heading = from.heading + laser.angle(beam);
            let expected = world.cast_ray([from.x, from.y], heading, 20.0, Some(robot)).unwrap();
            prop_assert!((f64::from(range) - expected).abs() < 1e-4, "{}: {} {}", beam, range, expected);
        }
    }

    #[test]
    fn a_part_of_the_beams_is_dropped_and_the_others_are_the_same(
        seed: u64,
        dropped_beams in 0.0..=1.0f64,
    ) {
        let (world, robot) = hall(seed, RobotConfig::default());
        let whole = LaserConfig { beams: 2000, sigma: 0.01, ..exact_laser() };
        let lossy = LaserConfig { dropped_beams, ..whole.clone() };
        let (whole, part) = (scan(&world, robot, &whole), scan(&world, robot, &lossy));
        let lost = part.iter().filter(|range| range.is_infinite()).count() as f64 / 2000.0;
        prop_assert!((lost - dropped_beams).abs() < 0.07, "{}", lost);
        prop_assert!(whole.iter().zip(&part).all(|(whole, part)| whole == part || part.is_infinite()));
        prop_assert_eq!(scan(&world, robot, &lossy), part, "at one time a laser reads the same");
    }

    #[test]
    fn measurements_arrive_within_their_times_or_are_lost(
        seed: u64,
        latency in 0.0..1.0f64,
        jitter in 0.0..1.0f64,
        dropped in 0.0..=1.0f64,
    ) {
        let (mut world, robot) = hall(seed, RobotConfig::default());
        let delivery = Delivery { latency, jitter, dropped };
        let (mut lost, mut delays) = (0, Vec::new());
        for step in 0..400 {
            world.advance_to(step * STEP);
            match world.delay(robot, &delivery, 3).unwrap() {
                Some(delay) => delays.push(delay.as_secs_f64()),
                None => lost += 1,
            }
        }
        prop_assert!((f64::from(lost) / 400.0 - dropped).abs() < 0.13, "{}", lost);
        prop_assert!(delays.iter().all(|delay| (latency - 1e-8..=latency + jitter + 1e-8).contains(delay)));
    }
}

#[test]
fn a_laser_that_turns_at_rest_measures_what_one_at_once_does() {
    let (world, robot) = hall(
        4,
        RobotConfig {
            trail: 1.0,
            ..RobotConfig::default()
        },
    );
    let at_once = LaserConfig {
        sigma: 0.02,
        ..exact_laser()
    };
    let exact = scan(
        &world,
        robot,
        &LaserConfig {
            sigma: 0.0,
            ..at_once.clone()
        },
    );
    for clockwise in [false, true] {
        let turn = Some(LaserTurn {
            period: 0.5,
            clockwise,
        });
        let laser = LaserConfig {
            turn,
            sigma: 0.0,
            ..at_once.clone()
        };
        let mut ranges = scan(&world, robot, &laser);
        assert_eq!(laser.angle_increment() < 0.0, clockwise);
        if clockwise {
            ranges.reverse();
        }
        for (turned, exact) in ranges.iter().zip(&exact) {
            assert!((turned - exact).abs() < 1e-5, "{turned} {exact}");
        }
    }
}

#[test]
fn a_robot_that_was_put_elsewhere_has_no_trail_there() {
    let (mut world, robot) = hall(
        5,
        RobotConfig {
            trail: 1.0,
            ..RobotConfig::default()
        },
    );
    world.command(robot, Twist2::new(0.5, 0.5)).unwrap();
    world.advance_to(100 * STEP);
    world.place(robot, Pose2::new(3.0, -1.0, 1.0)).unwrap();
    let turn = Some(LaserTurn {
        period: 0.5,
        clockwise: false,
    });
    let turning = scan(
        &world,
        robot,
        &LaserConfig {
            turn,
            ..exact_laser()
        },
    );
    for (turned, exact) in turning.iter().zip(scan(&world, robot, &exact_laser())) {
        assert!((turned - exact).abs() < 1e-5, "{turned} {exact}");
    }
}

#[test]
fn a_robot_without_a_trail_has_no_turning_laser() {
    let (world, robot) = hall(6, RobotConfig::default());
    let turn = Some(LaserTurn {
        period: 0.2,
        clockwise: false,
    });
    let error = world.laser(
        robot,
        &LaserConfig {
            turn,
            ..exact_laser()
        },
        &mut [0.0; 120],
    );
    assert!(
        matches!(
            error,
            Err(WorldError::BadConfig {
                what: "laser turn",
                ..
            })
        ),
        "{error:?}"
    );
}

#[test]
fn a_beam_without_a_return_reads_what_its_device_reads() {
    let (world, robot) = hall(7, RobotConfig::default());
    let laser = LaserConfig {
        range_max: 4.0,
        range_min: 3.2,
        dropped_beams: 0.2,
        ..exact_laser()
    };
    let plain = scan(&world, robot, &laser);
    assert!(plain.contains(&f32::INFINITY) && plain.contains(&f32::NEG_INFINITY));
    for (no_return, free, too_near) in [
        (NoReturn::Max, 4.0, f32::NEG_INFINITY),
        (NoReturn::Zero, 0.0, 0.0),
        (NoReturn::Nan, f32::NAN, f32::NAN),
    ] {
        let read = scan(
            &world,
            robot,
            &LaserConfig {
                no_return,
                ..laser.clone()
            },
        );
        for (plain, read) in plain.iter().zip(read) {
            let expected = match *plain {
                f32::INFINITY => free,
                f32::NEG_INFINITY => too_near,
                range => range,
            };
            assert_eq!(read.to_bits(), expected.to_bits(), "{no_return:?}");
        }
    }
}

/// A robot that faces a thing 2 m ahead, before a wall 4 m ahead.
fn before(thing: &str) -> (World, RobotId) {
    let text =
        format!("walls = [{{ points = [[4, -9], [4, 9]] }}]\nrobots.r.start = {{ x = 0, y = 0 }}\n{thing}");
    let mut world = World::parse(&text, "surface.toml", 1).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

/// Returns what one beam ahead reads, at once and turning.
fn ahead(world: &World, robot: RobotId, angle: f64) -> f32 {
    let laser = LaserConfig {
        mount: Pose2::new(0.0, 0.0, angle + 0.05),
        beams: 1,
        field_of_view: 0.1,
        sigma: 0.0,
        ..LaserConfig::default()
    };
    scan(world, robot, &laser)[0]
}

#[test]
fn a_laser_passes_over_what_is_lower_than_it_which_sonars_meet() {
    const LOW: &str = "
        walls   = [{ name = 'wall', points = [[5, -3], [5, 3]] }]
        boxes   = [{ name = 'low', center = [2, 0], size = [0.4, 4], height = 0.2 }]
        circles = [{ name = 'loose', center = [3, 0], radius = 0.1, height = 0.6 }]
        robots  = { r = { start = { x = 0, y = 0 } } }";
    let mut world = World::parse(LOW, "low.toml", 1).unwrap();
    let config = RobotConfig {
        trail: 0.2,
        ..exact_wheels()
    };
    let robot = world.add_robot("r", config).unwrap();
    let turn = LaserTurn {
        period: 0.1,
        clockwise: false,
    };
    for turn in [None, Some(turn)] {
        let ahead = |height| {
            let laser = LaserConfig {
                mount: Pose2::default(),
                height,
                turn,
                ..exact_laser()
            };
            let beam =
                (0..laser.beams).min_by(|a, b| laser.angle(*a).abs().total_cmp(&laser.angle(*b).abs()));
            scan(&world, robot, &laser)[beam.unwrap()]
        };
        for (height, range) in [(0.0, 1.8), (0.2, 1.8), (0.3, 2.9), (0.7, 5.0)] {
            assert!(
                (ahead(height) - range).abs() < 0.02,
                "{height}: {}",
                ahead(height)
            );
        }
    }
    let ring = SonarConfig {
        mounts: vec![Pose2::default()],
        sigma: 0.0,
        ..SonarConfig::default()
    };
    let mut echo = [0.0];
    world.sonars(robot, &ring, &mut echo).unwrap();
    assert!((echo[0] - 1.8).abs() < 1e-3);
}

#[test]
fn light_passes_through_glass_and_never_leaves_black_which_everything_else_meets() {
    for form in [
        "center = [2.1, 0]\nsize = [0.2, 2]",
        "center = [2.5, 0]\nradius = 0.5",
    ] {
        let table = if form.contains("radius") {
            "circles"
        } else {
            "boxes"
        };
        for (surface, expected) in [("opaque", 2.0), ("glass", 4.0), ("black", f32::INFINITY)] {
            let (mut world, robot) = before(&format!("[[{table}]]\n{form}\nsurface = '{surface}'"));
            assert_eq!(ahead(&world, robot, 0.0), expected, "{surface} {form}");
            let mut sonar = [0.0];
            let ring = SonarConfig {
                mounts: vec![Pose2::default()],
                sigma: 0.0,
                ..SonarConfig::default()
            };
            world.sonars(robot, &ring, &mut sonar).unwrap();
            assert!((sonar[0] - 2.0).abs() < 1e-5, "{surface}: {}", sonar[0]);
            world.command(robot, Twist2::new(1.0, 0.0)).unwrap();
            world.advance_to(600 * STEP);
            assert!(
                world.truth(robot).stalled && world.truth(robot).collisions == 1,
                "{surface}"
            );
            assert!(world.bumpers(robot).front[2], "{surface}");
        }
    }
}

#[test]
fn a_laser_finds_the_legs_of_a_table_and_a_sonar_its_top() {
    let (world, robot) = before("[[boxes]]\nname = 'table'\ncenter = [2, 0]\nsize = [1, 1]\nlegs = 0.02");
    assert_eq!(ahead(&world, robot, 0.0), 4.0);
    let leg = (0.48f64).atan2(1.52);
    assert!((f64::from(ahead(&world, robot, leg)) - (0.48f64.hypot(1.52) - 0.02)).abs() < 1e-5);
    let mut sonar = [0.0];
    let ring = SonarConfig {
        mounts: vec![Pose2::default()],
        sigma: 0.0,
        ..SonarConfig::default()
    };
    world.sonars(robot, &ring, &mut sonar).unwrap();
    assert!((sonar[0] - 1.5).abs() < 1e-5, "{}", sonar[0]);
    assert!((world.truth(robot).clearance - 1.25).abs() < 1e-9);
}

#[test]
fn a_sonar_loses_a_part_of_its_echoes() {
    let (mut world, robot) = hall(8, RobotConfig::default());
    let ring = SonarConfig {
        dropped_echoes: 0.25,
        range_max: 9.0,
        ..SonarConfig::default()
    };
    let (mut lost, mut ranges) = (0, [0.0; 16]);
    for step in 0..100 {
        world.advance_to(step * STEP);
        world.sonars(robot, &ring, &mut ranges).unwrap();
        lost += ranges.iter().filter(|range| range.is_infinite()).count();
    }
    assert!((300..500).contains(&lost), "{lost} of 1600");
}

#[test]
fn a_perfect_delivery_is_at_once() {
    let (world, robot) = hall(9, RobotConfig::default());
    assert_eq!(
        world.delay(robot, &Delivery::default(), 0),
        Ok(Some(Duration::ZERO))
    );
    let bad = Delivery {
        dropped: 1.5,
        ..Delivery::default()
    };
    assert!(world.delay(robot, &bad, 0).is_err());
}
