//! Closed loops along paths and around what stands on them, the brake, and input that must not move the robot.

use core::f64::consts::PI;

use jde_motion::BaseDynamics;
use jde_schema::bench::Bench;

use super::*;
use crate::bench::{Loop, Wall, room, scan};

fn route(places: &[(f64, f64)]) -> Route {
    Route {
        poses: places.iter().map(|&(x, y)| Pose2D::new(x, y, 0.0)).collect(),
    }
}

/// A robot at the origin along x, among walls, with a path.
fn world(walls: Vec<Wall>, places: &[(f64, f64)]) -> Loop<Mppi> {
    let mut world = Loop::new(walls, Pose2D::ORIGIN);
    world.bench.unbind("path");
    world.bench.set("route", route(places));
    world
}

fn command(bench: &mut Bench<Mppi>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

fn mission(bench: &Bench<Mppi>) -> Mission {
    bench.exported("mission").expect("it is published")
}

fn is_under_way(world: &Loop<Mppi>) -> bool {
    let mission: Option<Mission> = world.bench.exported("mission");
    mission.is_none_or(|mission| mission.state == Mission::RUNNING)
}

#[test]
fn it_follows_a_path_with_a_corner_to_its_end() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
    world.drive_while(30, is_under_way);
    let end = Pose2D::new(2.0, 2.0, 0.0);
    assert!(world.travel.pose.distance_to(&end) < 0.16, "{:?}", world.travel);
    assert_eq!(mission(&world.bench).state, Mission::DONE);
    assert!(world.distance < 4.2, "{} m", world.distance);
}

#[test]
fn it_goes_around_what_stands_on_its_path() {
    let mut world = world(room((1.8, -0.1), (2.0, 0.1)), &[(0.0, 0.0), (4.0, 0.0)]);
    world.drive_while(30, is_under_way);
    assert_eq!(mission(&world.bench).state, Mission::DONE, "{:?}", world.travel);
    assert!(world.clearance > 0.03, "{} m", world.clearance);
}

#[test]
fn a_base_that_reacts_late_goes_around_what_stands_on_its_path() {
    let mut world = world(room((1.8, -0.1), (2.0, 0.1)), &[(0.0, 0.0), (4.0, 0.0)]);
    world.dynamics = BaseDynamics {
        acceleration: 2.0,
        deceleration: 2.0,
        turn_acceleration: 4.0,
        turn_deceleration: 4.0,
        lag: 0.4,
    };
    world.bench.import("dynamics", &world.dynamics);
    world.bench.set("vx_max", 1.0);
    world.drive_while(30, is_under_way);
    assert_eq!(mission(&world.bench).state, Mission::DONE, "{:?}", world.travel);
    assert!(world.clearance > 0.03, "{} m", world.clearance);
}

#[test]
fn a_base_that_slows_down_by_less_than_it_speeds_up_stands_at_the_end() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (4.0, 0.0)]);
    world.dynamics = BaseDynamics {
        acceleration: 2.0,
        deceleration: 0.3,
        ..world.dynamics
    };
    world.bench.import("dynamics", &world.dynamics);
    world.bench.set("vx_max", 0.8);
    world.drive_while(30, is_under_way);
    world.drive_while(5, |_| true);
    assert!((world.travel.pose.x - 4.0).abs() < 0.2, "{:?}", world.travel);
}

#[test]
fn it_turns_to_the_last_heading_if_that_counts() {
    let mut world = world(Vec::new(), &[]);
    world.bench.set("yaw_goal_tolerance", 0.1);
    let poses = [Pose2D::ORIGIN, Pose2D::new(1.0, 0.0, PI / 2.0)];
    world.bench.set(
        "route",
        Route {
            poses: poses.into_iter().collect(),
        },
    );
    world.drive_while(30, is_under_way);
    assert_eq!(mission(&world.bench).state, Mission::DONE, "{:?}", world.travel);
    assert!((world.travel.pose.theta - PI / 2.0).abs() < 0.15);
}

#[test]
fn a_car_is_at_its_end_with_any_heading() {
    let mut world = world(Vec::new(), &[]);
    world.bench.set("min_turning_r", 0.5);
    let poses = [Pose2D::ORIGIN, Pose2D::new(1.5, 0.0, PI)];
    world.bench.set(
        "route",
        Route {
            poses: poses.into_iter().collect(),
        },
    );
    world.drive_while(30, is_under_way);
    assert_eq!(mission(&world.bench).state, Mission::DONE, "{:?}", world.travel);
    assert!(
        world.travel.pose.distance_to(&poses[1]) < 0.2,
        "{:?}",
        world.travel
    );
}

