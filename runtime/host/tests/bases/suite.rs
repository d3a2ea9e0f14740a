//! The tests. Their tolerances are for a robot whose wheels slip, and whose measurements are whole
//! millimetres and degrees.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_records::event::Outcome;
use jde_schema::prelude::{
    BatteryState, Bumpers, LaserScan, Odometry, PanTilt, Pose2D, RangeRing, WheelEncoders, normalize_angle,
};

use crate::fixture::{DriverConfig, Fixture, START};

/// The room's far corner.
const ROOM: [f64; 2] = [5.0, 4.0];

#[track_caller]
fn near(what: &str, actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{what}: {actual} is not {expected} ± {tolerance}"
    );
}

/// The driver connects by itself, the robot drives, and the application ends in order.
pub(crate) fn the_driver_connects_drives_and_stops_the_robot_at_the_end(config: DriverConfig) {
    let fixture = Fixture::start(config);
    let pose = fixture.pose();
    near("x at the start", pose.x, START.x, 0.02);
    near("y at the start", pose.y, START.y, 0.02);
    near("heading at the start", pose.theta, START.theta, 0.02);
    fixture.drive(0.2, 0.0);
    fixture.wait_until(|fixture| fixture.pose().x > START.x + 0.2);
    let (outcome, _resources) = fixture.stop();
    assert_eq!(outcome, Outcome::Stopped);
}

/// A robot without commands stays where it is.
pub(crate) fn a_robot_without_commands_does_not_move(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.modulate("silent", 1.0);
    let start_time = fixture.handle().now();
    fixture.wait_until(|fixture| fixture.handle().now() > start_time + 3_000_000_000);
    let pose = fixture.pose();
    near("x", pose.x, START.x, 0.005);
    near("y", pose.y, START.y, 0.005);
    near("heading", pose.theta, START.theta, 0.005);
}

/// Ahead is along x, in metres and metres a second.
pub(crate) fn the_robot_drives_ahead_in_metres_and_reports_its_speed(config: DriverConfig) {
    let fixture = Fixture::start(config);
    let wall = ahead(&fixture.laser().expect("a scan"));
    near("the wall at the start", wall, ROOM[0] - START.x - 0.018, 0.05);
    fixture.drive(0.2, 0.0);
    fixture.wait_until(|fixture| {
        let twist = fixture.odometry().expect("the odometry has arrived").twist.twist;
        (twist.linear.x - 0.2).abs() < 0.02 && twist.linear.y == 0.0
    });
    fixture.wait_until(|fixture| fixture.pose().x > START.x + 0.6);
    fixture.halt();
    let pose = fixture.pose();
    near("y", pose.y, START.y, 0.05);
    near("heading", pose.theta, 0.0, 0.05);
    // The wheels and the laser measure the same distance.
    let driven = wall - settled(&fixture, |fixture| ahead(&fixture.laser().expect("a scan")));
    near("the distance by the wall", driven, pose.x - START.x, 0.05);
}

/// A positive turn is counter-clockwise, and does not displace the robot.
pub(crate) fn a_positive_turn_is_to_the_left_and_on_the_spot(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.drive(0.0, 0.5);
    fixture.wait_until(|fixture| {
        fixture
            .odometry()
            .expect("the odometry has arrived")
            .twist
            .twist
            .angular
            .z
            > 0.4
    });
    fixture.wait_until(|fixture| fixture.pose().theta > 0.8);
    fixture.turn_to(FRAC_PI_2);
    let pose = fixture.pose();
    near("x", pose.x, START.x, 0.03);
    near("y", pose.y, START.y, 0.03);
    let wall = settled(&fixture, |fixture| ahead(&fixture.laser().expect("a scan")));
    near("the wall on the left", wall, ROOM[1] - START.y - 0.018, 0.08);
}

