//! Robots of files: what they publish, how they drive, what an application changes, and mistakes of
//! configuration.

use std::collections::BTreeSet;

use jde_schema::bench::Bench;
use jde_schema::types::{Body, Footprint};

use super::*;

fn robot(model: &str, world: &str) -> Bench<crate::Robot> {
    let mut bench = Bench::new();
    bench.set("world", Text::<1024>::new(world));
    bench.set("model", Text::<1024>::new(model));
    for noise in ["laser_noise", "sonar_noise", "wheel_error"] {
        bench.set(noise, 0.0);
    }
    bench
}

pub(super) fn awake(model: &str, world: &str) -> Bench<crate::Robot> {
    let mut bench = robot(model, world);
    bench.awake().expect("it enters the world");
    bench
}

/// Renews a command for a number of periods of the driver. Returns the time at the end.
pub(super) fn drive(bench: &mut Bench<crate::Robot>, from: Duration, twist: Twist, periods: u32) -> Duration {
    let mut now = from;
    for _ in 0..periods {
        bench.command("velocity", &twist);
        now += PERIOD;
        bench.set_now(now);
        bench.iterate().expect("it drives and senses");
    }
    now
}

#[test]
fn the_default_robot_is_the_pioneer() {
    let (_folder, path) = file(ROOM);
    let drive_a_little = |model: Option<&str>| {
        let mut bench = Bench::<crate::Robot>::new();
        bench.set("world", Text::<1024>::new(&path));
        if let Some(model) = model {
            bench.set("model", Text::<1024>::new(model));
        }
        bench.awake().expect("it enters the world");
        drive(&mut bench, Duration::ZERO, Twist::planar(0.3, 0.2), 40);
        for sensor in ["laser", "sonars", "bumpers", "pan_tilt", "battery"] {
            assert!(bench.exported_at(sensor).is_some(), "{sensor}");
        }
        bench.exported::<Truth>("truth")
    };
    assert_eq!(drive_a_little(None), drive_a_little(Some("pioneer-3dx")));
}

#[test]
fn a_line_sensor_is_published_with_its_cells() {
    let paint = "\n[[floor_lines]]\npoints = [[0, 3], [8, 3]]\nwidth = 0.03\n";
    let (_folder, path) = file(&format!("{ROOM}{paint}"));
    let mut bench = awake("turtlebot3-line", &path);
    drive(&mut bench, Duration::ZERO, Twist::ZERO, 2);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    let sensor: LineSensor = bench.exported("line_sensor").expect("it has a line sensor");
    assert_eq!((sensor.cells.len(), sensor.brightness.len()), (8, 8));
    for (cell, brightness) in sensor.cells.iter().zip(&sensor.brightness) {
        let (sin, cos) = truth.pose.theta.sin_cos();
        let away = truth.pose.y + sin * cell.x + cos * cell.y - 3.0;
        assert_eq!(*brightness < 0.2, away.abs() < 0.015, "{brightness} at {away} m");
    }
}

#[test]
fn an_inertial_unit_and_a_position_sensor_are_published_and_an_outage_retracts() {
    let (_folder, path) = file(ROOM);
    let folder = TempDir::new().expect("a folder");
    let robot = |outage: &str| {
        let model = folder.path().join("robot.toml");
        let sensors = format!("\n[imu]\ngyro_bias_deg = 0\n[position]\nnoise = 0.1\noutage = {outage}\n");
        let text = include_str!("../../../../robots/jackal.toml");
        fs::write(&model, format!("{text}{sensors}")).expect("a file");
        awake(model.to_str().expect("a path in UTF-8"), &path)
    };
    let mut bench = robot("0");
    drive(&mut bench, Duration::ZERO, Twist::planar(0.2, 0.5), 40);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    let imu: Imu = bench.exported("imu").expect("it has an inertial unit");
    assert_eq!(imu.orientation_covariance[0], -1.0);
    near(imu.angular_velocity.z, truth.twist.angular.z, 0.02);
    near(imu.linear_acceleration.y, 0.2 * 0.5, 0.4);
    near(imu.linear_acceleration.z, 9.81, 0.4);
    near(
        imu.angular_velocity_covariance[4],
        0.1_f64.to_radians().powi(2),
        1e-12,
    );
    let fix: PositionFix = bench.exported("position").expect("it has a position sensor");
    assert_eq!(
        (fix.header.frame_id.as_str(), fix.covariance[0]),
        ("map", 0.1 * 0.1)
    );
    near((fix.x - truth.pose.x).hypot(fix.y - truth.pose.y), 0.0, 0.5);
    drop(bench);
    let mut bench = robot("1");
    drive(&mut bench, Duration::ZERO, Twist::ZERO, 4);
    assert!(bench.exported_at("imu").is_some());
    assert_eq!(bench.exported_at("position"), None);
}

