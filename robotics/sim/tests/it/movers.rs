//! Movers: their paths and waits, and the clearance that they keep from robots.

use jde_sim::{LaserConfig, Outline, Pose2, RobotConfig, RobotId, STEP_NS, Twist2, World};
use proptest::prelude::*;

const SECOND: u64 = 1_000_000_000;

fn world(text: &str) -> World {
    World::parse(text, "movers.toml", 0).unwrap()
}

fn center(world: &World, name: &str) -> [f64; 2] {
    match world
        .shapes()
        .find(|shape| shape.name == name && shape.moving)
        .unwrap()
        .outline
    {
        Outline::Circle { center, .. } | Outline::Box { center, .. } => center,
        Outline::Segment { from, .. } => from,
    }
}

fn assert_at(world: &World, expected: [f64; 2]) {
    let found = center(world, "m");
    assert!(
        (found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-9,
        "{found:?}, expected {expected:?}"
    );
}

#[test]
fn a_mover_moves_to_the_end_of_its_way_and_back() {
    let mut world =
        world("movers = [{ name = 'm', radius = 0.2, way = [[0, 0], [2, 0], [2, 1]], speed = 0.5 }]");
    for (seconds, position) in [
        (0, [0.0, 0.0]),
        (2, [1.0, 0.0]),
        (5, [2.0, 0.5]),
        (6, [2.0, 1.0]),
        (7, [2.0, 0.5]),
    ] {
        world.advance_to(seconds * SECOND);
        assert_at(&world, position);
    }
    world.advance_to(12 * SECOND);
    assert_at(&world, [0.0, 0.0]);
    world.advance_to(13 * SECOND);
    assert_at(&world, [0.5, 0.0]);
}

#[test]
fn a_loop_returns_to_the_first_way_point() {
    let text = "movers = [{ name = 'm', radius = 0.2, way = [[0, 0], [2, 0], [2, 1], [0, 1]], speed = 1, loop = true }]";
    let mut world = world(text);
    for (milliseconds, position) in [
        (2500, [2.0, 0.5]),
        (4000, [1.0, 1.0]),
        (5500, [0.0, 0.5]),
        (7000, [1.0, 0.0]),
    ] {
        world.advance_to(milliseconds * 1_000_000);
        assert_at(&world, position);
    }
}

#[test]
fn a_box_faces_along_its_way() {
    let mut world =
        world("movers = [{ name = 'm', size = [1, 0.4], way = [[0, 0], [2, 0], [2, 3]], speed = 1 }]");
    let angle = |world: &World| match world.shapes().next().unwrap().outline {
        Outline::Box { angle, .. } => angle.to_degrees(),
        other => panic!("a box, not {other:?}"),
    };
    world.advance_to(SECOND);
    assert_eq!(angle(&world), 0.0);
    world.advance_to(3 * SECOND);
    assert_eq!(angle(&world), 90.0);
}

/// Creates a mover that approaches along y = 0 a robot at rest at x = 5.
fn meeting(extra: &str) -> (World, RobotId) {
    let mut world = world(&format!(
        "movers = [{{ name = 'm', radius = 0.25, way = [[0, 0], [10, 0]], speed = 0.5, {extra} }}]
         robots = {{ r = {{ start = {{ x = 5, y = 0 }} }} }}"
    ));
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

#[test]
fn a_mover_halts_at_its_clearance_and_turns_back_after_its_wait() {
    let (mut world, robot) = meeting("clearance = 0.4, wait = 2");
    // It stops with 0.4 m between the bodies, at x = 4.1, after 8.2 s.
    world.advance_to(9 * SECOND);
    let clearance = world.truth(robot).clearance;
    assert!((0.4..0.4 + 0.005 + 1e-9).contains(&clearance), "{clearance}");
    let halted = center(&world, "m");
    world.advance_to(10 * SECOND);
    assert_at(&world, halted);
    world.advance_to(14 * SECOND);
    assert!(center(&world, "m")[0] < 3.0, "the mover turns back");
    assert_eq!(world.truth(robot).collisions, 0);
}

#[test]
fn a_mover_continues_when_the_robot_drives_away() {
    let (mut world, robot) = meeting("clearance = 0.4, wait = 60");
    world.advance_to(10 * SECOND);
    let halted = center(&world, "m")[0];
    world.command(robot, Twist2::new(1.0, 0.0)).unwrap();
    world.advance_to(14 * SECOND);
    assert!(center(&world, "m")[0] > halted + 1.0);
}

#[test]
fn a_mover_in_contact_with_a_robot_can_move_away() {
    let (mut world, robot) = meeting("clearance = 0.4, wait = 1");
    // The robot drives into the halted mover and stays in contact. The mover turns back.
    world.advance_to(9 * SECOND);
    world.command(robot, Twist2::new(-0.3, 0.0)).unwrap();
    world.advance_to(9 * SECOND + SECOND / 2);
    world.command(robot, Twist2::default()).unwrap();
    world.advance_to(15 * SECOND);
    assert!(world.truth(robot).clearance > 1.0, "{:?}", world.truth(robot));
}

#[test]
fn a_mover_in_contact_with_a_robot_does_not_move_into_it() {
    let mut world = world(
        "movers = [{ name = 'm', radius = 0.25, way = [[0, 0], [4, 0]], speed = 0.5, wait = 60 }]
         robots = { r = { start = { x = 0.5, y = 0 } } }",
    );
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(world.truth(robot).clearance, 0.0);
    world.advance_to(SECOND);
    assert_at(&world, [0.0, 0.0]);
    assert_eq!(world.truth(robot).clearance, 0.0);
}

#[test]
fn a_ray_measures_the_distance_to_a_mover() {
    let (mut world, robot) = meeting("clearance = 0.4, wait = 60");
    let distance = |world: &World| {
        world
            .cast_ray([5.0, 0.0], 180f64.to_radians(), 20.0, Some(robot))
            .unwrap()
    };
    assert!((distance(&world) - 4.75).abs() < 1e-9);
    world.advance_to(4 * SECOND);
    assert!((distance(&world) - 2.75).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn a_mover_keeps_its_clearance_from_a_robot_at_rest(
        way in proptest::collection::vec((-3.0..3.0f64, -3.0..3.0f64), 2..6),
        (length, width) in (0.2..1.2f64, 0.2..1.2f64),
        speed in 0.1..3.0f64,
        clearance in 0.05..0.6f64,
        closed in any::<bool>(),
    ) {
        let text = format!(
            "movers = [{{ name = 'm', size = [{length}, {width}], way = {:?}, speed = {speed}, loop = {closed},
                          clearance = {clearance}, wait = 0.5 }}]
             robots = {{ r = {{ start = {{ x = 0.5, y = 0.5 }} }} }}",
            way.iter().map(|(x, y)| [*x, *y]).collect::<Vec<_>>()
        );
        let mut world = world(&text);
        let Ok(robot) = world.add_robot("r", RobotConfig::default()) else { return Ok(()) };
        let start = world.truth(robot).clearance;
        world.advance_to(60 * SECOND);
        let truth = world.truth(robot);
        prop_assert!(truth.min_clearance >= clearance.min(start) - 1e-9, "{:?}", truth);
    }

    /// The robot drives at random and may touch the movers.
    #[test]
    fn robots_and_movers_never_overlap(commands in proptest::collection::vec((-1.2..1.2f64, -2.0..2.0f64), 5..60)) {
        let mut world = world(
            "walls  = [{ points = [[0, 0], [4, 0], [4, 4], [0, 4]], closed = true }]
             movers = [{ radius = 0.3, way = [[0.5, 2], [3.5, 2]], speed = 0.8, clearance = 0.1, wait = 0.3 },
                       { size = [0.8, 0.4], way = [[2, 0.5], [2, 3.4], [3, 3.4]], speed = 0.5, clearance = 0.1, wait = 0.3 }]
             robots = { r = { start = { x = 1, y = 1 } } }",
        );
        let robot = world.add_robot("r", RobotConfig::default()).unwrap();
        for (v, w) in commands {
            world.command(robot, Twist2::new(v, w)).unwrap();
            world.advance_to(world.now() + 60 * STEP_NS);
            prop_assert!(world.truth(robot).min_clearance >= 0.0, "{:?}", world.truth(robot));
        }
    }
}

