//! The worlds of the project have no faults, and suit their purpose.

use std::path::{Path, PathBuf};

use jde_sim::{LaserConfig, Pose2, RobotConfig, RobotId, Twist2, World, wrap_angle};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../worlds")
        .join(name)
}

fn world(name: &str) -> World {
    World::load(path(name), 11).unwrap()
}

/// Returns the targets of a tour of the office, from a comment in its file.
fn tour() -> Vec<[f64; 2]> {
    let text = std::fs::read_to_string(path("office.toml")).unwrap();
    let targets = text
        .lines()
        .filter_map(|line| line.strip_prefix("#     [")?.split_once(']'));
    let number = |text: &str| text.trim().parse().unwrap();
    targets
        .map(|(point, _)| {
            point
                .split_once(',')
                .map(|(x, y)| [number(x), number(y)])
                .unwrap()
        })
        .collect()
}

#[test]
fn every_world_is_valid_and_its_robots_fit() {
    let mut count = 0;
    let files = |folder: &str| std::fs::read_dir(path(folder)).unwrap();
    for entry in files("").chain(files("barn")) {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "toml") {
            let mut world = World::load(&file, 1).unwrap_or_else(|error| panic!("{error}"));
            assert!(world.warnings().is_empty(), "{:?}", world.warnings());
            let robots: Vec<String> = world.robot_names().map(str::to_owned).collect();
            assert!(!robots.is_empty(), "{} has no robot", file.display());
            for robot in robots {
                world
                    .add_robot(&robot, RobotConfig::default())
                    .unwrap_or_else(|error| panic!("{error}"));
            }
            count += 1;
        }
    }
    assert!(count >= 305, "{count} worlds");
}

#[test]
fn the_world_file_of_the_documentation_is_valid() {
    let source = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let (_, rest) = source.split_once("//! ```toml\n").unwrap();
    let (block, _) = rest.split_once("//! ```\n").unwrap();
    let text: String = block
        .lines()
        .map(|line| line.trim_start_matches("//!").to_owned() + "\n")
        .collect();
    let world = World::parse(&text, path("map/shed.toml"), 0).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((world.name(), world.warnings()), ("shed", &[][..]));
    assert!(
        world.shapes().count() > 11,
        "walls, desk, carton, post, ball, cart, anna and the map"
    );
}

#[test]
fn the_tour_of_the_office_is_clear_of_fixed_things() {
    let mut world = world("office.toml");
    let robot = world.add_robot("pioneer", RobotConfig::default()).unwrap();
    let start = world.truth(robot).pose;
    let tour = tour();
    assert!((6..=9).contains(&tour.len()), "{tour:?}");
    let mut from = [start.x, start.y];
    for to in tour {
        let length = f64::hypot(to[0] - from[0], to[1] - from[1]);
        let angle = f64::atan2(to[1] - from[1], to[0] - from[0]);
        // Parallel rays check that no fixed thing is nearer than 0.7 m.
        for offset in -70..=70 {
            let offset = f64::from(offset) / 100.0;
            let origin = [from[0] - offset * angle.sin(), from[1] + offset * angle.cos()];
            let hit = cast_ray_at_fixed(&world, origin, angle, length);
            assert_eq!(hit, None, "from {from:?} to {to:?}, offset {offset} m");
        }
        from = to;
    }
    assert_eq!(from, [start.x, start.y], "the tour ends at its start");
}

/// Casts a ray. Returns the distance to the hit, or `None` if that is near a mover or a robot.
fn cast_ray_at_fixed(world: &World, origin: [f64; 2], angle: f64, length: f64) -> Option<f64> {
    let distance = world.cast_ray(origin, angle, length, None)?;
    let point = [
        origin[0] + distance * angle.cos(),
        origin[1] + distance * angle.sin(),
    ];
    let mover = world
        .shapes()
        .filter(|shape| shape.moving)
        .any(|shape| match shape.outline {
            jde_sim::Outline::Circle { center, .. } | jde_sim::Outline::Box { center, .. } => {
                f64::hypot(center[0] - point[0], center[1] - point[1]) < 0.6
            }
            jde_sim::Outline::Segment { .. } => false,
        });
    let robot = world.robots().any(|(id, _)| {
        let pose = world.truth(id).pose;
        f64::hypot(pose.x - point[0], pose.y - point[1]) < 0.26
    });
    if mover || robot { None } else { Some(distance) }
}

