//! The tests. Their tolerances are for a robot whose wheels slip, and whose measurements are whole
//! millimetres and degrees.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_records::event::Outcome;
use jde_schema::prelude::{
    BatteryState, Bumpers, LaserScan, Odometry, PanTilt, Pose2D, RangeRing, WheelEncoders, normalize_angle,
};

use crate::rig::{Rig, RigConfig, START};

/// The room's far corner.
const ROOM: [f64; 2] = [5.0, 4.0];

#[track_caller]
fn near(what: &str, is: f64, wanted: f64, tolerance: f64) {
    assert!(
        (is - wanted).abs() <= tolerance,
        "{what}: {is} is not {wanted} ± {tolerance}"
    );
}

/// The driver connects by itself, the robot drives, and the application ends in order.
pub fn it_comes_up_drives_and_is_left_standing(setting: RigConfig) {
    let rig = Rig::start(setting);
    let pose = rig.pose();
    near("x at the start", pose.x, START.x, 0.02);
    near("y at the start", pose.y, START.y, 0.02);
    near("heading at the start", pose.theta, START.theta, 0.02);
    rig.drive(0.2, 0.0);
    rig.wait_until(|rig| rig.pose().x > START.x + 0.2);
    let (outcome, _kept) = rig.stop();
    assert_eq!(outcome, Outcome::Stopped);
}

/// A robot without commands stays where it is.
pub fn nothing_commanded_is_nothing_driven(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.modulate("silent", 1.0);
    let begun = rig.handle().now();
    rig.wait_until(|rig| rig.handle().now() > begun + 3_000_000_000);
    let pose = rig.pose();
    near("x", pose.x, START.x, 0.005);
    near("y", pose.y, START.y, 0.005);
    near("heading", pose.theta, START.theta, 0.005);
}

/// Ahead is along x, in metres and metres a second.
pub fn it_drives_ahead_in_metres_and_tells_its_speed(setting: RigConfig) {
    let rig = Rig::start(setting);
    let wall = ahead(&rig.laser().expect("a scan"));
    near("the wall at the start", wall, ROOM[0] - START.x - 0.018, 0.05);
    rig.drive(0.2, 0.0);
    rig.wait_until(|rig| {
        let twist = rig.odometry().expect("the robot is heard").twist.twist;
        (twist.linear.x - 0.2).abs() < 0.02 && twist.linear.y == 0.0
    });
    rig.wait_until(|rig| rig.pose().x > START.x + 0.6);
    rig.halt();
    let pose = rig.pose();
    near("y", pose.y, START.y, 0.05);
    near("heading", pose.theta, 0.0, 0.05);
    // The wheels and the laser measure the same distance.
    let seen = wall - settled(&rig, |rig| ahead(&rig.laser().expect("a scan")));
    near("the way by the wall", seen, pose.x - START.x, 0.05);
}

/// A positive turn is counter-clockwise, and does not displace the robot.
pub fn a_positive_turn_is_to_the_left_and_on_the_spot(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.drive(0.0, 0.5);
    rig.wait_until(|rig| rig.odometry().expect("the robot is heard").twist.twist.angular.z > 0.4);
    rig.wait_until(|rig| rig.pose().theta > 0.8);
    rig.turn_to(FRAC_PI_2);
    let pose = rig.pose();
    near("x", pose.x, START.x, 0.03);
    near("y", pose.y, START.y, 0.03);
    let wall = settled(&rig, |rig| ahead(&rig.laser().expect("a scan")));
    near("the wall on the left", wall, ROOM[1] - START.y - 0.018, 0.08);
}

/// Four sides and four turns: at each corner the walls are where the odometry implies.
pub fn a_square_ends_where_it_began_and_walls_stay_where_they_are(setting: RigConfig) {
    let rig = Rig::start(setting);
    for side in 1..=4 {
        rig.drive_distance(0.6);
        rig.turn_to(normalize_angle(f64::from(side) * FRAC_PI_2));
        let pose = rig.pose();
        let (wall, right) = settled(&rig, |rig| {
            let scan = rig.laser().expect("a scan");
            (ahead(&scan), at(&scan, -80.0 * PI / 180.0))
        });
        near("the wall ahead", wall, to_wall(&pose, 0.0), 0.1);
        near(
            "the wall on the right",
            right,
            to_wall(&pose, -80.0 * PI / 180.0),
            0.1,
        );
    }
    let pose = rig.pose();
    near("x at the end", pose.x, START.x, 0.15);
    near("y at the end", pose.y, START.y, 0.15);
}

