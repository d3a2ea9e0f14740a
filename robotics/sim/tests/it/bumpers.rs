//! The bumpers that a contact presses.

use jde_sim::{RobotConfig, RobotId, Twist2, World};

const HALL: &str = "
    walls  = [{ name = 'wall', points = [[-4, -3], [6, -3], [6, 3], [-4, 3]], closed = true }]
    robots = { r = { start = { x = 0, y = 0 } }, s = { start = { x = 3, y = 0 } } }";

fn hall(seed: u64) -> (World, RobotId) {
    let mut world = World::parse(HALL, "hall.toml", seed).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

#[test]
fn a_contact_presses_the_bumper_at_its_position() {
    // Backwards against the wall x = -4, then ahead against the other robot.
    let (mut world, robot) = hall(1);
    world.add_robot("s", RobotConfig::default()).unwrap();
    assert!(!world.bumpers(robot).any());
    world.command(robot, Twist2::new(-0.5, 0.0)).unwrap();
    world.advance_to(15_000_000_000);
    let bumpers = world.bumpers(robot);
    assert_eq!(
        (bumpers.front, bumpers.rear),
        ([false; 5], [false, false, true, false, false])
    );
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    world.advance_to(40_000_000_000);
    let bumpers = world.bumpers(robot);
    assert_eq!(
        (bumpers.front, bumpers.rear),
        ([false, false, true, false, false], [false; 5])
    );
}

#[test]
fn a_contact_at_the_left_of_the_front_presses_the_left_front_bumper() {
    let text = "
        circles = [{ center = [1, 0.32], radius = 0.1 }]
        robots  = { r = { start = { x = 0, y = 0 } } }";
    let mut world = World::parse(text, "post.toml", 0).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    world.command(robot, Twist2::new(0.3, 0.0)).unwrap();
    world.advance_to(10_000_000_000);
    // The centres are 0.35 m apart, 0.32 m across: the contact is at asin(0.32 / 0.35) = 66 degrees.
    assert_eq!(world.bumpers(robot).front, [true, false, false, false, false]);
}

#[test]
fn bumpers_turn_with_the_robot() {
    let text = "
        walls  = [{ points = [[-5, 1], [5, 1]] }]
        robots = { r = { start = { x = 0, y = 0, heading_deg = 90 } } }";
    let mut world = World::parse(text, "wall.toml", 0).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    world.command(robot, Twist2::new(0.3, 0.0)).unwrap();
    world.advance_to(10_000_000_000);
    assert_eq!(world.bumpers(robot).front, [false, false, true, false, false]);
    // A quarter turn to the left: the wall is at the right wheel, where there is no bumper.
    world.command(robot, Twist2::new(0.0, 0.5)).unwrap();
    while world.truth(robot).pose.heading.to_degrees() < 175.0 && world.truth(robot).pose.heading > 0.0 {
        world.advance_to(world.now() + 10_000_000);
    }
    assert!(world.truth(robot).contact && !world.bumpers(robot).any());
}