#[test]
fn a_robot_publishes_only_the_sensors_that_it_has_at_their_own_rates() {
    let (_folder, path) = file(ROOM);
    let mut bench = awake("turtlebot3-burger", &path);
    let (mut now, mut scans) = (Duration::ZERO, BTreeSet::new());
    for _ in 0..40 {
        now = drive(&mut bench, now, Twist::ZERO, 1);
        scans.insert(bench.exported_at("laser").expect("it has a laser"));
    }
    assert_eq!(scans.len(), 10, "five a second");
    for sensor in ["sonars", "bumpers", "pan_tilt", "battery"] {
        assert_eq!(bench.exported_at(sensor), None, "{sensor}");
    }
    assert!(bench.exported_at("odometry") == Some(now) && bench.exported_at("encoders") == Some(now));
}

#[test]
fn the_body_has_the_outline_and_the_place_of_each_laser_by_its_frame() {
    let (folder, path) = file(ROOM);
    let body = |model: &str| -> Body {
        let mut bench = awake(model, &path);
        drive(&mut bench, Duration::ZERO, Twist::ZERO, 1);
        bench.exported("body").expect("it is published at the start")
    };
    let omni = body("omni");
    assert_eq!(omni.footprint.points.len(), 4);
    assert_eq!(omni.laser("laser"), Pose2D::new(0.3, 0.0, 0.0));
    assert_eq!(omni.laser("rear"), Pose2D::new(-0.3, 0.0, PI));
    assert_eq!(omni.laser("none"), Pose2D::ORIGIN);
    assert_eq!(body("turtlebot4").footprint, Footprint::circle(0.171));
    let corner = |corner: u32| {
        let (sin, cos) = (f64::from(corner) * PI / 20.0).sin_cos();
        format!("[{}, {}]", 0.3 * cos, 0.3 * sin)
    };
    let corners: Vec<_> = (0..40).map(corner).collect();
    let text = include_str!("../../../../robots/turtlebot4.toml");
    let text = text.replace("radius = 0.171", &format!("polygon = [{}]", corners.join(", ")));
    let model = folder.path().join("round.toml");
    fs::write(&model, text).expect("a file");
    let round = body(model.to_str().expect("a path in UTF-8"));
    assert_eq!(round.footprint.points.len(), 20, "every second corner");
}

#[test]
fn the_dynamics_are_those_of_the_file_with_the_numbers_of_the_application() {
    let (_folder, path) = file(ROOM);
    let dynamics = |model: &str, lag: f64| {
        let mut bench = robot(model, &path);
        bench.set("lag", lag);
        bench.awake().expect("it enters the world");
        drive(&mut bench, Duration::ZERO, Twist::ZERO, 1);
        bench
            .exported::<BaseDynamics>("dynamics")
            .expect("it has iterated")
    };
    let jackal = dynamics("jackal", -1.0);
    assert_eq!(
        (jackal.acceleration, jackal.deceleration, jackal.lag),
        (20.0, 20.0, 0.0)
    );
    near(jackal.turn_acceleration, 25.0, 1e-6);
    assert_eq!(dynamics("jackal", 0.2), BaseDynamics { lag: 0.2, ..jackal });
    let car = dynamics("racecar", -1.0);
    assert!(car.acceleration > 0.0 && car.turn_acceleration == 0.0, "{car:?}");
}

#[test]
fn the_dynamics_of_an_omnidirectional_robot_are_the_lesser_of_ahead_and_to_the_side() {
    let (folder, path) = file(ROOM);
    let model = folder.path().join("robot.toml");
    let text = include_str!("../../../../robots/omni.toml");
    let slow = text.replace("lateral_acceleration  = 1.0", "lateral_acceleration  = 0.4");
    assert_ne!(text, slow);
    fs::write(&model, slow).expect("a file");
    let exported = |acceleration: f64| {
        let mut bench = robot(model.to_str().expect("a path"), &path);
        bench.set("acceleration", acceleration);
        bench.awake().expect("it enters the world");
        drive(&mut bench, Duration::ZERO, Twist::ZERO, 1);
        let dynamics: BaseDynamics = bench.exported("dynamics").expect("it has iterated");
        (
            dynamics.acceleration,
            dynamics.deceleration,
            bench.exported::<Twist>("setpoint"),
        )
    };
    assert_eq!(exported(-1.0), (0.4, 0.4, None));
    assert_eq!(exported(2.0), (2.0, 2.0, Some(Twist::ZERO)), "the application's");
}

