//! The outline on the map, the window of velocities, and closed loops among walls that the map has.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_motion::BaseDynamics;
use jde_schema::bench::Bench;
use jde_schema::types::{Footprint, Path, Pose, PoseStamped};

use super::window::Contact;
use super::*;
use crate::bench::{Loop, RADIUS, Wall, room};

const RESOLUTION: f64 = 0.05;
/// Cells from the zero to each side of a map.
const HALF_CELLS: u32 = 120;

/// A map of 12 m around the zero, free but for the cells on these walls.
fn map(walls: &[Wall]) -> Box<OccupancyGrid> {
    let side = 2 * HALF_CELLS;
    let mut map = OccupancyGrid::boxed();
    map.info.resolution = RESOLUTION as f32;
    (map.info.width, map.info.height) = (side, side);
    let corner = -f64::from(HALF_CELLS) * RESOLUTION;
    map.info.origin = Pose2D::new(corner, corner, 0.0).into();
    map.data.resize((side * side) as usize);
    for [from, to] in walls {
        let steps = ((to.0 - from.0).hypot(to.1 - from.1) / 0.02).ceil();
        for step in 0..=steps as u32 {
            let share = f64::from(step) / steps;
            let at = |from: f64, to: f64| ((from + share * (to - from) - corner) / RESOLUTION) as usize;
            map.data.as_mut_slice()[at(from.1, to.1) * side as usize + at(from.0, to.0)] = 100;
        }
    }
    map
}

fn path(places: &[(f64, f64)]) -> Path {
    let mut path = Path::default();
    for &(x, y) in places {
        let pose = Pose::from(Pose2D::new(x, y, 0.0));
        path.poses
            .push(PoseStamped {
                pose,
                ..PoseStamped::default()
            })
            .expect("few poses");
    }
    path
}

/// A robot at `pose` among walls, with a map of them and a path.
fn world(walls: Vec<Wall>, pose: Pose2D, places: &[(f64, f64)]) -> Loop<Dwa> {
    let mut world = Loop::new(walls, pose);
    world.bench.import("map", &*map(&world.walls));
    world.bench.import("path", &path(places));
    world
}

fn note(bench: &Bench<Dwa>) -> String {
    let mission: Mission = bench.exported("mission").expect("it is published");
    mission.note.as_str().to_owned()
}

/// Drives until the robot is at the end, and returns how far from `goal` it is.
fn drive(world: &mut Loop<Dwa>, seconds: u32, goal: (f64, f64)) -> f64 {
    world.drive_while(seconds, |world| note(&world.bench) != "at the end of the path");
    let Pose2D { x, y, .. } = world.travel.pose;
    (x - goal.0).hypot(y - goal.1)
}

#[test]
fn it_follows_a_path_around_a_corner_to_its_end() {
    let places = [(0.0, 0.0), (2.5, 0.0), (2.5, 2.5)];
    let mut world = world(room((-1.0, -1.0), (3.5, 3.5)), Pose2D::ORIGIN, &places);
    world.bench.iterate().expect("it iterates");
    assert!(drive(&mut world, 60, (2.5, 2.5)) < 0.2);
    assert!(world.clearance > 0.3, "{}", world.clearance);
}

#[test]
fn it_leaves_the_path_for_what_is_on_the_map() {
    let mut walls = room((-1.0, -2.0), (5.0, 2.0));
    walls.extend(room((1.9, 0.2), (2.1, 0.6)));
    let mut world = world(walls, Pose2D::ORIGIN, &[(0.0, 0.0), (4.0, 0.0)]);
    world.bench.iterate().expect("it iterates");
    assert!(drive(&mut world, 60, (4.0, 0.0)) < 0.2, "{:?}", world.travel.pose);
    assert!(world.clearance > 0.02, "{}", world.clearance);
}

#[test]
fn it_turns_on_the_spot_towards_a_path_behind_it_and_stays_in_the_corridor() {
    let walls = room((-5.0, -0.6), (1.0, 0.6));
    let mut world = world(walls, Pose2D::ORIGIN, &[(0.0, 0.0), (-4.0, 0.0)]);
    world.bench.iterate().expect("it iterates");
    assert!(
        drive(&mut world, 60, (-4.0, 0.0)) < 0.2,
        "{:?}",
        world.travel.pose
    );
    assert!(world.clearance > 0.05, "{}", world.clearance);
}

