//! Things that can be pushed: they move with a robot, stay where it leaves them, and never overlap anything.

use jde_sim::{Outline, RobotConfig, RobotId, STEP_NS, SonarConfig, Twist2, World};
use proptest::prelude::*;

fn world(text: &str) -> World {
    World::parse(text, "loose.toml", 5).unwrap()
}

fn center(world: &World, name: &str) -> [f64; 2] {
    let shape = world.shapes().find(|shape| shape.name == name).unwrap();
    match shape.outline {
        Outline::Circle { center, .. } | Outline::Box { center, .. } => center,
        Outline::Segment { .. } => panic!("{name} is a wall"),
    }
}

fn run(world: &mut World, seconds: f64) {
    world.advance_to(world.now() + (seconds * 1e9).round() as u64);
}

/// Creates a robot at the origin that faces along x, with things in front of it.
fn robot_before(things: &str) -> (World, RobotId) {
    let mut world = world(&format!(
        "walls = [{{ name = 'end', points = [[4, -2], [4, 2]] }}]
         robots = {{ r = {{ start = {{ x = 0, y = 0 }} }} }}
         {things}"
    ));
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

fn drive(world: &mut World, robot: RobotId, speed: f64, seconds: f64) {
    world.command(robot, Twist2::new(speed, 0.0)).unwrap();
    run(world, seconds);
}

#[test]
fn a_box_slides_with_the_robot_and_stays_where_the_robot_leaves_it() {
    let (mut world, robot) = robot_before(
        "boxes = [{ name = 'b', center = [1, 0], size = [0.4, 0.6], movable = true, mass = 2 }]",
    );
    drive(&mut world, robot, 0.4, 5.0);
    let (center_of_box, x) = (center(&world, "b"), world.truth(robot).pose.x);
    assert!(
        center_of_box[0] > 1.5 && (center_of_box[0] - 0.2 - x - 0.25).abs() < 1e-4,
        "{center_of_box:?} {x}"
    );
    assert!(center_of_box[1].abs() < 1e-9, "{center_of_box:?}");
    drive(&mut world, robot, -0.4, 4.0);
    let position = center(&world, "b");
    run(&mut world, 5.0);
    assert_eq!(center(&world, "b"), position);
    assert_eq!(world.truth(robot).collisions, 0, "a push is no collision");
}

#[test]
fn a_robot_stalls_when_its_box_is_at_the_wall() {
    let (mut world, robot) =
        robot_before("boxes = [{ name = 'b', center = [1, 0], size = [0.4, 0.6], movable = true }]");
    drive(&mut world, robot, 0.4, 20.0);
    let (center_of_box, truth) = (center(&world, "b"), world.truth(robot));
    assert!(
        truth.stalled && truth.collisions == 0 && truth.twist.linear == 0.0,
        "{truth:?}"
    );
    assert!((3.79..=3.8).contains(&center_of_box[0]), "{center_of_box:?}");
    assert!(world.bumpers(robot).front[2], "the box presses the bumper");
    drive(&mut world, robot, -0.4, 2.0);
    assert!(!world.truth(robot).stalled && !world.bumpers(robot).any());
    assert_eq!(center(&world, "b"), center_of_box);
}

#[test]
fn a_heavy_box_slows_the_robot_and_a_heavier_one_stops_it() {
    let drive_against = |mass: f64| {
        let (mut world, robot) = robot_before(&format!(
            "boxes = [{{ name = 'b', center = [0.5, 0], size = [0.4, 0.6], movable = true, mass = {mass} }}]"
        ));
        drive(&mut world, robot, 0.4, 6.0);
        let truth = world.truth(robot);
        (truth.pose.x, truth.stalled)
    };
    let (light, heavy, heavier) = (drive_against(1.0), drive_against(20.0), drive_against(30.0));
    assert!(light.0 > 1.3 * heavy.0 && heavy.0 > 0.8, "{light:?} {heavy:?}");
    assert!(
        !light.1 && !heavy.1 && heavier.1 && heavier.0 < 0.06,
        "{heavier:?}"
    );
}

#[test]
fn boxes_push_boxes_and_their_masses_add_up() {
    let drive_against = |mass: f64| {
        let (mut world, robot) = robot_before(&format!(
            "boxes = [{{ name = 'a', center = [0.6, 0], size = [0.4, 0.6], movable = true, mass = {mass} }},
                      {{ name = 'b', center = [1.2, 0], size = [0.4, 0.4], movable = true, mass = {mass} }}]"
        ));
        drive(&mut world, robot, 0.4, 5.0);
        (
            center(&world, "a")[0],
            center(&world, "b")[0],
            world.truth(robot).stalled,
        )
    };
    let (a, b, stalled) = drive_against(2.0);
    // The gap between the boxes is less than the robot drives in a step.
    assert!(!stalled && (0.4..0.405).contains(&(b - a)) && b > 1.6, "{a} {b}");
    let (_, b, stalled) = drive_against(14.0);
    assert!(stalled && b == 1.2, "{b}");
}