#[test]
fn the_setpoint_is_what_the_motors_are_led_to_within_their_accelerations() {
    let (_folder, path) = file(ROOM);
    let mut bench = awake("pioneer-3dx", &path);
    let mut now = drive(&mut bench, Duration::ZERO, Twist::planar(9.0, 0.0), 3);
    let (mut setpoint, mut speed) = (Twist::ZERO, 0.0);
    for _ in 0..6 {
        now = drive(&mut bench, now, Twist::planar(9.0, 0.0), 10);
        setpoint = bench.exported("setpoint").expect("it has iterated");
        speed = bench
            .exported::<Truth>("truth")
            .expect("it has iterated")
            .twist
            .linear
            .x;
        near(setpoint.linear.x, speed, 0.01);
    }
    assert!(speed > 0.9 && setpoint.angular.z == 0.0, "{setpoint:?}");
    drop(bench);
    let mut car = awake("racecar", &path);
    drive(&mut car, Duration::ZERO, Twist::planar(0.1, 0.0), 3);
    assert_eq!(car.exported::<Twist>("setpoint"), None);
}

#[test]
fn an_omnidirectional_robot_obeys_the_speed_to_the_side() {
    let (_folder, path) = file(ROOM);
    let mut bench = awake("omni", &path);
    let mut twist = Twist::planar(0.0, 0.0);
    twist.linear.y = 0.3;
    drive(&mut bench, Duration::ZERO, twist, 60);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    assert!(
        truth.pose.y > 3.7 && (truth.pose.x - 2.0).abs() < 1e-6,
        "{truth:?}"
    );
    assert!((truth.twist.linear.y - 0.3).abs() < 1e-3, "{truth:?}");
    let odometry: Odometry = bench.exported("odometry").expect("it has iterated");
    near(odometry.twist.twist.linear.y, 0.3, 0.02);
    near(odometry.pose2d().y, truth.pose.y, 0.02);
}

#[test]
fn a_car_does_not_turn_on_the_spot() {
    let (_folder, path) = file(ROOM);
    let mut bench = awake("racecar", &path);
    let now = drive(&mut bench, Duration::ZERO, Twist::planar(0.0, 1.0), 20);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    assert_eq!(truth.pose, Pose2D::new(2.0, 3.0, 0.0));
    drive(&mut bench, now, Twist::planar(0.5, 0.5), 40);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    assert!(truth.pose.theta > 0.5, "{truth:?}");
}

#[test]
fn numbers_of_the_application_replace_those_of_the_file() {
    let (_folder, path) = file(ROOM);
    let mut bench = robot("pioneer-3dx", &path);
    bench.set("laser_range", 3.5);
    bench.set("acceleration", 2.0);
    bench.set("laser_noise", -1.0);
    bench.awake().expect("it enters the world");
    drive(&mut bench, Duration::ZERO, Twist::planar(0.5, 0.0), 6);
    let truth: Truth = bench.exported("truth").expect("it has iterated");
    near(truth.twist.linear.x, 0.5, 1e-9);
    let scan: LaserScan = bench.exported("laser").expect("it has iterated");
    assert_eq!(scan.range_max, 3.5);
    assert!(
        scan.ranges
            .iter()
            .all(|range| *range <= 3.5 || *range == f32::INFINITY)
    );
    assert!(scan.intensities.is_empty(), "the file's laser measures none");
}

#[test]
fn a_laser_with_intensities_has_one_for_each_range() {
    let (_folder, path) = file(ROOM);
    let mut bench = robot("pioneer-3dx", &path);
    bench.set("laser_intensity", 100.0);
    bench.awake().expect("it enters the world");
    drive(&mut bench, Duration::ZERO, Twist::ZERO, 1);
    let scan: LaserScan = bench.exported("laser").expect("it has iterated");
    assert_eq!(scan.intensities.len(), scan.ranges.len());
    let bright = |(range, intensity): (&f32, &f32)| range.is_finite() == (*intensity > 0.0);
    assert!(scan.ranges.iter().zip(&scan.intensities).all(bright), "{scan:?}");
}

#[test]
fn a_full_battery_on_a_charger_is_reported_full() {
    let (_folder, path) = file(&format!(
        "chargers = [{{ place = [2, 3], current = 10 }}]\n{ROOM}"
    ));
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.5);
    let battery: BatteryState = robot.bench.exported("battery").expect("it has iterated");
    let status = battery.power_supply_status;
    assert_eq!((status, battery.percentage, battery.current), (4, 1.0, 0.0));
}