/// Each sonar's pose and range agree with a wall.
pub fn sonars_hear_walls_where_they_are(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.wait_until(|rig| {
        rig.read::<RangeRing>("pioneer.sonars")
            .is_some_and(|ring| ring.ranges.iter().all(|range| !range.is_nan()))
    });
    let ring: Box<RangeRing> = Box::new(rig.read("pioneer.sonars").expect("they were heard"));
    assert_eq!((ring.poses.len(), ring.ranges.len()), (16, 16));
    let pose = rig.pose();
    for echo in ring.echoes() {
        let mount = ring.poses[echo.sonar];
        let center = to_wall_from(&pose, &mount);
        // The cone returns the nearest wall in it, never one behind that.
        assert!(
            echo.range < center + 0.1 && echo.range > 0.5 * center - 0.1,
            "sonar {} heard {} m, and the wall is {center} m away",
            echo.sonar,
            echo.range
        );
    }
    assert!(ring.echoes().count() > 10);
}

/// Odometry arrives several times a second, and each stamp is not before the one before it.
pub fn what_it_senses_comes_at_a_steady_rate_with_times_that_grow(setting: RigConfig) {
    let rig = Rig::start(setting);
    let stamp = |odometry: &Odometry| {
        f64::from(odometry.header.stamp.sec) + f64::from(odometry.header.stamp.nanosec) * 1e-9
    };
    let mut stamps = vec![stamp(&rig.odometry().expect("the robot is heard"))];
    while stamps.len() < 30 {
        rig.wait_until(|rig| {
            rig.odometry()
                .is_some_and(|odometry| Some(&stamp(&odometry)) != stamps.last())
        });
        stamps.push(stamp(&rig.odometry().expect("the robot is heard")));
    }
    assert!(stamps.is_sorted(), "{stamps:?}");
    let rate = (stamps.len() - 1) as f64 / (stamps[stamps.len() - 1] - stamps[0]);
    assert!((5.0..=50.0).contains(&rate), "{rate} a second");
}

/// The robot brakes when an operator holds the pilot asleep, and drives again after the release.
pub fn r7_who_has_no_authority_moves_nothing(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.drive(0.2, 0.0);
    rig.wait_until(|rig| rig.pose().x > START.x + 0.1);
    rig.handle()
        .operator("suite")
        .hold_asleep(rig.pilot())
        .expect("an operator may");
    rig.wait_until(Rig::is_standing);
    let stood = rig.pose().x;
    let begun = rig.handle().now();
    rig.wait_until(|rig| rig.handle().now() > begun + 1_000_000_000);
    near("x while nobody drives", rig.pose().x, stood, 0.01);
    // The release also undoes the operator's modulations (R14).
    rig.handle()
        .operator("suite")
        .release(rig.pilot())
        .expect("an operator may");
    rig.drive(0.2, 0.0);
    rig.wait_until(|rig| rig.pose().x > stood + 0.1);
}

/// The robot brakes when the last command of a silent pilot expires.
pub fn r7_who_falls_silent_is_braked_for(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.drive(0.2, 0.0);
    rig.wait_until(|rig| rig.pose().x > START.x + 0.1);
    rig.modulate("silent", 1.0);
    rig.wait_until(Rig::is_standing);
    assert!(rig.pose().x < START.x + 1.0, "{:?}", rig.pose());
}