#[test]
fn a_person_pauses_at_every_way_point() {
    let mut world = world("people = [{ name = 'm', way = [[0, 0], [2, 0], [2, 1]], speed = 1, pause = 3 }]");
    for (seconds, position) in [
        (1, [1.0, 0.0]),
        (2, [2.0, 0.0]),
        (5, [2.0, 0.0]),
        (6, [2.0, 1.0]),
        (9, [2.0, 1.0]),
    ] {
        world.advance_to(seconds * SECOND);
        assert_at(&world, position);
    }
    world.advance_to(10 * SECOND);
    assert_at(&world, [2.0, 0.0]);
}

#[test]
fn a_person_pauses_at_each_of_several_close_way_points_in_both_directions() {
    let mut world = world(
        "people = [{ name = 'm', way = [[0, 0], [1, 0], [1.004, 0], [1.008, 0], [2, 0]], speed = 1, pause = 3 }]",
    );
    // The person walks for 1 s, pauses three times for 3 s, walks for 1 s, pauses, and returns likewise.
    for (seconds, position) in [(3, 1.0), (6, 1.004), (9, 1.008)] {
        world.advance_to(seconds * SECOND);
        assert_at(&world, [position, 0.0]);
    }
    for (seconds, position) in [(13, 2.0), (17, 1.008), (20, 1.004), (23, 1.0)] {
        world.advance_to(seconds * SECOND);
        assert_at(&world, [position, 0.0]);
    }
}