#[test]
fn before_what_only_the_laser_sees_it_stops_and_says_where_it_is() {
    let mut world = world(
        room((-1.0, -1.0), (5.0, 1.0)),
        Pose2D::ORIGIN,
        &[(0.0, 0.0), (4.0, 0.0)],
    );
    // Across the whole corridor, and not on the map.
    world.walls.push([(2.0, -1.0), (2.0, 1.0)]);
    world.drive_while(60, |_| true);
    assert!(world.clearance > 0.0, "{}", world.clearance);
    assert!(world.distance > 1.0, "{}", world.distance);
    assert!(
        note(&world.bench).contains("in the way"),
        "{}",
        note(&world.bench)
    );
}

/// A robot that cannot turn on the spot, with a wall too near ahead.
fn enclosed(behind: f64) -> Loop<Dwa> {
    let walls = room((behind, -0.32), (0.38, 0.38));
    let mut world = world(walls, Pose2D::ORIGIN, &[(0.0, 0.0), (4.0, 0.0)]);
    world.bench.set("vx_min", 0.2);
    world.bench.set("min_in_place_vel_theta", 2.0);
    world.bench.iterate().expect("it iterates");
    assert_eq!(note(&world.bench), "every arc touches something");
    world
}

#[test]
fn a_base_that_stands_below_a_turn_rate_turns_to_the_last_heading() {
    let start = Pose2D::new(0.0, 0.0, 0.1);
    let mut world = world(room((-1.0, -1.0), (5.0, 1.0)), start, &[(0.0, 0.0)]);
    world.bench.set("yaw_goal_tolerance", 0.05);
    world.dead_band = 0.29;
    world.bench.iterate().expect("it iterates");
    world.drive_while(20, |world| note(&world.bench) != "at the end of the path");
    assert!(world.travel.pose.theta.abs() < 0.05, "{:?}", world.travel.pose);
}

#[test]
fn boxed_in_it_stands_and_says_so() {
    let mut world = enclosed(-0.32);
    world.drive_while(5, |_| true);
    assert!(world.clearance > 0.0, "{}", world.clearance);
    assert!(world.distance < 0.1, "{}", world.distance);
}

#[test]
fn before_a_wall_it_backs_as_far_as_the_map_is_free() {
    let mut world = enclosed(-1.5);
    assert_eq!(world.bench.commanded("base"), Some(Twist::planar(-0.1, 0.0)));
    world.drive_while(5, |world| world.distance < 0.1);
    assert!(
        world.travel.pose.x < -0.05 && world.clearance > 0.0,
        "{:?}",
        world.travel.pose
    );
}

#[test]
fn a_robot_nearer_than_the_padding_leaves() {
    let walls = room((-3.0, -0.28), (5.0, 2.0));
    let mut world = world(walls, Pose2D::ORIGIN, &[(0.0, 0.0), (1.0, 0.5), (3.0, 0.5)]);
    world.bench.iterate().expect("it iterates");
    assert!(drive(&mut world, 60, (3.0, 0.5)) < 0.2, "{:?}", world.travel.pose);
    assert!(world.clearance > 0.01, "{}", world.clearance);
}

#[test]
fn without_any_of_its_inputs_it_is_not_ready_and_stands() {
    let places = [(0.0, 0.0), (4.0, 0.0)];
    for missing in ["laser", "pose", "path", "map", "dynamics"] {
        let mut world = world(room((-5.0, -5.0), (5.0, 5.0)), Pose2D::ORIGIN, &places);
        assert_eq!(world.bench.check().expect("it checks"), true.into());
        world.bench.retract(missing);
        assert_eq!(world.bench.check().expect("it checks"), false.into(), "{missing}");
        world.bench.iterate().expect("it iterates");
        assert_eq!(world.bench.commanded("base"), Some(Twist::ZERO), "{missing}");
        assert!(note(&world.bench).contains("dynamics"), "{}", note(&world.bench));
    }
}

#[test]
fn a_map_without_the_robot_or_of_another_size_than_it_states_moves_nothing() {
    let places = [(0.0, 0.0), (4.0, 0.0)];
    type Spoil = fn(&mut OccupancyGrid);
    let spoils: [Spoil; 4] = [
        |map| map.info.resolution = 0.0,
        |map| map.info.origin.position.x = 100.0,
        |map| map.info.width = 7,
        |map| map.info.resolution = f32::NAN,
    ];
    for spoil in spoils {
        let mut world = world(room((-5.0, -5.0), (5.0, 5.0)), Pose2D::ORIGIN, &places);
        let mut wrong = map(&[]);
        spoil(&mut wrong);
        world.bench.import("map", &*wrong);
        assert!(!world.bench.check().expect("it checks").ready);
        world.bench.iterate().expect("it iterates");
        assert_eq!(world.bench.commanded("base"), Some(Twist::ZERO));
    }
}