/// The battery has about 12 V, and the encoders count the distance of the odometry.
pub fn it_tells_battery_and_wheels(setting: RigConfig) {
    let rig = Rig::start(setting);
    rig.wait_until(|rig| rig.read::<WheelEncoders>("pioneer.encoders").is_some());
    let battery: BatteryState = rig.read("pioneer.battery").expect("the robot is heard");
    assert!((10.0..15.0).contains(&battery.voltage), "{battery:?}");
    assert!(battery.present.get());
    let counted = |rig: &Rig| {
        let wheels: WheelEncoders = rig.read("pioneer.encoders").expect("it was heard");
        assert!(wheels.ticks_per_meter > 0.0);
        (wheels.left + wheels.right) as f64 / 2.0 / wheels.ticks_per_meter
    };
    let (before, start) = (counted(&rig), rig.pose());
    rig.drive_distance(0.5);
    let driven = rig.pose().distance_to(&start);
    let rolled = settled(&rig, |rig| counted(rig) - before);
    near("the way of the wheels", rolled, driven, 0.03);
}

/// Positive pan is to the left, positive tilt down. Without a speed the head holds its angles.
pub fn a_head_looks_where_it_is_told(setting: RigConfig) {
    if !setting.head {
        return;
    }
    let rig = Rig::start(setting);
    let look = |rig: &Rig| rig.read::<PanTilt>("pioneer.pan_tilt");
    rig.modulate("pan", 0.6);
    rig.modulate("tilt", -0.3);
    rig.modulate("speed", 0.8);
    rig.wait_until(|rig| look(rig).is_some_and(|look| look.pan > 0.1 && look.pan < 0.55));
    rig.wait_until(|rig| {
        look(rig).is_some_and(|look| (look.pan - 0.6).abs() < 0.02 && (look.tilt + 0.3).abs() < 0.02)
    });
    rig.modulate("speed", 0.0);
    rig.modulate("pan", -0.6);
    let begun = rig.handle().now();
    rig.wait_until(|rig| rig.handle().now() > begun + 500_000_000);
    near("pan", look(&rig).expect("it is heard").pan, 0.6, 0.03);
}

/// A wall ahead is detected by a front bumper, or by a stall of the wheels.
pub fn a_wall_that_is_hit_is_felt(setting: RigConfig) {
    let rig = Rig::start(setting);
    let felt = |rig: &Rig| {
        rig.read::<Bumpers>("pioneer.bumpers")
            .is_some_and(|bumpers| bumpers.front.iter().any(|on| on.get()) || bumpers.stalled.get())
    };
    assert!(!felt(&rig));
    rig.drive(0.4, 0.0);
    rig.wait_until(felt);
    near("where it is", rig.pose().x, ROOM[0] - 0.25, 0.1);
    rig.drive(-0.2, 0.0);
    rig.wait_until(|rig| !felt(rig));
    rig.halt();
}

/// Returns a measurement of the robot at rest, 0.4 s later: the newest value may be from before the stop.
fn settled<T>(rig: &Rig, see: impl Fn(&Rig) -> T) -> T {
    rig.wait_until(Rig::is_standing);
    let begun = rig.handle().now();
    rig.wait_until(|rig| rig.handle().now() > begun + 400_000_000);
    see(rig)
}

fn ahead(scan: &LaserScan) -> f64 {
    at(scan, 0.0)
}

/// Returns the range of the beam nearest to an angle in radians.
fn at(scan: &LaserScan, angle: f64) -> f64 {
    let off = |beam: &usize| (scan.angle(*beam) - angle).abs();
    let beam = (0..scan.ranges.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
    f64::from(scan.ranges[beam.expect("a scan has beams")])
}

/// Returns the distance from the laser of a robot at a pose to the wall, at an angle of the laser.
fn to_wall(pose: &Pose2D, angle: f64) -> f64 {
    to_wall_from(pose, &Pose2D::new(0.018, 0.0, angle))
}

/// Returns the distance from a sensor with this mount, on a robot at a pose, to the wall along its axis.
fn to_wall_from(pose: &Pose2D, mount: &Pose2D) -> f64 {
    let (sin, cos) = pose.theta.sin_cos();
    let x = pose.x + cos * mount.x - sin * mount.y;
    let y = pose.y + sin * mount.x + cos * mount.y;
    let (dy, dx) = (pose.theta + mount.theta).sin_cos();
    let along = |position: f64, direction: f64, far: f64| match direction {
        d if d > 1e-9 => (far - position) / d,
        d if d < -1e-9 => -position / d,
        _ => f64::INFINITY,
    };
    along(x, dx, ROOM[0]).min(along(y, dy, ROOM[1]))
}