#[test]
fn it_touches_nothing_wherever_its_path_leads() {
    for step in 0..4 {
        let (sin, cos) = (f64::from(step) * PI / 2.0 + 0.3).sin_cos();
        let walls = room((-1.5, -1.0), (1.5, 1.0));
        let mut world = world(walls, &[(0.0, 0.0), (3.0 * cos, 3.0 * sin)]);
        world.drive_while(15, |_| true);
        assert!(world.clearance > 0.01, "{} m in case {step}", world.clearance);
        assert_eq!(mission(&world.bench).state, Mission::RUNNING);
    }
}

#[test]
fn it_brakes_at_once_before_what_appears_within_the_way_to_stop_and_says_so() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]);
    world.drive_while(4, |_| true);
    assert!(world.travel.velocity.linear.x > 0.35, "{:?}", world.travel);
    let speed = world.travel.velocity.linear.x;
    let way_to_stop = speed * speed / (2.0 * 0.3);
    let x = world.travel.pose.x + crate::bench::RADIUS + way_to_stop + 0.03;
    world.walls.push([(x, -3.0), (x, 3.0)]);
    world.sense();
    assert_eq!(command(&mut world.bench).linear.x, 0.0);
    let note = mission(&world.bench).note;
    assert!(note.as_str().starts_with("something is in the way"), "{note:?}");
    world.drive_while(5, |_| true);
    assert!(world.clearance > 0.0, "{} m", world.clearance);
}

#[test]
fn what_went_out_of_sight_is_not_forgotten_at_once() {
    let mut world = world(vec![[(-1.0, 0.6), (1.0, 0.6)]], &[(0.0, 0.0), (5.0, 0.0)]);
    command(&mut world.bench);
    let behind = |world: &Loop<Mppi>| {
        let surroundings = world.bench.schema().surroundings.as_ref().expect("it is awake");
        let points = surroundings.points().iter();
        points.filter(|point| point.x < -0.05).count()
    };
    assert_eq!(behind(&world), 0, "the laser looks ahead");
    // A turn in one step would be a jump.
    for part in 1..=8 {
        world.travel.pose.theta = f64::from(part) * PI / 8.0;
        world.sense();
        command(&mut world.bench);
    }
    assert!(behind(&world) > 10, "it was seen before");
    world.now = Duration::from_secs(60);
    world.sense();
    command(&mut world.bench);
    assert_eq!(behind(&world), 0);
}

#[test]
fn the_same_drive_repeats_to_the_bit() {
    let drive = || {
        let mut world = world(room((1.5, -0.1), (1.7, 0.2)), &[(0.0, 0.0), (3.0, 0.0)]);
        world.drive_while(3, |_| true);
        world.travel
    };
    assert_eq!(drive(), drive());
}

#[test]
fn without_a_path_or_a_usable_scan_or_pose_it_is_not_ready_and_stands_still() {
    let mut blind = scan(&[], &Pose2D::ORIGIN);
    blind.ranges.as_mut_slice().fill(f32::NAN);
    for spoil in [
        &(|bench: &mut Bench<Mppi>| bench.retract("laser")) as &dyn Fn(&mut Bench<Mppi>),
        &|bench| bench.retract("pose"),
        &|bench| bench.set("route", Route::EMPTY),
        &|bench| bench.import("laser", &blind),
        &|bench| {
            let nowhere = Pose2D::new(1e300, f64::INFINITY, 0.0);
            bench.import("pose", &Odometry::planar(Time::default(), nowhere, Twist::ZERO));
        },
        &|bench| {
            let far = Pose2D::new(1e300, 0.0, 0.0);
            bench.import("pose", &Odometry::planar(Time::default(), far, Twist::ZERO));
        },
    ] {
        let mut world = world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]);
        world.drive_while(1, |_| true);
        spoil(&mut world.bench);
        assert!(!world.bench.check().expect("the check succeeds").ready);
        assert_eq!(command(&mut world.bench), Twist::ZERO);
    }
}

#[test]
fn the_panel_shows_the_way_left() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]);
    command(&mut world.bench);
    let panel = world.bench.draw().expect("the panel is drawn");
    assert!((panel.value("left") - 5.0).abs() < 1e-9);
}