#[test]
fn a_ball_rolls_ahead_of_the_robot_and_comes_to_rest() {
    let (mut world, robot) = robot_before("balls = [{ name = 'b', center = [0.6, 0], radius = 0.1 }]");
    drive(&mut world, robot, 0.5, 2.5);
    world.command(robot, Twist2::default()).unwrap();
    let before = center(&world, "b")[0];
    run(&mut world, 1.0);
    assert!(center(&world, "b")[0] > before + 0.2, "the ball keeps rolling");
    run(&mut world, 20.0);
    let rest = center(&world, "b");
    run(&mut world, 1.0);
    assert_eq!(center(&world, "b"), rest);
    assert_eq!(world.truth(robot).collisions, 0);
    assert!(!world.bumpers(robot).any(), "a ball presses no bumper");
}

#[test]
fn a_ball_bounces_off_a_wall_with_less_speed() {
    let (mut world, robot) = robot_before("balls = [{ name = 'b', center = [2.6, 0], radius = 0.1 }]");
    drive(&mut world, robot, 1.0, 3.6);
    world.command(robot, Twist2::default()).unwrap();
    let mut farthest = 0.0f64;
    let mut bounced = false;
    for _ in 0..500 {
        world.advance_to(world.now() + STEP_NS);
        let x = center(&world, "b")[0];
        bounced |= x < farthest;
        farthest = farthest.max(x);
    }
    assert!(bounced && farthest < 3.9 && farthest > 3.85, "{farthest}");
}

#[test]
fn sensors_measure_the_distance_to_a_movable_thing() {
    let (mut world, robot) =
        robot_before("boxes = [{ name = 'b', center = [1, 0], size = [0.4, 0.6], movable = true }]");
    let distance = |world: &World| world.cast_ray([0.0, 0.0], 0.0, 9.0, Some(robot)).unwrap();
    assert!((distance(&world) - 0.8).abs() < 1e-9);
    drive(&mut world, robot, 0.4, 4.0);
    assert!((distance(&world) - (center(&world, "b")[0] - 0.2)).abs() < 1e-9);
    let ring = SonarConfig {
        sigma: 0.0,
        ..SonarConfig::default()
    };
    let mut echoes = vec![0.0; 16];
    world.sonars(robot, &ring, &mut echoes).unwrap();
    assert!(echoes[3] < 0.2, "{echoes:?}");
}

#[test]
fn a_robot_does_not_start_on_a_ball() {
    let mut world = world(
        "balls = [{ name = 'b', center = [0.3, 0], radius = 0.1 }]
         robots = { r = { start = { x = 0, y = 0 } } }",
    );
    let error = world
        .add_robot("r", RobotConfig::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("`b`"), "{error}");
}

#[test]
fn people_do_not_walk_into_movable_things() {
    let mut world = world(
        "people = [{ name = 'eve', way = [[0, 0], [6, 0]], speed = 0.8, wait = 1 }]
         balls = [{ name = 'b', center = [3, 0.1], radius = 0.1 }]",
    );
    let mut farthest = 0.0f64;
    for _ in 0..2000 {
        world.advance_to(world.now() + STEP_NS);
        farthest = farthest.max(center(&world, "eve")[0]);
    }
    assert!((2.6..2.7).contains(&farthest), "{farthest}");
    assert!(
        center(&world, "eve")[0] < 2.0 || farthest > center(&world, "eve")[0],
        "the person turns back"
    );
}

const YARD: &str = "
    walls  = [{ points = [[0, 0], [4, 0], [4, 4], [0, 4]], closed = true }]
    circles = [{ center = [2, 3], radius = 0.2 }]
    people = [{ way = [[0.4, 3.6], [3.6, 3.6], [3.6, 0.4]], speed = 0.7, pause = 0.4, clearance = 0.1, wait = 0.3 }]
    balls  = [{ center = [1.6, 1.0], radius = 0.1 }, { center = [2.2, 1.3], radius = 0.15 }, { center = [1, 1.8], radius = 0.08 }]
    boxes  = [{ center = [2.0, 2.0], size = [0.4, 0.4], angle_deg = 25, movable = true, mass = 1 },
              { center = [3.0, 1.0], size = [0.3, 0.6], movable = true, mass = 3 }]
    robots = { r = { start = { x = 1, y = 1 } }, s = { start = { x = 3, y = 3 } } }";

