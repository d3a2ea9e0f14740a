//! The guard of an arm: limits of joints and forbidden zones.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{JointState, Name, Point2D, Zone, Zones};

use super::{Arm, ArmState};

fn joints(angles: [f64; 2], speeds: [f64; 2]) -> JointState {
    let mut joints = JointState::default();
    joints
        .name
        .extend_from_slice(&["shoulder", "elbow"].map(Name::from))
        .unwrap();
    joints.position.extend_from_slice(&angles).unwrap();
    joints.velocity.extend_from_slice(&speeds).unwrap();
    joints
}

fn command(speeds: [f64; 2]) -> JointState {
    let mut command = joints([0.0; 2], speeds);
    command.position.clear();
    command
}

/// A zone to the left of the arm, 0.2 m from the shoulder.
fn wall() -> Zones {
    let corners = [[-1.0, 0.2], [1.0, 0.2], [1.0, 0.3], [-1.0, 0.3]].map(|[x, y]| Point2D { x, y });
    let mut zones = Zones::EMPTY;
    let corners = corners.into_iter().collect();
    zones.zones.push(Zone { corners }).unwrap();
    zones
}

/// The state of an arm that stands at these angles.
fn state(angles: [f64; 2]) -> ArmState {
    let mut bench = Bench::<Arm>::new();
    bench.import("joints", &joints(angles, [0.0; 2]));
    bench.set("zones", wall());
    bench.awake().unwrap();
    bench.iterate().unwrap();
    bench.exported("state").unwrap()
}

fn judge(angles: [f64; 2], speeds: [f64; 2]) -> Result<(), String> {
    Arm::judge(&state(angles), Duration::ZERO, &command(speeds))
}

#[test]
fn a_joint_stops_before_its_limit() {
    // It turns by 0.1 rad in the reaction time, and by 0.125 rad while it brakes.
    assert_eq!(judge([0.0, -2.2], [0.0, 1.0]), Ok(()));
    assert_eq!(judge([0.0, -2.4 + 0.23], [0.0, -1.0]), Ok(()));
    let refused = judge([0.0, -2.4 + 0.199], [0.0, -1.0]);
    assert_eq!(
        refused,
        Err("the elbow would stop at -2.43 rad, beyond -2.40 rad".into())
    );
    // One that is beyond its limit may return, and not go on.
    assert_eq!(judge([0.0, -2.5], [0.0, 0.5]), Ok(()));
    assert!(judge([0.0, -2.5], [0.0, -0.1]).is_err());
}

#[test]
fn the_arm_stops_before_a_zone_and_may_leave_it() {
    // Stretched along x, the hand is 0.2 m from the zone.
    assert_eq!(judge([0.0, 0.0], [0.3, 0.0]), Ok(()));
    let refused = judge([0.0, 0.0], [2.0, 0.0]).unwrap_err();
    assert!(refused.contains("of a forbidden zone"), "{refused}");
    // The elbow alone would carry the hand there.
    assert!(judge([0.0, 0.0], [0.0, 2.0]).is_err());
    // Within the margin: away, and not nearer.
    let within = [0.25, 0.0];
    assert_eq!(judge(within, [-0.5, 0.0]), Ok(()));
    assert!(judge(within, [0.1, 0.0]).is_err());
}

#[test]
fn a_command_is_limited_to_a_part_with_which_the_arm_can_stop() {
    let state = state([0.0, 0.0]);
    let limited = Arm::limit(&state, Duration::ZERO, &command([2.0, 0.0])).unwrap();
    assert!(
        limited.velocity[0] > 0.0 && limited.velocity[0] < 2.0,
        "{limited:?}"
    );
    assert_eq!(Arm::judge(&state, Duration::ZERO, &limited), Ok(()));
}

#[test]
fn an_old_state_counts_as_far_as_the_arm_has_moved_since() {
    let mut moving = state([0.0, -2.4 + 0.4]);
    moving.speeds = [0.0, -1.0];
    let wanted = command([0.0, -1.0]);
    assert_eq!(Arm::judge(&moving, Duration::ZERO, &wanted), Ok(()));
    assert!(Arm::judge(&moving, Duration::from_millis(200), &wanted).is_err());
}

#[test]
fn a_stop_is_accepted_and_what_is_no_speed_of_both_joints_is_refused() {
    let state = state([0.0, -2.5]);
    assert_eq!(Arm::judge(&state, Duration::ZERO, &JointState::default()), Ok(()));
    let mut half = JointState::default();
    half.name.push("shoulder".into()).unwrap();
    half.velocity.push(1.0).unwrap();
    assert!(Arm::judge(&state, Duration::ZERO, &half).is_err());
}

#[test]
fn without_a_joint_there_is_no_state() {
    let mut bench = Bench::<Arm>::new();
    let mut half = JointState::default();
    half.name.push("shoulder".into()).unwrap();
    half.position.push(0.0).unwrap();
    half.velocity.push(0.0).unwrap();
    bench.import("joints", &half);
    bench.awake().unwrap();
    bench.iterate().unwrap();
    assert_eq!(bench.exported::<ArmState>("state"), None);
    bench.import("joints", &joints([f64::NAN, 0.0], [0.0; 2]));
    bench.iterate().unwrap();
    assert_eq!(bench.exported::<ArmState>("state"), None);
}
