//! Wandering as a closed loop among walls, and input that must not move the robot.

use jde_schema::bench::Bench;

use super::*;
use crate::bench::{Loop, room, scan};

fn command(bench: &mut Bench<Wander>) -> Twist {
    bench.iterate().expect("the iteration succeeds");
    bench.commanded("base").expect("a command")
}

/// In the open, with nothing that needs the place.
fn without_mission() -> Loop<Wander> {
    let mut world = Loop::<Wander>::new(Vec::new(), Pose2D::ORIGIN);
    world.bench.unbind("state");
    world.bench.unbind("mission");
    world
}

#[test]
fn in_the_open_it_goes_straight_at_full_speed() {
    let mut world = without_mission();
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
    let mut world = without_mission();
    let place = Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO);
    world.bench.import("known", &place);
    assert!(!world.bench.check().expect("the check succeeds").ready);
    world.bench.retract("known");
    assert!(world.bench.check().expect("the check succeeds").ready);
}

#[test]
fn it_waits_for_the_place_and_looks_for_none_that_nobody_needs() {
    let mut world = Loop::<Wander>::new(Vec::new(), Pose2D::ORIGIN);
    world.bench.set("patience", 2.0);
    let mut at = |seconds: u64, mission: u8, has_state: bool| {
        world.now = Duration::from_secs(seconds);
        world.sense();
        let bench = &mut world.bench;
        bench.import(
            "mission",
            &Mission {
                state: mission,
                ..Mission::default()
            },
        );
        if has_state {
            bench.import("state", &Text::<160>::truncated("not sure"));
        } else {
            bench.retract("state");
        }
        bench.check().expect("the check succeeds").ready
    };
    assert!(!at(10, Mission::RUNNING, true));
    assert!(!at(11, Mission::RUNNING, true));
    assert!(at(12, Mission::RUNNING, true));
    assert!(!at(13, Mission::DONE, true));
    assert!(!at(14, Mission::RUNNING, false), "its localizer has faulted");
    assert!(at(15, Mission::RUNNING, true));
}

#[test]
fn r18_an_odometry_of_before_lets_no_wall_seem_farther() {
    let walls = vec![[(0.75, -2.0), (0.75, 2.0)]];
    let (moves, now) = (Twist::planar(0.4, 0.0), Duration::from_millis(1400));
    let command_at = |measured: Duration| {
        let mut bench = without_mission().bench;
        let x = |time: Duration| 0.4 * (time.as_secs_f64() - 1.0);
        bench.set_now(measured);
        let pose = Pose2D::new(x(measured), 0.0, 0.0);
        bench.import("pose", &Odometry::planar(measured, pose, moves));
        bench.set_now(now);
        bench.import("laser", &scan(&walls, &Pose2D::new(x(now), 0.0, 0.0)));
        command(&mut bench)
    };
    let fresh = command_at(now);
    let before = command_at(Duration::from_secs(1));
    assert!(fresh.linear.x < 0.4, "{fresh:?}");
    assert!(
        (before.linear.x - fresh.linear.x).abs() < 1e-9,
        "{before:?}, {fresh:?}"
    );
}

#[test]
fn an_odometry_of_more_than_half_a_second_ago_says_nothing_of_the_present() {
    let mut world = without_mission();
    world.bench.set_now(Duration::from_millis(600));
    world.bench.import("laser", &scan(&[], &Pose2D::ORIGIN));
    assert_eq!(command(&mut world.bench), Twist::ZERO);
    let (_, words) = world.bench.log().last().expect("a warning");
    assert_eq!(words, "stands: the odometry is 0.6 s old");
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
