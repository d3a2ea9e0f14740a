//! Following walls as a closed loop: the distance, corners, doors, and input that must not move the robot.

use core::f64::consts::PI;

use jde_schema::bench::Bench;

use super::*;
use crate::bench::{Loop, RADIUS, room, scan};

fn command(bench: &mut Bench<Wall>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

#[test]
fn it_settles_at_its_distance_on_either_side() {
    for (side, left) in [("left", 1.0), ("right", -1.0)] {
        for start in [0.45, 0.65, 0.9] {
            let walls = vec![[(-5.0, left * 1.0), (60.0, left * 1.0)]];
            let y = left * (1.0 - start);
            let mut world = Loop::<Wall>::new(walls, Pose2D::new(0.0, y, left * 0.2));
            world
                .bench
                .set("side", if left > 0.0 { Side::Left } else { Side::Right });
            world.drive_while(40, |_| true);
            let kept = 1.0 - left * world.travel.pose.y - RADIUS;
            assert!((kept - 0.4).abs() < 0.03, "{kept} m on the {side} from {start}");
            assert!(world.travel.pose.x > 8.0, "{:?}", world.travel.pose);
        }
    }
}

#[test]
fn in_a_room_it_goes_round_and_touches_nothing() {
    let mut world = Loop::<Wall>::new(room((-3.0, -2.0), (3.0, 2.0)), Pose2D::new(0.0, -1.4, 0.0));
    for corner in [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let away =
            |world: &Loop<Wall>| corner.0 * world.travel.pose.x < 2.0 || corner.1 * world.travel.pose.y < 1.0;
        world.drive_while(60, away);
        assert!(
            !away(&world),
            "{:?} is far from corner {corner:?}",
            world.travel.pose
        );
    }
    assert!(world.distance > 12.0, "{} m", world.distance);
    assert!(world.clearance > 0.2, "{} m from a wall", world.clearance);
}

#[test]
fn it_goes_around_the_end_of_a_wall() {
    let mut world = Loop::<Wall>::new(vec![[(-3.0, -0.65), (1.0, -0.65)]], Pose2D::ORIGIN);
    world.drive_while(40, |world| world.travel.pose.y > -1.2);
    assert!(world.travel.pose.y < -1.1, "{:?}", world.travel.pose);
    assert!(world.clearance > 0.2, "{} m from a wall", world.clearance);
}

#[test]
fn it_enters_a_door_on_its_side() {
    let walls = vec![
        [(-3.0, -0.65), (2.0, -0.65)],
        [(3.5, -0.65), (8.0, -0.65)],
        [(-3.0, 1.0), (8.0, 1.0)],
        [(-1.0, -4.0), (8.0, -4.0)],
    ];
    let mut world = Loop::<Wall>::new(walls, Pose2D::ORIGIN);
    world.drive_while(60, |world| world.travel.pose.y > -1.2);
    assert!(world.travel.pose.y < -1.1, "{:?}", world.travel.pose);
    assert!(world.clearance > 0.1, "{} m from a wall", world.clearance);
}

#[test]
fn without_any_wall_it_goes_straight() {
    let mut world = Loop::<Wall>::new(Vec::new(), Pose2D::ORIGIN);
    assert_eq!(command(&mut world.bench), Twist::planar(0.3, 0.0));
    assert_eq!(
        world.bench.draw().expect("the panel is drawn").texts(),
        ["searches a wall"]
    );
}

#[test]
fn a_wall_that_vanishes_is_searched_for_one_turn() {
    let mut world = Loop::<Wall>::new(vec![[(-5.0, -0.65), (9.0, -0.65)]], Pose2D::ORIGIN);
    world.drive_while(5, |_| true);
    world.walls.clear();
    world.drive_while(60, |_| true);
    assert_eq!(command(&mut world.bench), Twist::planar(0.3, 0.0));
}

#[test]
fn it_never_touches_a_wall_whatever_its_heading() {
    for step in 0..6 {
        let mut walls = room((-3.0, -2.0), (3.0, 2.0));
        walls.extend([
            [(1.0, -0.6), (1.0, 0.6)],
            [(-1.0, 0.5), (-1.8, 1.2)],
            [(-0.5, -2.0), (-0.5, -1.2)],
        ]);
        let mut world = Loop::<Wall>::new(walls, Pose2D::new(0.0, 0.0, f64::from(step) * PI / 3.0));
        world.drive_while(60, |_| true);
        assert!(
            world.clearance > 0.03,
            "{} m from a wall in case {step}",
            world.clearance
        );
        assert!(world.distance > 5.0, "{} m in case {step}", world.distance);
    }
}

#[test]
fn without_a_usable_scan_or_pose_it_is_not_ready_and_stands_still() {
    let mut blind = scan(&[], &Pose2D::ORIGIN);
    blind.ranges.as_mut_slice().fill(f32::NAN);
    for spoil in [
        &(|bench: &mut Bench<Wall>| bench.retract("laser")) as &dyn Fn(&mut Bench<Wall>),
        &|bench| bench.retract("pose"),
        &|bench| bench.import("laser", &blind),
    ] {
        let mut world = Loop::<Wall>::new(Vec::new(), Pose2D::ORIGIN);
        spoil(&mut world.bench);
        assert!(!world.bench.check().expect("the check succeeds").ready);
        assert_eq!(command(&mut world.bench), Twist::ZERO);
    }
}