type Corners = Vec<[f64; 2]>;

/// Returns a shape as a convex outline of points, and a radius around it.
fn hull(outline: Outline) -> (Corners, f64) {
    match outline {
        Outline::Segment { from, to } => (vec![from, to], 0.0),
        Outline::Circle { center, radius } => (vec![center], radius),
        Outline::Box { center, size, angle } => {
            let (sin, cos) = angle.sin_cos();
            let corner = |x: f64, y: f64| {
                let (x, y) = (x * size[0] / 2.0, y * size[1] / 2.0);
                [center[0] + cos * x - sin * y, center[1] + sin * x + cos * y]
            };
            (
                vec![
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                ],
                0.0,
            )
        }
    }
}

/// Returns the gap between two shapes by separating axes: at most the true gap, negative when they overlap.
fn gap(a: &(Corners, f64), b: &(Corners, f64)) -> f64 {
    let axes = |points: &Corners, others: &Corners| {
        let mut axes = Vec::new();
        for (index, p) in points.iter().enumerate() {
            let q = points[(index + 1) % points.len()];
            axes.push([-(q[1] - p[1]), q[0] - p[0]]);
            axes.extend(others.iter().map(|o| [o[0] - p[0], o[1] - p[1]]));
        }
        axes
    };
    let mut best = f64::NEG_INFINITY;
    for axis in axes(&a.0, &b.0).into_iter().chain(axes(&b.0, &a.0)) {
        let length = f64::hypot(axis[0], axis[1]);
        if length < 1e-12 {
            continue;
        }
        let reach = |points: &Corners| {
            let along = points.iter().map(|p| (p[0] * axis[0] + p[1] * axis[1]) / length);
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            })
        };
        let ((a_low, a_high), (b_low, b_high)) = (reach(&a.0), reach(&b.0));
        best = best.max((b_low - a_high).max(a_low - b_high) - a.1 - b.1);
    }
    best
}

fn check_nothing_overlaps(world: &World) -> Result<(), TestCaseError> {
    let mut hulls: Vec<(bool, (Corners, f64))> = world
        .shapes()
        .map(|shape| (shape.moving, hull(shape.outline)))
        .collect();
    for (robot, _) in world.robots() {
        let pose = world.truth(robot).pose;
        let center = [pose.x, pose.y];
        hulls.push((
            true,
            hull(Outline::Circle {
                center,
                radius: world.config(robot).footprint.radius(),
            }),
        ));
    }
    for (index, a) in hulls.iter().enumerate() {
        for b in hulls[..index].iter().filter(|b| a.0 || b.0) {
            prop_assert!(
                gap(&a.1, &b.1) > -1e-9,
                "{:?} {:?} overlap by {}",
                a,
                b,
                -gap(&a.1, &b.1)
            );
        }
    }
    Ok(())
}

fn yard() -> (World, [RobotId; 2]) {
    let mut world = world(YARD);
    let robots = ["r", "s"].map(|name| world.add_robot(name, RobotConfig::default()).unwrap());
    (world, robots)
}

fn commands() -> impl Strategy<Value = Vec<[(f64, f64); 2]>> {
    let command = || (-1.2..1.2f64, -2.0..2.0f64);
    proptest::collection::vec((command(), command()).prop_map(|(a, b)| [a, b]), 5..40)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn nothing_overlaps_after_any_commands(commands in commands()) {
        let (mut world, robots) = yard();
        for pair in commands {
            for (robot, (v, w)) in robots.into_iter().zip(pair) {
                world.command(robot, Twist2::new(v, w)).unwrap();
            }
            for _ in 0..12 {
                world.advance_to(world.now() + 5 * STEP_NS);
                check_nothing_overlaps(&world)?;
            }
        }
    }

    #[test]
    fn a_run_with_movable_things_does_not_depend_on_the_size_of_its_time_steps(commands in commands(), slice in 1..300_000_000u64) {
        let run = |slice: u64| {
            let (mut world, robots) = yard();
            for pair in &commands {
                for (robot, (v, w)) in robots.into_iter().zip(pair) {
                    world.command(robot, Twist2::new(*v, *w)).unwrap();
                }
                let end = world.now() + 600_000_000;
                let mut time = world.now();
                while time < end {
                    time = (time + slice).min(end);
                    world.advance_to(time);
                }
            }
            let shapes: Vec<_> = world.shapes().map(|shape| format!("{:?}", shape.outline)).collect();
            (shapes, robots.map(|robot| world.truth(robot)))
        };
        prop_assert_eq!(run(slice), run(u64::MAX / 4));
    }
}