#[test]
fn a_person_without_a_speed_stays_and_both_legs_of_one_who_sits_are_ahead() {
    for (keys, farther) in [("speed = 0", 0.0), ("sits = true", 0.15)] {
        let mut world = world(&format!(
            "people = [{{ name = 'm', way = [[2, 0], [0, 0]], clearance = 3, {keys} }}]
             robots = {{ r = {{ start = {{ x = 0, y = 0 }} }} }}"
        ));
        let robot = world.add_robot("r", RobotConfig::default()).unwrap();
        let laser = LaserConfig {
            sigma: 0.0,
            mount: Pose2::default(),
            ..LaserConfig::default()
        };
        let mut ranges = vec![0.0; laser.beams];
        world.advance_to(20 * SECOND);
        assert_at(&world, [2.0, 0.0]);
        world.laser(robot, &laser, &mut ranges).unwrap();
        // The person faces the robot. Of a leg of 0.065 m radius, 0.1 m beside the middle, the nearest point:
        let expected = (2.0_f64 - farther).hypot(0.1) - 0.065;
        for side in [&ranges[..90], &ranges[90..]] {
            let nearest = side.iter().copied().fold(f32::INFINITY, f32::min);
            assert!(
                (f64::from(nearest) - expected).abs() < 0.002,
                "{keys}: {nearest} m"
            );
        }
    }
}

#[test]
fn a_laser_measures_the_legs_of_a_person_and_a_ray_the_body() {
    let mut world = world(
        "people = [{ name = 'm', way = [[2, 3], [2, -3]], speed = 0.5 }]
         robots = { r = { start = { x = 0, y = 0 } } }",
    );
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    // The person crosses in front of the robot, and is straight ahead after 6 s.
    let laser = LaserConfig {
        sigma: 0.0,
        mount: Pose2::default(),
        ..LaserConfig::default()
    };
    let mut ranges = vec![0.0; laser.beams];
    let mut strides = Vec::new();
    for tenth in 0..=20 {
        world.advance_to(5 * SECOND + tenth * SECOND / 10);
        world.laser(robot, &laser, &mut ranges).unwrap();
        let points: Vec<[f64; 2]> = (0..laser.beams)
            .filter(|&beam| ranges[beam].is_finite())
            .map(|beam| (f64::from(ranges[beam]), laser.angle(beam)))
            .map(|(range, angle)| [range * angle.cos(), range * angle.sin()])
            .collect();
        let middle = center(&world, "m");
        // Both legs are within the outline of the body.
        for point in &points {
            assert!(
                (point[0] - middle[0]).hypot(point[1] - middle[1]) < 0.25,
                "{point:?} {middle:?}"
            );
        }
        let side = |x: f64| {
            points
                .iter()
                .filter(|point| point[0] < x)
                .map(|point| point[1])
                .collect::<Vec<_>>()
        };
        let near = side(2.0);
        strides.push(near.iter().sum::<f64>() / near.len() as f64 - middle[1]);
        assert!(
            world.cast_ray([0.0, middle[1]], 0.0, 9.0, Some(robot)).unwrap() - 1.75 < 1e-9,
            "the body"
        );
    }
    // The near leg swings ahead of the body and behind it.
    let (least, most) = strides
        .iter()
        .fold((0.0f64, 0.0f64), |(low, high), &at| (low.min(at), high.max(at)));
    assert!(least < -0.08 && most > 0.08, "{strides:?}");
}
