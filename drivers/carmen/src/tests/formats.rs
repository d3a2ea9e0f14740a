//! The messages of CARMEN's logs: beams, poses and mounts, as CARMEN and GMapping read them.

use core::f64::consts::{FRAC_PI_2, PI};

use super::*;
use jde_schema::types::Body;

/// The end of a line at a time, s.
fn stamps(seconds: f64) -> String {
    format!("{seconds} host {seconds}\n")
}

fn poses(laser: Pose2D, robot: Pose2D) -> String {
    let pose = |Pose2D { x, y, theta }: Pose2D| format!("{x} {y} {theta}");
    format!("{} {}", pose(laser), pose(robot))
}

fn ranges(beams: usize) -> String {
    let ranges = vec!["1.5"; beams].join(" ");
    format!("{beams} {ranges}")
}

/// A message with the poses of the laser and the robot.
fn front(name: &str, laser: Pose2D, robot: Pose2D, seconds: f64) -> String {
    format!("{name} {} {} {}", ranges(5), poses(laser, robot), stamps(seconds))
}

/// The newer message: first angle, view, increment and greatest range as stated.
fn robot_laser(config: &str, beams: usize, laser: Pose2D, robot: Pose2D, seconds: f64) -> String {
    let (ranges, poses, stamps) = (ranges(beams), poses(laser, robot), stamps(seconds));
    format!("ROBOTLASER1 0 {config} 0.01 0 {ranges} 2 0.5 0.5 {poses} 0.1 0 0.5 0.3 1e6 {stamps}")
}

fn play(log: impl AsRef<[u8]>) -> Player {
    let mut player = Player::new(log).awake();
    player.at(0.0);
    player
}

fn mount(player: &Player) -> Pose2D {
    let body: Body = player.bench.exported("body").expect("it is known");
    body.laser("laser")
}

#[track_caller]
fn near(found: Pose2D, [x, y, theta]: [f64; 3]) {
    let turn = jde_schema::types::normalize_angle(found.theta - theta);
    let is_near = found.distance_to(&Pose2D::new(x, y, 0.0)) < 1e-6 && turn.abs() < 1e-6;
    assert!(is_near, "{found:?} is not {x} {y} {theta}");
}

/// Checks the first and the last angle, degrees.
#[track_caller]
fn angles(log: impl AsRef<[u8]>, first: f64, last: f64) {
    let scan = play(log).laser();
    let found = [
        scan.angle(0),
        scan.angle(scan.ranges.len() - 1),
        f64::from(scan.angle_max),
    ]
    .map(f64::to_degrees);
    let is_near = found
        .iter()
        .zip([first, last, last])
        .all(|(a, b)| (a - b).abs() < 0.02);
    assert!(is_near, "{found:?} is not {first} to {last}");
    assert_eq!(scan.measured(), Ok(()));
}

#[test]
fn the_number_of_beams_tells_the_laser() {
    let step = 360.0 / 1024.0;
    for (beams, first, last) in [
        (1, -90.0, -90.0),
        (180, -90.0, 89.0),
        (181, -90.0, 90.0),
        (360, -90.0, 89.5),
        (361, -90.0, 90.0),
        (401, -50.0, 50.0),
        (541, -135.0, 135.0),
        (540, -135.0, 134.5),
        (682, -340.5 * step, 340.5 * step),
        (683, -341.0 * step, 341.0 * step),
        (1081, -135.0, 135.0),
        (91, -90.0, 90.0),
    ] {
        angles(flaser(&vec![1.0; beams], (0.0, 0.0, 0.0), 1.0), first, last);
    }
}

#[test]
fn parameters_that_fit_the_number_of_beams_tell_the_laser() {
    let log = |parameters: &[&str], beams: usize| {
        let lines: String = parameters
            .iter()
            .map(|line| format!("PARAM {line} 1 host 1\n"))
            .collect();
        format!("{lines}{}", flaser(&vec![1.0; beams], (0.0, 0.0, 0.0), 1.0))
    };
    let (view, resolution) = ("laser_front_laser_fov", "laser_front_laser_resolution");
    angles(log(&[&format!("{view} 4.71239")], 541), -135.0, 135.0);
    angles(log(&[&format!("{view} 4.71239")], 271), -135.0, 135.0);
    angles(
        log(&[&format!("{view} 100"), &format!("{resolution} 0.5")], 201),
        -50.0,
        50.0,
    );
    angles(log(&[&format!("{resolution} 2")], 101), -100.0, 100.0);
    // 361 beams of 1 degree are more than a circle: the parameter is of another laser.
    angles(log(&[&format!("{resolution} 1")], 361), -90.0, 90.0);
}

