//! Wandering as a closed loop among walls, and input that must not move the robot.

use jde_schema::bench::Bench;

use super::*;
use crate::bench::{Loop, room, scan};

fn command(bench: &mut Bench<Wander>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

#[test]
fn in_the_open_it_goes_straight_at_full_speed() {
    let mut world = Loop::<Wander>::new(Vec::new(), Pose2D::ORIGIN);
    assert!(world.bench.check().expect("the check succeeds").ready);
    assert_eq!(command(&mut world.bench), Twist::planar(0.4, 0.0));
    let panel = world.bench.draw().expect("the panel is drawn");
    assert_eq!(panel.texts(), ["goes straight", "nothing is ahead"]);
}

#[test]
fn before_an_obstacle_it_turns_to_the_freer_side() {
    for side in [1.0, -1.0] {
        let walls = vec![[(0.7, -side * 2.0), (0.7, side * 0.3)]];
        let mut world = Loop::<Wander>::new(walls, Pose2D::ORIGIN);
        let twist = command(&mut world.bench);
        assert_eq!((twist.linear.x, twist.angular.z.signum()), (0.0, side));
    }
}

#[test]
fn in_a_room_it_drives_on_and_touches_nothing() {
    let mut walls = room((-3.0, -2.0), (3.0, 2.0));
    walls.extend([[(1.0, -0.6), (1.0, 0.6)], [(-1.0, 0.5), (-1.8, 1.2)]]);
    let mut world = Loop::<Wander>::new(walls, Pose2D::ORIGIN);
    world.drive_while(120, |_| true);
    assert!(world.clearance > 0.04, "{} m from a wall", world.clearance);
    assert!(world.distance > 12.0, "{} m", world.distance);
}

#[test]
fn it_is_ready_only_while_the_place_is_not_known() {
    let mut world = Loop::<Wander>::new(Vec::new(), Pose2D::ORIGIN);
    let place = Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO);
    world.bench.import("known", &place);
    assert!(!world.bench.check().expect("the check succeeds").ready);
    world.bench.retract("known");
    assert!(world.bench.check().expect("the check succeeds").ready);
}

#[test]
fn without_a_usable_scan_or_pose_it_is_not_ready_and_stands_still() {
    let mut blind = scan(&[], &Pose2D::ORIGIN);
    blind.ranges.as_mut_slice().fill(f32::NAN);
    for spoil in [
        &(|bench: &mut Bench<Wander>| bench.retract("laser")) as &dyn Fn(&mut Bench<Wander>),
        &|bench| bench.retract("pose"),
        &|bench| bench.import("laser", &blind),
        &|bench| {
            let nowhere = Pose2D::new(0.0, 0.0, f64::NAN);
            bench.import("pose", &Odometry::planar(Time::default(), nowhere, Twist::ZERO));
        },
    ] {
        let mut world = Loop::<Wander>::new(Vec::new(), Pose2D::ORIGIN);
        spoil(&mut world.bench);
        assert!(!world.bench.check().expect("the check succeeds").ready);
        assert_eq!(command(&mut world.bench), Twist::ZERO);
    }
}

#[test]
fn the_panel_states_what_it_does() {
    let mut world = Loop::<Wander>::new(vec![[(0.7, -2.0), (0.7, 0.3)]], Pose2D::ORIGIN);
    command(&mut world.bench);
    let panel = world.bench.draw().expect("the panel is drawn");
    assert_eq!(panel.texts(), ["turns to the left"]);
}
