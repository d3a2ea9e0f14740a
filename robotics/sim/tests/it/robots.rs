//! Robots that are placed, removed and added, their heads and their batteries.

use jde_sim::{
    Head, HeadCommand, Odometry, OdometryOrigin, Pose2, RobotConfig, RobotId, STEP_NS, Twist2, World,
    WorldError,
};
use proptest::prelude::*;

const SECOND: u64 = 1_000_000_000;
const ROOM: &str = "
    walls  = [{ name = 'wall', points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]
    robots = { r = { start = { x = 1, y = 2 } }, other = { start = { x = 5, y = 2 } } }";

fn room() -> (World, RobotId) {
    let mut world = World::parse(ROOM, "robots.toml", 3).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

fn run(world: &mut World, seconds: f64) {
    world.advance_to(world.now() + (seconds * 1e9).round() as u64);
}

#[test]
fn placing_a_robot_stops_it_and_does_not_change_its_odometry() {
    let (mut world, robot) = room();
    world.command(robot, Twist2::new(0.4, 0.2)).unwrap();
    run(&mut world, 2.0);
    let (odometry, encoders) = (world.odometry(robot).pose, world.encoders(robot));
    let target = Pose2::new(4.0, 1.0, 2.0);
    world.place(robot, target).unwrap();
    run(&mut world, 1.0);
    let truth = world.truth(robot);
    assert_eq!(
        (truth.pose, truth.twist, truth.collisions),
        (target, Twist2::default(), 0)
    );
    assert_eq!(
        (world.odometry(robot).pose, world.encoders(robot)),
        (odometry, encoders)
    );
    world.command(robot, Twist2::new(0.4, 0.0)).unwrap();
    run(&mut world, 2.0);
    let way = world.truth(robot).pose.distance(target);
    assert!(
        (world.odometry(robot).pose.distance(odometry) - way).abs() < 0.01,
        "{way}"
    );
}

#[test]
fn a_robot_cannot_be_placed_inside_things() {
    let (mut world, robot) = room();
    world.add_robot("other", RobotConfig::default()).unwrap();
    let before = world.truth(robot);
    for (x, y, obstacle, distance) in [(5.9, 1.0, "`wall`", "0.150 m"), (4.6, 2.0, "`other`", "0.100 m")] {
        let error = world.place(robot, Pose2::new(x, y, 0.0)).unwrap_err();
        assert!(matches!(error, WorldError::PlaceBlocked { .. }), "{error:?}");
        let text = error.to_string();
        assert!(
            text.contains("robot `r`") && text.contains(obstacle) && text.contains(distance),
            "{text}"
        );
    }
    for invalid in [f64::NAN, f64::INFINITY, -1.0] {
        let error = world
            .place(
                robot,
                Pose2 {
                    x: invalid,
                    y: 1.0,
                    heading: 0.0,
                },
            )
            .unwrap_err();
        assert!(matches!(error, WorldError::BadPlace { .. }), "{error:?}");
    }
    assert_eq!(world.truth(robot), before);
}

#[test]
fn placing_a_robot_at_a_wall_is_no_collision() {
    let (mut world, robot) = room();
    world.place(robot, Pose2::new(0.2505, 2.0, 0.0)).unwrap();
    run(&mut world, 1.0);
    let truth = world.truth(robot);
    assert!(truth.contact && truth.collisions == 0, "{truth:?}");
}

#[test]
fn a_robot_that_is_removed_and_added_is_in_its_initial_state() {
    let (mut world, robot) = room();
    let initial = (world.truth(robot), world.odometry(robot), world.battery(robot));
    world.command(robot, Twist2::new(0.4, 0.0)).unwrap();
    run(&mut world, 3.0);
    world.remove_robot(robot);
    assert_eq!(world.robots().count(), 0);
    assert!(
        world.cast_ray([1.0, 2.0], 0.0, 20.0, None).unwrap() > 4.9,
        "the removed robot is no obstacle"
    );
    let again = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(again, robot);
    assert_eq!(
        (world.truth(again), world.odometry(again), world.battery(again)),
        initial
    );
}

#[test]
fn a_robot_cannot_be_added_where_another_robot_is() {
    let (mut world, robot) = room();
    world.remove_robot(robot);
    let other = world.add_robot("other", RobotConfig::default()).unwrap();
    world.place(other, Pose2::new(1.2, 2.0, 0.0)).unwrap();
    let error = world
        .add_robot("r", RobotConfig::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("`other`") && error.contains("robots.toml:3"),
        "{error}"
    );
}

#[test]
fn a_reset_of_the_odometry_does_not_change_the_ticks() {
    let mut world = World::parse(ROOM, "robots.toml", 3).unwrap();
    let config = RobotConfig {
        odometry_origin: OdometryOrigin::StartPose,
        ..RobotConfig::default()
    };
    let robot = world.add_robot("r", config).unwrap();
    world.command(robot, Twist2::new(0.4, 0.3)).unwrap();
    run(&mut world, 3.0);
    let (before, encoders) = (world.odometry(robot), world.encoders(robot));
    world.reset_odometry(robot);
    assert_eq!(
        world.odometry(robot),
        Odometry {
            pose: Pose2::default(),
            ..before
        }
    );
    assert_eq!(world.encoders(robot), encoders);
}

/// Creates a head command from degrees.
fn head_command(pan: f64, tilt: f64, pan_speed: f64, tilt_speed: f64) -> HeadCommand {
    HeadCommand {
        pan: pan.to_radians(),
        tilt: tilt.to_radians(),
        pan_speed: pan_speed.to_radians(),
        tilt_speed: tilt_speed.to_radians(),
    }
}

#[track_caller]
fn assert_head(head: Head, pan: f64, tilt: f64) {
    let found = [head.pan.to_degrees(), head.tilt.to_degrees()];
    assert!(
        (found[0] - pan).abs() < 1e-9 && (found[1] - tilt).abs() < 1e-9,
        "{found:?}"
    );
}

#[test]
fn a_head_turns_to_the_commanded_angles_at_the_commanded_speeds() {
    let (mut world, robot) = room();
    world
        .command_head(robot, head_command(45.0, -20.0, 30.0, -10.0))
        .unwrap();
    run(&mut world, 1.0);
    assert_head(world.head(robot), 30.0, -10.0);
    let head = world.head(robot);
    assert!((head.pan_velocity - 30f64.to_radians()).abs() < 1e-9, "{head:?}");
    assert!((head.tilt_velocity + 10f64.to_radians()).abs() < 1e-9, "{head:?}");
    run(&mut world, 5.0);
    let (pan, tilt) = (45f64.to_radians(), -20f64.to_radians());
    assert_eq!(
        world.head(robot),
        Head {
            pan,
            tilt,
            pan_velocity: 0.0,
            tilt_velocity: 0.0
        }
    );
}

#[test]
fn a_head_command_with_speed_0_holds_the_axis() {
    let (mut world, robot) = room();
    world
        .command_head(robot, head_command(40.0, 20.0, 60.0, 60.0))
        .unwrap();
    run(&mut world, 2.0);
    world
        .command_head(robot, head_command(-40.0, 0.0, 0.0, 10.0))
        .unwrap();
    run(&mut world, 1.0);
    assert_head(world.head(robot), 40.0, 10.0);
    world.command_head(robot, HeadCommand::default()).unwrap();
    run(&mut world, 1.0);
    assert_head(world.head(robot), 40.0, 10.0);
}

#[test]
fn a_head_keeps_its_limits() {
    let (mut world, robot) = room();
    world
        .command_head(robot, head_command(170.0, -170.0, 1e4, 1e4))
        .unwrap();
    run(&mut world, 1.0);
    assert_head(world.head(robot), 90.0, -70.0);
    run(&mut world, 1.0);
    assert_head(world.head(robot), 98.0, -88.0);
    world
        .command_head(robot, head_command(-170.0, 170.0, 90.0, 70.0))
        .unwrap();
    run(&mut world, 5.0);
    assert_head(world.head(robot), -98.0, 30.0);
    let error = world
        .command_head(robot, head_command(f64::NAN, 0.0, 1.0, 1.0))
        .unwrap_err();
    assert!(error.to_string().contains("head of robot `r`"), "{error}");
    run(&mut world, 1.0);
    assert_head(world.head(robot), -98.0, 30.0);
}

#[test]
fn invalid_values_of_a_head_are_reported() {
    let mut world = World::parse(ROOM, "robots.toml", 3).unwrap();
    let mut config = RobotConfig::default();
    config.head.max_pan_speed = -1.0;
    let error = world.add_robot("r", config).unwrap_err().to_string();
    assert!(error.contains("head max_pan_speed is -1"), "{error}");
}

#[test]
fn a_robot_charges_on_a_charger_alone_until_its_battery_is_full() {
    let chargers = "bounds = { min = [0, 0], max = [4, 4] }\nchargers = [{ place = [2, 1], current = 20 }]\n[robots.r]\nstart = { x = 1, y = 1 }";
    let mut world = World::parse(chargers, "chargers.toml", 0).unwrap();
    let config = RobotConfig {
        battery_capacity: 0.1,
        ..RobotConfig::default()
    };
    let robot = world.add_robot("r", config).unwrap();
    world.advance_to(60 * SECOND);
    let idle = world.battery(robot);
    assert!(idle.current < 0.0 && idle.charge < 0.8, "{idle:?}");
    world.place(robot, Pose2::new(2.05, 1.0, 0.0)).unwrap();
    world.advance_to(61 * SECOND);
    let charging = world.battery(robot);
    assert!(
        charging.current > 0.0 && charging.voltage > idle.voltage,
        "{charging:?}"
    );
    let gained = (charging.charge - idle.charge) * charging.capacity * 3600.0;
    assert!((gained - charging.current).abs() < 0.1, "{gained} As in a second");
    world.advance_to(200 * SECOND);
    let full = world.battery(robot);
    assert_eq!((full.charge, full.current), (1.0, 0.0));
    world.place(robot, Pose2::new(2.11, 1.0, 0.0)).unwrap();
    world.advance_to(201 * SECOND);
    assert!(world.battery(robot).charge < 1.0);
}

#[test]
fn a_battery_loses_the_charge_of_its_current() {
    let (mut world, robot) = room();
    let full = world.battery(robot);
    assert_eq!(full.charge, 1.0);
    run(&mut world, 3600.0);
    let idle = world.battery(robot);
    assert!(idle.current < 0.0 && idle.current == full.current, "{idle:?}");
    let lost = (full.charge - idle.charge) * jde_sim::BATTERY_CAPACITY;
    assert!(
        (lost + idle.current).abs() < 1e-6,
        "one hour at {} A used {lost} Ah",
        idle.current
    );
    assert!(idle.voltage < full.voltage && idle.voltage > 11.7, "{idle:?}");
}

#[test]
fn the_voltage_drops_while_the_robot_drives_and_more_while_it_is_stalled() {
    let (mut world, robot) = room();
    let idle = world.battery(robot).voltage;
    world.command(robot, Twist2::new(0.8, 0.0)).unwrap();
    run(&mut world, 3.0);
    let driving = world.battery(robot).voltage;
    run(&mut world, 10.0);
    assert!(world.truth(robot).stalled);
    let stalled = world.battery(robot).voltage;
    assert!(
        idle - driving > 0.03 && driving - stalled > 0.05,
        "{idle} {driving} {stalled}"
    );
    world.command(robot, Twist2::default()).unwrap();
    run(&mut world, 1.0);
    assert!(idle - world.battery(robot).voltage < 0.01, "the voltage recovers");
}

#[test]
fn an_empty_battery_stays_empty() {
    let (mut world, robot) = room();
    world.advance_to(14 * 3600 * SECOND);
    let battery = world.battery(robot);
    assert!(battery.charge == 0.0 && battery.voltage > 11.0, "{battery:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn a_head_never_exceeds_its_limits_and_speeds(
        commands in proptest::collection::vec((-4.0..4.0f64, -4.0..4.0f64, -3.0..3.0f64, -3.0..3.0f64), 1..20),
    ) {
        let (mut world, robot) = room();
        let config = world.config(robot).head.clone();
        for (pan, tilt, pan_speed, tilt_speed) in commands {
            world.command_head(robot, HeadCommand { pan, tilt, pan_speed, tilt_speed }).unwrap();
            for _ in 0..20 {
                let before = world.head(robot);
                world.advance_to(world.now() + STEP_NS);
                let head = world.head(robot);
                prop_assert!(head.pan.abs() <= config.max_pan, "{:?}", head);
                prop_assert!((-config.max_tilt_up..=config.max_tilt_down).contains(&head.tilt), "{:?}", head);
                prop_assert!(head.pan_velocity.abs() <= pan_speed.abs().min(config.max_pan_speed) + 1e-9);
                prop_assert!(head.tilt_velocity.abs() <= tilt_speed.abs().min(config.max_tilt_speed) + 1e-9);
                prop_assert!((head.pan - before.pan - head.pan_velocity * 0.01).abs() < 1e-12);
            }
        }
    }
}