#[test]
fn the_newer_message_states_its_angles_and_its_greatest_range() {
    let at = Pose2D::ORIGIN;
    let log = |config: &str, beams| robot_laser(config, beams, at, at, 1.0);
    angles(log("-1.570796 3.14172 0.008727 50", 360), -90.0, 89.5);
    angles(log("-2.356194 4.712389 0.0043633 30", 1081), -135.0, 135.0);
    angles(log("-1.570796 3.141593 0 80", 181), -90.0, 90.0);
    // An increment in degrees would be many turns.
    angles(log("-90 3.141593 1.0 80", 181), -90.0, 90.0);
    let stated = log("-1.570796 3.141593 0.017453 1.45", 181).replacen(" 1.5 1.5 1.5", " 1.5 1.4 1.6", 1);
    let scan = play(stated).laser();
    assert_eq!((scan.range_max, scan.ranges[1]), (1.45, 1.4));
    assert!(scan.ranges[0].is_infinite() && scan.ranges[2].is_infinite());
}

#[test]
fn too_many_beams_are_merged_to_their_nearest() {
    let mut beams = vec![5.0; 2161];
    (beams[1000], beams[1001]) = (0.0, 2.0);
    let scan = play(flaser(&beams, (0.0, 0.0, 0.0), 1.0)).laser();
    assert_eq!((scan.ranges.len(), scan.ranges[500]), (1081, 2.0));
    assert!((scan.angle(540)).abs() < 1e-3, "{}", scan.angle(540));
    assert_eq!(scan.measured(), Ok(()));
}

#[test]
fn what_a_laser_says_where_nothing_returns_is_no_object() {
    for (none, object) in [
        (81.91, 8.19),
        (32.767, 16.3),
        (16.383, 8.0),
        (8.191, 8.0),
        (51.15, 49.0),
    ] {
        let ranges = [object, none, 1.0, f64::NAN, -1.0];
        let scan = play(flaser(&ranges, (0.0, 0.0, 0.0), 1.0)).laser();
        assert_eq!(scan.ranges[..3], [object as f32, f32::INFINITY, 1.0]);
        assert!(scan.ranges[3].is_nan() && scan.ranges[4].is_nan());
    }
    let scan = play(flaser(&[12.0, 1.0], (0.0, 0.0, 0.0), 1.0)).laser();
    assert_eq!(scan.ranges.as_slice(), [12.0, 1.0]);
}

#[test]
fn the_first_pose_is_of_the_laser_and_the_second_of_the_robot() {
    let expected = Pose2D::new(0.28, -0.1, 0.2);
    let robot = |step: f64| Pose2D::new(step, 0.5 * step, 0.7 * step);
    for name in ["FLASER", "ROBOTLASER1"] {
        let log: String = (0..4)
            .map(|step| {
                let robot = robot(f64::from(step));
                let laser = robot.transform(&expected);
                match name {
                    "FLASER" => front(name, laser, robot, f64::from(step)),
                    _ => robot_laser("-1.5 3 0.75 50", 5, laser, robot, f64::from(step)),
                }
            })
            .collect();
        let mut player = play(log);
        near(mount(&player), [0.28, -0.1, 0.2]);
        player.at(2.0);
        near(player.pose(), [2.0, 1.0, 1.4]);
        assert_eq!(player.warnings(), [""; 0]);
    }
}

#[test]
fn the_offset_in_the_parameters_counts_where_the_poses_are_the_same() {
    let at = |x| Pose2D::new(x, 0.0, 0.0);
    let parameter =
        "PARAM robot_frontlaser_offset 0.3 nohost 0\nPARAM robot_frontlaser_offset 0.5 nohost 0\n";
    let scans = [
        front("FLASER", at(0.0), at(0.0), 1.0),
        front("FLASER", at(1.0), at(1.0), 2.0),
    ]
    .concat();
    near(mount(&play(format!("{parameter}{scans}"))), [0.3, 0.0, 0.0]);
    near(mount(&play(&scans)), [0.0, 0.0, 0.0]);
    let rear = scans.replace("FLASER", "RLASER");
    near(
        mount(&play(format!("PARAM robot_rearlaser_offset -0.2\n{rear}"))),
        [-0.2, 0.0, PI],
    );
}

