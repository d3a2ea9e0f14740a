//! The geometry of a path, the arc and the speed in closed loops, and the stop before an obstacle.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_schema::bench::Bench;
use jde_schema::types::normalize_angle;

use super::*;
use crate::bench::{Loop, scan};

fn route(places: &[(f64, f64)]) -> Route {
    Route {
        poses: places.iter().map(|&(x, y)| Pose2D::new(x, y, 0.0)).collect(),
    }
}

/// A robot at the origin along x, among walls, with a path.
fn world(walls: Vec<[(f64, f64); 2]>, places: &[(f64, f64)]) -> Loop<Path> {
    let mut world = Loop::new(walls, Pose2D::ORIGIN);
    world.bench.unbind("path");
    world.bench.set("route", route(places));
    world
}

fn command(bench: &mut Bench<Path>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

fn note(bench: &Bench<Path>) -> String {
    let mission: Mission = bench.exported("mission").expect("it is published");
    mission.note.as_str().to_owned()
}

#[test]
fn the_arc_ends_in_the_point() {
    for (x, y) in [(1.0, 0.3), (0.5, -0.5), (2.0, 0.0), (0.0, 1.0)] {
        let curve = curvature(&Pose2D::new(x, y, 0.0));
        // The arc begins along x, so its middle is at (0, 1 / curve).
        if curve != 0.0 {
            assert!((x.hypot(y - 1.0 / curve) - 1.0 / curve.abs()).abs() < 1e-9);
        }
    }
    assert_eq!(curvature(&Pose2D::ORIGIN), 0.0);
}

#[test]
fn it_follows_a_path_with_a_corner_to_its_end() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (3.0, 0.0), (3.0, 3.0)]);
    world.drive_while(60, |world| {
        world.bench.commanded::<Twist>("base") != Some(Twist::ZERO)
    });
    let end = Pose2D::new(3.0, 3.0, 0.0);
    assert!(
        world.travel.pose.distance_to(&end) < 0.2,
        "it ends at {:?}",
        world.travel.pose
    );
    let mission: Mission = world.bench.exported("mission").expect("it is published");
    assert_eq!(mission.state, Mission::DONE);
}

#[test]
fn it_turns_to_the_last_heading_if_that_counts() {
    let mut world = world(Vec::new(), &[]);
    world.bench.set("yaw_goal_tolerance", 0.05);
    world.bench.set(
        "route",
        Route {
            poses: [Pose2D::new(1.0, 0.0, PI)].into_iter().collect(),
        },
    );
    world.drive_while(60, |_| true);
    let heading = normalize_angle(world.travel.pose.theta - PI);
    assert!(heading.abs() < 0.06, "{heading} rad");
    assert!(world.travel.pose.distance_to(&Pose2D::new(1.0, 0.0, 0.0)) < 0.2);
}

#[test]
fn a_path_behind_it_is_faced_on_the_spot() {
    let twist = command(&mut world(Vec::new(), &[(0.0, 0.0), (-3.0, 0.1)]).bench);
    assert!(twist.linear.x == 0.0 && twist.angular.z > 0.0, "{twist:?}");
}

#[test]
fn it_slows_in_bends_and_beside_obstacles() {
    let straight = command(&mut world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]).bench);
    assert_eq!(straight, Twist::planar(0.4, 0.0));
    let bend = command(&mut world(Vec::new(), &[(0.0, 0.0), (0.2, 0.0), (0.2, 3.0)]).bench);
    assert!(bend.linear.x < 0.3 && bend.angular.z > 0.0, "{bend:?}");
    let beside = vec![[(-1.0, 0.45), (5.0, 0.45)]];
    let close = command(&mut world(beside, &[(0.0, 0.0), (5.0, 0.0)]).bench);
    assert!((close.linear.x - 0.2).abs() < 0.01, "{close:?}");
}

#[test]
fn before_an_obstacle_it_stops_states_why_and_goes_on_when_it_is_gone() {
    let mut world = world(vec![[(2.0, -0.5), (2.0, 0.5)]], &[(0.0, 0.0), (4.0, 0.0)]);
    world.drive_while(60, |_| true);
    assert_eq!(world.bench.commanded("base"), Some(Twist::ZERO));
    assert!(
        world.travel.pose.x > 1.2 && world.clearance > 0.04,
        "{:?}",
        world.travel.pose
    );
    assert!(
        note(&world.bench).starts_with("something is in the way"),
        "{}",
        note(&world.bench)
    );
    world.walls.clear();
    world.drive_while(60, |_| true);
    assert_eq!(note(&world.bench), "at the end of the path");
}

#[test]
fn it_never_touches_a_wall_that_its_path_crosses() {
    for step in 0..6 {
        let (sin, cos) = (f64::from(step) * PI / 3.0).sin_cos();
        let walls = crate::bench::room((-1.5, -1.0), (1.5, 1.0));
        let mut world = world(walls, &[(0.0, 0.0), (0.6, 0.3), (3.0 * cos, 3.0 * sin)]);
        world.drive_while(40, |_| true);
        assert!(
            world.clearance > 0.01,
            "{} m from a wall in case {step}",
            world.clearance
        );
    }
}

#[test]
fn a_published_path_replaces_the_route() {
    let mut world = world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]);
    world.bench.import(
        "path",
        &route(&[(0.0, 0.0), (0.0, 5.0)]).to_path(Header::default()),
    );
    let twist = command(&mut world.bench);
    assert!(twist.linear.x == 0.0 && twist.angular.z > 0.0, "{twist:?}");
}

#[test]
fn without_a_path_or_a_usable_scan_or_pose_it_is_not_ready_and_stands_still() {
    let mut blind = scan(&[], &Pose2D::ORIGIN);
    blind.ranges.as_mut_slice().fill(f32::NAN);
    for spoil in [
        &(|bench: &mut Bench<Path>| bench.retract("laser")) as &dyn Fn(&mut Bench<Path>),
        &|bench| bench.retract("pose"),
        &|bench| bench.set("route", Route::EMPTY),
        &|bench| bench.import("laser", &blind),
        &|bench| {
            let nowhere = Pose2D::new(f64::INFINITY, 0.0, FRAC_PI_2);
            bench.import("pose", &Odometry::planar(Time::default(), nowhere, Twist::ZERO));
        },
    ] {
        let mut world = world(Vec::new(), &[(0.0, 0.0), (5.0, 0.0)]);
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