/// Four sides and four turns: at each corner, the scan agrees with the pose of the odometry.
pub(crate) fn a_square_ends_at_its_start_and_the_scans_agree_with_the_odometry(config: DriverConfig) {
    let fixture = Fixture::start(config);
    for side in 1..=4 {
        fixture.drive_distance(0.6);
        fixture.turn_to(normalize_angle(f64::from(side) * FRAC_PI_2));
        let pose = fixture.pose();
        let (wall, right) = settled(&fixture, |fixture| {
            let scan = fixture.laser().expect("a scan");
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
    let pose = fixture.pose();
    near("x at the end", pose.x, START.x, 0.15);
    near("y at the end", pose.y, START.y, 0.15);
}

/// Each sonar's pose and range agree with a wall.
pub(crate) fn sonars_measure_the_distances_of_the_walls(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.wait_until(|fixture| {
        fixture
            .read::<RangeRing>("pioneer.sonars")
            .is_some_and(|ring| ring.ranges.iter().all(|range| !range.is_nan()))
    });
    let ring: Box<RangeRing> = Box::new(fixture.read("pioneer.sonars").expect("the sonars have measured"));
    assert_eq!((ring.poses.len(), ring.ranges.len()), (16, 16));
    let pose = fixture.pose();
    for echo in ring.echoes() {
        let mount = ring.poses[echo.sonar];
        let center = to_wall_from(&pose, &mount);
        // The cone returns the nearest wall in it, never a farther one.
        assert!(
            echo.range < center + 0.1 && echo.range > 0.5 * center - 0.1,
            "sonar {} measured {} m, and the wall is {center} m away",
            echo.sonar,
            echo.range
        );
    }
    assert!(ring.echoes().count() > 10);
}

/// Odometry arrives several times a second, and each stamp is not before the one before it.
pub(crate) fn odometry_arrives_at_a_steady_rate_with_increasing_stamps(config: DriverConfig) {
    let fixture = Fixture::start(config);
    let stamp = |odometry: &Odometry| {
        f64::from(odometry.header.stamp.sec) + f64::from(odometry.header.stamp.nanosec) * 1e-9
    };
    let mut stamps = vec![stamp(&fixture.odometry().expect("the odometry has arrived"))];
    while stamps.len() < 30 {
        fixture.wait_until(|fixture| {
            fixture
                .odometry()
                .is_some_and(|odometry| Some(&stamp(&odometry)) != stamps.last())
        });
        stamps.push(stamp(&fixture.odometry().expect("the odometry has arrived")));
    }
    assert!(stamps.is_sorted(), "{stamps:?}");
    let rate = (stamps.len() - 1) as f64 / (stamps[stamps.len() - 1] - stamps[0]);
    assert!((5.0..=50.0).contains(&rate), "{rate} a second");
}

/// The robot brakes when an operator holds the pilot asleep, and drives again after the release.
pub(crate) fn r7_a_schema_without_authority_moves_nothing(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.drive(0.2, 0.0);
    fixture.wait_until(|fixture| fixture.pose().x > START.x + 0.1);
    fixture
        .handle()
        .operator("suite")
        .hold_asleep(fixture.pilot())
        .expect("the operator may");
    fixture.wait_until(Fixture::is_standing);
    let stopped = fixture.pose().x;
    let start_time = fixture.handle().now();
    fixture.wait_until(|fixture| fixture.handle().now() > start_time + 1_000_000_000);
    near("x while no schema commands", fixture.pose().x, stopped, 0.01);
    // The release also undoes the operator's modulations (R14).
    fixture
        .handle()
        .operator("suite")
        .release(fixture.pilot())
        .expect("the operator may");
    fixture.drive(0.2, 0.0);
    fixture.wait_until(|fixture| fixture.pose().x > stopped + 0.1);
}

/// The robot brakes when the last command of a silent pilot expires.
pub(crate) fn r7_the_robot_brakes_when_the_commands_stop(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.drive(0.2, 0.0);
    fixture.wait_until(|fixture| fixture.pose().x > START.x + 0.1);
    fixture.modulate("silent", 1.0);
    fixture.wait_until(Fixture::is_standing);
    assert!(fixture.pose().x < START.x + 1.0, "{:?}", fixture.pose());
}

/// The battery has about 12 V, and the encoders count the distance of the odometry.
pub(crate) fn the_driver_exports_battery_and_wheels(config: DriverConfig) {
    let fixture = Fixture::start(config);
    fixture.wait_until(|fixture| fixture.read::<WheelEncoders>("pioneer.encoders").is_some());
    let battery: BatteryState = fixture.read("pioneer.battery").expect("the odometry has arrived");
    assert!((10.0..15.0).contains(&battery.voltage), "{battery:?}");
    assert!(battery.present.get());
    let distance = |fixture: &Fixture| {
        let wheels: WheelEncoders = fixture
            .read("pioneer.encoders")
            .expect("the encoders have arrived");
        assert!(wheels.ticks_per_meter > 0.0);
        (wheels.left + wheels.right) as f64 / 2.0 / wheels.ticks_per_meter
    };
    let (before, start) = (distance(&fixture), fixture.pose());
    fixture.drive_distance(0.5);
    let driven = fixture.pose().distance_to(&start);
    let rolled = settled(&fixture, |fixture| distance(fixture) - before);
    near("the distance of the wheels", rolled, driven, 0.03);
}

/// Positive pan is to the left, positive tilt down. Without a speed the head holds its angles.
pub(crate) fn a_head_turns_to_the_commanded_angles(config: DriverConfig) {
    let fixture = Fixture::start(config);
    let head = |fixture: &Fixture| fixture.read::<PanTilt>("pioneer.pan_tilt");
    fixture.modulate("pan", 0.6);
    fixture.modulate("tilt", -0.3);
    fixture.modulate("speed", 0.8);
    fixture.wait_until(|fixture| head(fixture).is_some_and(|angles| angles.pan > 0.1 && angles.pan < 0.55));
    fixture.wait_until(|fixture| {
        head(fixture)
            .is_some_and(|angles| (angles.pan - 0.6).abs() < 0.02 && (angles.tilt + 0.3).abs() < 0.02)
    });
    fixture.modulate("speed", 0.0);
    fixture.modulate("pan", -0.6);
    let start_time = fixture.handle().now();
    fixture.wait_until(|fixture| fixture.handle().now() > start_time + 500_000_000);
    near(
        "pan",
        head(&fixture).expect("the angles have arrived").pan,
        0.6,
        0.03,
    );
}

/// A wall ahead is detected by a front bumper, or by a stall of the wheels.
pub(crate) fn a_collision_with_a_wall_is_detected(config: DriverConfig) {
    let fixture = Fixture::start(config);
    let collided = |fixture: &Fixture| {
        fixture
            .read::<Bumpers>("pioneer.bumpers")
            .is_some_and(|bumpers| bumpers.front.iter().any(|on| on.get()) || bumpers.stalled.get())
    };
    assert!(!collided(&fixture));
    fixture.drive(0.4, 0.0);
    fixture.wait_until(collided);
    near("x at the wall", fixture.pose().x, ROOM[0] - 0.25, 0.1);
    fixture.drive(-0.2, 0.0);
    fixture.wait_until(|fixture| !collided(fixture));
    fixture.halt();
}

/// Returns a measurement of the robot at rest, 0.4 s later: the newest value may be older than the stop.
fn settled<T>(fixture: &Fixture, measure: impl Fn(&Fixture) -> T) -> T {
    fixture.wait_until(Fixture::is_standing);
    let start_time = fixture.handle().now();
    fixture.wait_until(|fixture| fixture.handle().now() > start_time + 400_000_000);
    measure(fixture)
}

fn ahead(scan: &LaserScan) -> f64 {
    at(scan, 0.0)
}

/// Returns the range of the beam nearest to an angle in radians.
fn at(scan: &LaserScan, angle: f64) -> f64 {
    let difference = |beam: &usize| (scan.angle(*beam) - angle).abs();
    let beam = (0..scan.ranges.len()).min_by(|a, b| difference(a).total_cmp(&difference(b)));
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