#[test]
fn poses_that_were_corrected_are_not_those_of_the_robot() {
    // The wheels drift to the left; the corrected poses of the laser are on a straight line.
    let wheels = |step: f64| Pose2D::new(step, 0.1 * step * step, 0.05 * step);
    let log: String = (0..9)
        .map(|step| {
            let step = f64::from(step);
            let odom = wheels(step + 0.5);
            front("FLASER", Pose2D::new(step, 0.0, 0.0), wheels(step), step)
                + &format!(
                    "ODOM {} {} {} 0 0 0 {}",
                    odom.x,
                    odom.y,
                    odom.theta,
                    stamps(step + 0.5)
                )
        })
        .collect();
    let mut player = play(format!("PARAM robot_frontlaser_offset 0.1\n{log}"));
    near(mount(&player), [0.1, 0.0, 0.0]);
    player.at(4.0);
    near(player.pose(), [4.0, 1.6, 0.2]);
    player.assert_warned("the poses of its laser were corrected afterwards");
    player.at(4.5);
    near(player.pose(), [4.5, 2.025, 0.225]);
}

#[test]
fn a_robot_that_stands_still_while_its_laser_moves_has_the_pose_of_the_laser() {
    let log: String = (0..9)
        .map(|step| {
            front(
                "FLASER",
                Pose2D::new(f64::from(step) / 2.0, 0.0, 0.0),
                Pose2D::ORIGIN,
                f64::from(step),
            )
        })
        .collect();
    let mut player = play(log);
    player.at(4.0);
    near(player.pose(), [2.0, 0.0, 0.0]);
    player.assert_warned("its robot stands still while its laser moves");
}

#[test]
fn wheels_in_another_frame_than_the_scans_are_left_out() {
    let log: String = (0..9)
        .map(|step| {
            let (at, seconds) = (Pose2D::new(f64::from(step) / 2.0, 0.0, 0.0), f64::from(step));
            let odom = format!("ODOM 5 {} 1.5 0 0 0 {}", at.x, stamps(seconds + 0.5));
            front("FLASER", at, at, seconds) + &odom
        })
        .collect();
    let mut player = play(log);
    player.assert_warned("ODOM is left out: its poses contradict those of the scans (line 2, and 8 more)");
    player.at(4.7);
    near(player.pose(), [2.0, 0.0, 0.0]);
}

#[test]
fn scans_without_poses_are_between_those_of_the_wheels() {
    let log: String = (0..5)
        .map(|step| {
            let step = f64::from(step);
            let raw = format!(
                "RAWLASER1 0 -1.5 3 0.75 50 0.01 0 {} 0 {}",
                ranges(5),
                stamps(step + 0.5)
            );
            format!("ODOM {step} 0 0 0 0 0 {}{raw}", stamps(step))
        })
        .collect();
    let mut player = play(log);
    let mission = player.at(2.5);
    assert_eq!((mission.reached, mission.total), (3, 5));
    near(player.pose(), [2.5, 0.0, 0.0]);
    assert_eq!(
        player.bench.exported_at("laser"),
        Some(Duration::from_millis(2500))
    );
}

#[test]
fn one_laser_of_a_log_is_played_and_the_others_are_named() {
    let at = Pose2D::new(1.0, 0.0, 0.0);
    let log: String = (1..5)
        .map(|step| {
            let seconds = f64::from(step);
            let raw = format!(
                "RAWLASER1 0 -1.5 3 0.75 50 0.01 0 {} 0 {}",
                ranges(5),
                stamps(seconds)
            );
            raw + &front("RLASER", at, at, seconds) + &robot_laser("-1.5 3 0.75 50", 5, at, at, seconds)
        })
        .collect();
    let mut player = play(log);
    assert_eq!(player.at(9.0).total, 4);
    assert_eq!(f64::from(player.laser().angle_min), -1.5);
    player.assert_warned("RAWLASER1 is left out: the scans of ROBOTLASER1 are played (line 1, and 3 more)");
    player.assert_warned("RLASER is left out: the scans of ROBOTLASER1 are played (line 2, and 3 more)");
}

#[test]
fn a_half_turn_is_the_default() {
    assert!((play(flaser(&[1.0; 7], (0.0, 0.0, 0.0), 1.0)).laser().angle(6) - FRAC_PI_2).abs() < 1e-6);
}