#[test]
fn the_outline_costs_more_the_nearer_it_is_and_nothing_may_touch_it() {
    let perimeter = Perimeter::new(&Footprint::circle(RADIUS), 0.05, RESOLUTION);
    let map = map(&[[(2.0, -1.0), (2.0, 1.0)]]);
    let window = Window::new(&map, &Pose2D::ORIGIN, 3.0, (0.3, 10.0)).expect("a window");
    let cost = |x: f64| window.contact(&Pose2D::new(x, 0.0, 0.0), &perimeter);
    assert_eq!(cost(0.0), Contact::default());
    assert!(cost(1.5).cost > cost(1.45).cost, "{:?}", cost(1.5));
    assert_eq!(cost(1.6).touching, 0);
    assert!(cost(1.75).touching > 0);
    assert!(Window::new(&map, &Pose2D::new(9.0, 0.0, 0.0), 3.0, (0.3, 10.0)).is_none());
}

#[test]
fn the_padding_moves_each_side_of_a_polygon_out() {
    let mut footprint = Footprint::default();
    for (x, y) in [(0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1)] {
        let corner = jde_schema::types::Point2D { x, y };
        footprint.points.push(corner).expect("few corners");
    }
    let perimeter = Perimeter::new(&footprint, 0.05, 0.5);
    let map = map(&[[(1.0, -1.0), (1.0, 1.0)]]);
    let window = Window::new(&map, &Pose2D::ORIGIN, 3.0, (0.0, 0.0)).expect("a window");
    let touches = |x: f64, theta: f64| window.contact(&Pose2D::new(x, 0.0, theta), &perimeter).touching > 0;
    // 0.25 m ahead of the middle, 0.15 m to its side; the wall is in the cell from 1.0 to 1.05.
    assert!(touches(0.76, 0.0) && !touches(0.74, 0.0));
    assert!(touches(0.86, FRAC_PI_2) && !touches(0.84, FRAC_PI_2));
    assert!(touches(0.76, PI) && !touches(0.74, PI));
}

fn samples(dynamics: BaseDynamics) -> Samples {
    Samples {
        count: (3, 4),
        speed: (0.0, 0.5),
        turn: (0.3, 1.0),
        dynamics,
        period: 0.1,
        horizon: 1.0,
        spin: 0.0,
    }
}

#[test]
fn the_window_is_around_what_a_lagging_base_strives_for_and_wider_where_it_brakes() {
    let samples = samples(BaseDynamics {
        acceleration: 0.5,
        deceleration: 2.0,
        turn_acceleration: 2.0,
        turn_deceleration: 4.0,
        lag: 0.2,
    });
    let bounds = |speed: f64, lead: f64, turn: f64| {
        let now = Travel {
            velocity: Twist::planar(speed, turn),
            lead: Twist::planar(lead, 0.0),
            ..Travel::default()
        };
        let twists: Vec<Twist> = samples
            .twists(&now)
            .filter(|twist| twist.linear.x > 0.0)
            .collect();
        let of = |part: fn(&Twist) -> f64| {
            let parts = twists.iter().map(part);
            let rounded = |value: f64| (value * 1e6).round() / 1e6;
            (
                rounded(parts.clone().fold(f64::INFINITY, f64::min)),
                rounded(parts.fold(f64::NEG_INFINITY, f64::max)),
            )
        };
        (of(|twist| twist.linear.x), of(|twist| twist.angular.z))
    };
    assert_eq!(bounds(0.1, 0.25, 0.5), ((0.15, 0.4), (0.1, 0.7)));
    assert_eq!(bounds(0.35, 0.0, -0.5), ((0.15, 0.4), (-0.7, -0.1)));
}

#[test]
fn the_window_holds_what_the_base_can_reach_within_the_period() {
    let dynamics = BaseDynamics {
        acceleration: 1.0,
        deceleration: 1.0,
        turn_acceleration: 2.0,
        turn_deceleration: 2.0,
        lag: 0.0,
    };
    let samples = samples(dynamics);
    let now = Travel {
        velocity: Twist::planar(0.2, 0.9),
        ..Travel::default()
    };
    let twists: Vec<Twist> = samples.twists(&now).collect();
    let ahead = twists.iter().filter(|twist| twist.linear.x > 0.0);
    assert!(ahead.clone().count() >= 12);
    for twist in ahead {
        assert!((0.1 - 1e-9..=0.3 + 1e-9).contains(&twist.linear.x), "{twist:?}");
        assert!((0.7 - 1e-9..=1.0 + 1e-9).contains(&twist.angular.z), "{twist:?}");
    }
    let spot = twists.iter().filter(|twist| twist.linear.x == 0.0);
    assert!(spot.clone().count() == 4 && spot.clone().all(|twist| twist.angular.z.abs() >= 0.3));
}