#[test]
fn a_file_beside_the_application_is_a_robot_and_its_faults_are_reported() {
    let (folder, path) = file(ROOM);
    let model = folder.path().join("mine.toml");
    let text = include_str!("../../../../robots/turtlebot4.toml");
    fs::write(&model, text).expect("a file");
    let model = model.to_str().expect("a path in UTF-8");
    drop(awake(model, &path));
    fs::write(model, text.replace("radius = 0.171", "radius = -1")).expect("a file");
    let mut bench = robot(model, &path);
    let problems = bench.inspect().expect("it inspects");
    assert_eq!((problems.len(), problems[0].modulation.as_str()), (1, "model"));
    assert!(
        problems[0]
            .words
            .contains("mine.toml:9:10: `radius` of `footprint` of the robot is -1"),
        "{}",
        problems[0].words
    );
    assert!(bench.awake().is_err());
}

#[test]
fn an_unknown_robot_is_refused_with_the_known_ones() {
    let (_folder, path) = file(ROOM);
    for name in ["turtlebot5", "/home/apps/turtlebot5", ""] {
        let problems = robot(name, &path).inspect().expect("it inspects");
        assert!(
            problems.len() == 1 && problems[0].words.contains("`turtlebot4`"),
            "{problems:?}"
        );
    }
}

#[test]
fn a_robot_with_more_beams_than_fit_into_a_scan_is_refused() {
    let (folder, path) = file(ROOM);
    let model = folder.path().join("fine.toml");
    let text = include_str!("../../../../robots/turtlebot4.toml").replace("beams     = 720", "beams = 2000");
    fs::write(&model, text).expect("a file");
    let problems = robot(model.to_str().expect("UTF-8"), &path)
        .inspect()
        .expect("it inspects");
    assert!(
        problems[0].words.contains("2000 beams: expected at most 1088"),
        "{problems:?}"
    );
}

fn rear(world: &str, sensor: &str) -> Bench<crate::Laser> {
    let mut bench = Bench::new();
    bench.set("world", Text::<1024>::new(world));
    bench.set("robot", Text::<60>::new("bench"));
    bench.set("sensor", Text::<60>::new(sensor));
    bench
}

#[test]
fn a_further_laser_measures_from_its_own_place_while_its_robot_is_there() {
    let (_folder, path) = file(ROOM);
    let mut laser = rear(&path, "rear");
    laser.awake().expect("its configuration is valid");
    laser.iterate().expect("it waits");
    assert_eq!(laser.exported_at("laser"), None);
    let mut base = awake("omni", &path);
    let (mut now, mut scans) = (Duration::ZERO, BTreeSet::new());
    for _ in 0..20 {
        now = drive(&mut base, now, Twist::ZERO, 1);
        laser.set_now(now);
        laser.iterate().expect("it scans");
        scans.insert(laser.exported_at("laser").expect("the robot is there"));
    }
    assert_eq!(scans.len(), 10, "ten a second");
    let scan: LaserScan = laser.exported("laser").expect("the robot is there");
    assert_eq!(scan.header.frame_id.as_str(), "rear");
    // The robot is at x = 2, and the laser 0.3 m behind its centre.
    near(f64::from(scan.ranges[scan.ranges.len() / 2]), 1.7, 1e-3);
    drop(base);
    laser.iterate().expect("it waits");
    assert_eq!(laser.exported::<LaserScan>("laser"), None, "retracted");
}

#[test]
fn a_laser_that_the_robot_does_not_have_is_an_error_with_the_known_ones() {
    let (_folder, path) = file(ROOM);
    let mut base = awake("omni", &path);
    drive(&mut base, Duration::ZERO, Twist::ZERO, 1);
    let mut laser = rear(&path, "left");
    laser.awake().expect("its configuration is valid");
    let reason = laser.iterate().expect_err("there is none").reason;
    assert!(
        reason.contains("no laser `left`") && reason.contains("`front`, `rear`"),
        "{reason}"
    );
    let problems = rear(&path, "").inspect().expect("it inspects");
    assert!(
        problems[0].words.contains("no world, robot or sensor"),
        "{problems:?}"
    );
}

#[test]
fn a_contact_is_logged_once_though_the_driver_restarts() {
    let (_folder, path) = file(TWO_ROBOTS);
    let (mut left, _right) = (Robot::awake(&path, "left"), Robot::awake(&path, "right"));
    let touches = |robot: &Robot| {
        let mut texts = robot.bench.log().iter().map(|(_, text)| text);
        texts.any(|text| text.starts_with("it touches"))
    };
    left.drive(-0.2, 0.0, 8.0);
    assert_eq!(left.truth().collisions, 1);
    assert!(touches(&left));
    let now = left.now;
    drop(left);
    let mut again = Robot::awake(&path, "left");
    again.now = now;
    again.idle(0.05);
    assert_eq!(again.truth().collisions, 1);
    assert!(!touches(&again));
}