/// Commands a robot to turn and drive to a target, and to halt while something is close ahead. Returns the
/// distance to the target.
fn drive(
    world: &mut World,
    robot: RobotId,
    target: [f64; 2],
    laser: &LaserConfig,
    ranges: &mut [f32],
) -> f64 {
    let pose = world.truth(robot).pose;
    let distance = Pose2::new(target[0], target[1], 0.0).distance(pose);
    let error = wrap_angle(f64::atan2(target[1] - pose.y, target[0] - pose.x) - pose.heading);
    world.laser(robot, laser, ranges).unwrap();
    let blocked = ranges.iter().enumerate().any(|(beam, &range)| {
        let (x, y) = (
            f64::from(range) * laser.angle(beam).cos(),
            f64::from(range) * laser.angle(beam).sin(),
        );
        range == f32::NEG_INFINITY || (x < 0.75 && y.abs() < 0.3)
    });
    let ahead = if blocked || error.abs() > 0.3 { 0.0 } else { 0.4 };
    world
        .command(robot, Twist2::new(ahead, (1.5 * error).clamp(-0.9, 0.9)))
        .unwrap();
    distance
}

#[test]
fn a_robot_that_stops_for_people_completes_the_tour_without_a_collision() {
    let mut world = world("office.toml");
    let robot = world.add_robot("pioneer", RobotConfig::default()).unwrap();
    let laser = LaserConfig::default();
    let mut ranges = vec![0.0; laser.beams];
    for target in tour() {
        // After ten minutes for one leg, something blocks it forever.
        let deadline = world.now() + 600_000_000_000;
        while drive(&mut world, robot, target, &laser, &mut ranges) > 0.3 {
            assert!(
                world.now() < deadline,
                "stuck before {target:?}: {:?}",
                world.truth(robot)
            );
            world.advance_to(world.now() + 70_000_000);
        }
    }
    let truth = world.truth(robot);
    assert!(truth.collisions == 0 && truth.min_clearance > 0.05, "{truth:?}");
    assert!(truth.travelled > 50.0, "{truth:?}");
}

#[test]
fn a_pillar_hides_two_robots_from_each_other_at_their_starts() {
    let mut world = world("two-robots.toml");
    let left = world.add_robot("left", RobotConfig::default()).unwrap();
    let right = world.add_robot("right", RobotConfig::default()).unwrap();
    let (a, b) = (world.truth(left).pose, world.truth(right).pose);
    let distance = |origin: Pose2, except| {
        world
            .cast_ray([origin.x, origin.y], origin.heading, 20.0, Some(except))
            .unwrap()
    };
    assert!((distance(a, left) - 2.2).abs() < 1e-9 && (distance(b, right) - 2.2).abs() < 1e-9);
    let beside_pillar = Pose2::new(1.5, 3.2, f64::atan2(2.5 - 3.2, 5.0));
    let visible = world
        .cast_ray(
            [beside_pillar.x, beside_pillar.y],
            beside_pillar.heading,
            20.0,
            Some(left),
        )
        .unwrap();
    assert!(
        (visible - (f64::hypot(5.0, 0.7) - 0.25)).abs() < 1e-9,
        "{visible}"
    );
}

#[test]
fn the_rooms_have_a_door_between_them() {
    let world = world("rooms.toml");
    let distance = |y: f64| world.cast_ray([1.0, y], 0.0, 20.0, None).unwrap();
    // The wall between the rooms is the column from 2.9 m; the door is open from 1.4 m to 2.8 m, and the far
    // wall is at 5.8 m.
    assert!(
        (distance(0.5) - 1.9).abs() < 1e-9 && (distance(2.0) - 4.8).abs() < 1e-9,
        "{} {}",
        distance(0.5),
        distance(2.0)
    );
}
