//! The robot as other schemas see it: units, axes, orders and times of its sensors, and its errors for a
//! wrong world.

use core::f64::consts::{FRAC_PI_2, PI};
use std::fs;

use jde_schema::bench::Bench;
use tempfile::TempDir;

use super::*;

mod deliveries;
mod robots;

/// A room of 6 x 5 m. `bench` is the name of schemas on a test bench.
const ROOM: &str = r#"
walls = [{ name = "room", points = [[0, 0], [6, 0], [6, 5], [0, 5]], closed = true }]

[robots.bench]
start = { x = 2, y = 3, heading_deg = 0 }
"#;

const PERIOD: Duration = Duration::from_millis(50);

/// A robot without noise on a test bench. Its command is renewed before each iteration.
pub(crate) struct Robot {
    pub(crate) bench: Bench<crate::Robot>,
    pub(crate) now: Duration,
}

impl Robot {
    pub(crate) fn asleep(world: &str, name: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("world", Text::<1024>::new(world));
        bench.set("robot", Text::<60>::new(name));
        for noise in ["laser_noise", "sonar_noise", "wheel_error"] {
            bench.set(noise, 0.0);
        }
        Self {
            bench,
            now: Duration::ZERO,
        }
    }

    pub(crate) fn awake(world: &str, name: &str) -> Self {
        let mut robot = Self::asleep(world, name);
        robot.bench.awake().expect("it enters the world");
        robot
    }

    /// Iterates for a number of seconds without a command.
    pub(crate) fn idle(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end {
            self.now += PERIOD;
            self.bench.set_now(self.now);
            self.bench.iterate().expect("it drives and senses");
        }
    }

    /// Renews a command for a time, and then brakes until the robot stops.
    pub(crate) fn drive(&mut self, linear: f64, angular: f64, seconds: f64) {
        for (twist, seconds) in [(Twist::planar(linear, angular), seconds), (Twist::ZERO, 2.0)] {
            let end = self.now + Duration::from_secs_f64(seconds);
            while self.now < end {
                self.bench.command("velocity", &twist);
                self.bench.iterate().expect("it drives and senses");
                self.now += PERIOD;
                self.bench.set_now(self.now);
            }
        }
        self.bench.iterate().expect("it drives and senses");
    }

    fn truth(&self) -> Truth {
        self.bench.exported("truth").expect("it has iterated")
    }

    fn odometry(&self) -> Odometry {
        self.bench.exported("odometry").expect("it has iterated")
    }

    fn laser(&self) -> Box<LaserScan> {
        Box::new(self.bench.exported("laser").expect("it has iterated"))
    }
}

/// A world file. Its folder is deleted when the first value is dropped.
pub(crate) fn file(text: &str) -> (TempDir, String) {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("place.toml");
    fs::write(&path, text).expect("a file");
    let path = path.to_str().expect("a path in UTF-8").to_owned();
    (folder, path)
}

#[track_caller]
fn near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} is not {expected} ± {tolerance}"
    );
}

#[test]
fn a_square_of_metres_and_radians_ends_at_its_start() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    let corners = [(3.0, 3.0), (3.0, 4.0), (2.0, 4.0), (2.0, 3.0)];
    for (x, y) in corners {
        robot.drive(0.25, 0.0, 4.0);
        near(robot.truth().pose.x, x, 0.01);
        near(robot.truth().pose.y, y, 0.01);
        robot.drive(0.0, FRAC_PI_2 / 2.0, 2.0);
    }
    near(normalize_angle(robot.truth().pose.theta), 0.0, 0.01);
    assert_eq!(robot.truth().collisions, 0);
}

#[test]
fn a_positive_turn_is_to_the_left_and_on_the_spot() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.drive(0.0, 0.5, 2.0);
    let pose = robot.truth().pose;
    near(pose.theta, 1.0, 0.01);
    near(pose.x, 2.0, 0.001);
    near(pose.y, 3.0, 0.001);
    near(robot.odometry().pose2d().theta, 1.0, 0.01);
}

#[test]
fn the_odometry_contains_the_current_speed_in_the_frame_of_the_robot() {
    let (_folder, path) = file(&ROOM.replace("heading_deg = 0", "heading_deg = 90"));
    let mut robot = Robot::awake(&path, "bench");
    for _ in 0..30 {
        robot.bench.command("velocity", &Twist::planar(0.2, 0.0));
        robot.idle(0.05);
    }
    let twist = robot.odometry().twist.twist;
    near(twist.linear.x, 0.2, 0.005);
    near(twist.linear.y, 0.0, 0.0);
    // Each wheel slips a little by itself.
    near(twist.angular.z, 0.0, 0.05);
}

#[test]
fn the_odometry_starts_at_the_start_pose_of_the_world() {
    let (_folder, path) = file(&ROOM.replace("heading_deg = 0", "heading_deg = 90"));
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    let odometry = robot.odometry();
    assert_eq!(odometry.header.frame_id.as_str(), "odom");
    assert_eq!(odometry.child_frame_id.as_str(), "base_link");
    near(
        odometry.pose2d().distance_to(&Pose2D::new(2.0, 3.0, 0.0)),
        0.0,
        1e-9,
    );
    near(odometry.pose2d().theta, FRAC_PI_2, 1e-9);
}

#[test]
fn the_laser_measures_the_walls_from_right_to_left() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    let scan = robot.laser();
    assert_eq!((scan.ranges.len(), scan.header.frame_id.as_str()), (180, "laser"));
    assert_eq!(robot.bench.exported_at("laser"), Some(PERIOD));
    near(scan.angle(0), -FRAC_PI_2, 1e-6);
    near(f64::from(scan.angle_increment), PI / 180.0, 1e-6);
    // The laser is 18 mm ahead of the base.
    near(f64::from(scan.ranges[0]), 3.0, 0.001);
    near(f64::from(scan.ranges[90]), 6.0 - 2.018, 0.001);
    near(f64::from(scan.ranges[179]), 2.0 / scan.angle(179).sin(), 0.001);
    near(scan.nearest_ahead(0.3).expect("a wall"), 6.0 - 2.018, 0.001);
}

#[test]
fn a_beam_without_an_obstacle_is_infinite() {
    let (_folder, path) = file(ROOM);
    let (_models, model) = file(
        &include_str!("../../../../robots/pioneer-3dx.toml")
            .replace("beams     = 180", "beams = 4")
            .replace("view_deg  = 180", "view_deg = 360"),
    );
    let mut robot = Robot::asleep(&path, "bench");
    robot.bench.set("model", Text::<1024>::new(&model));
    robot.bench.set("laser_range", 3.5);
    robot.bench.awake().expect("it enters the world");
    robot.idle(0.05);
    let scan = robot.laser();
    let [behind, right, ahead, left] = scan.ranges.as_slice() else {
        panic!("{} beams", scan.ranges.len())
    };
    near(f64::from(*behind), 2.018, 0.001);
    near(f64::from(*right), 3.0, 0.001);
    assert_eq!(
        *ahead,
        f32::INFINITY,
        "the wall is 3.98 m away, and the range is 3.5 m"
    );
    near(f64::from(*left), 2.0, 0.001);
}

#[test]
fn sonars_are_ordered_clockwise_from_ahead_on_the_left() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    let ring: RangeRing = robot.bench.exported("sonars").expect("it has iterated");
    let headings: Vec<f64> = ring
        .poses
        .iter()
        .map(|pose| pose.theta.to_degrees().round())
        .collect();
    let ahead = [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0];
    let behind = [-90.0, -130.0, -150.0, -170.0, 170.0, 150.0, 130.0, 90.0];
    assert_eq!(headings, [ahead, behind].concat());
    // The outer sonars face the walls at the sides, 136 mm from the middle.
    for (sonar, range) in [(0, 2.0), (7, 3.0), (8, 3.0), (15, 2.0)] {
        near(f64::from(ring.ranges[sonar]), range - 0.136, 0.001);
    }
}

#[test]
fn bumpers_report_the_touched_side_and_blocked_wheels() {
    let (_folder, path) = file(&ROOM.replace("x = 2", "x = 5.6"));
    let mut robot = Robot::awake(&path, "bench");
    for _ in 0..60 {
        robot.bench.command("velocity", &Twist::planar(0.2, 0.0));
        robot.idle(0.05);
    }
    let bumpers: Bumpers = robot.bench.exported("bumpers").expect("it has iterated");
    let pressed = |ring: &Seq<Flag, 8>| ring.iter().map(|flag| flag.get()).collect::<Vec<_>>();
    assert_eq!(pressed(&bumpers.front), [false, false, true, false, false]);
    assert_eq!(pressed(&bumpers.rear), [false; 5]);
    assert!(bumpers.stalled.get());
    assert_eq!(robot.truth().collisions, 1);
    assert_eq!(robot.odometry().child_frame_id, bumpers.header.frame_id);
}

#[test]
fn rear_bumpers_are_ordered_from_left_to_right_facing_ahead() {
    // The robot backs into the wall at x = 6 and touches it with its right half: it faces 30 degrees to the
    // right of the direction away from the wall.
    let (_folder, path) = file(
        &ROOM
            .replace("x = 2", "x = 5.6")
            .replace("heading_deg = 0", "heading_deg = 150"),
    );
    let mut robot = Robot::awake(&path, "bench");
    for _ in 0..60 {
        robot.bench.command("velocity", &Twist::planar(-0.2, 0.0));
        robot.idle(0.05);
    }
    let bumpers: Bumpers = robot.bench.exported("bumpers").expect("it has iterated");
    let rear: Vec<bool> = bumpers.rear.iter().map(|flag| flag.get()).collect();
    assert_eq!(rear, [false, false, false, true, false]);
}

#[test]
fn a_command_that_is_not_renewed_ends_with_its_validity() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.bench.command("velocity", &Twist::planar(0.3, 0.0));
    robot.idle(0.5);
    assert!(robot.truth().twist.linear.x > 0.1, "it is in force");
    robot.idle(1.5);
    assert_eq!(robot.truth().twist, Twist::ZERO);
}

#[test]
fn the_robot_brakes_when_its_driver_goes_to_sleep() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.bench.command("velocity", &Twist::planar(0.3, 0.0));
    robot.idle(0.5);
    let before = robot.truth().pose;
    robot.bench.sleep().expect("it sleeps");
    robot.now += Duration::from_secs(5);
    robot.bench.awake().expect("it wakes");
    robot.idle(0.05);
    // From 0.15 m/s to 0 at 0.3 m/s².
    near(robot.truth().pose.x - before.x, 0.0375, 0.01);
}

/// Two robots that face each other at a distance of 3 m.
const TWO_ROBOTS: &str = r#"
walls = [{ name = "hall", points = [[0, 0], [6, 0], [6, 5], [0, 5]], closed = true }]

[robots.left]
start = { x = 1.5, y = 2, heading_deg = 0 }

[robots.right]
start = { x = 4.5, y = 2, heading_deg = 180 }
"#;

#[test]
fn robots_of_one_application_share_the_world_of_a_file() {
    let (_folder, path) = file(TWO_ROBOTS);
    let (mut left, mut right) = (Robot::awake(&path, "left"), Robot::awake(&path, "right"));
    left.idle(0.05);
    near(f64::from(left.laser().ranges[90]), 3.0 - 0.018 - 0.25, 0.001);
    right.now = left.now;
    for _ in 0..240 {
        left.bench.command("velocity", &Twist::planar(0.3, 0.0));
        left.idle(0.05);
        right.idle(0.05);
    }
    near(left.truth().pose.distance_to(&right.truth().pose), 0.5, 0.002);
    assert_eq!((left.truth().collisions, right.truth().collisions), (1, 1));
}

#[test]
fn a_driver_that_restarts_finds_its_robot_at_its_last_pose() {
    let (_folder, path) = file(TWO_ROBOTS);
    let (mut left, _right) = (Robot::awake(&path, "left"), Robot::awake(&path, "right"));
    left.drive(0.25, 0.0, 4.0);
    let now = left.now;
    drop(left);
    let mut again = Robot::awake(&path, "left");
    again.now = now;
    again.idle(0.05);
    near(again.truth().pose.x, 2.5, 0.01);
    near(again.odometry().pose2d().x, 2.5, 0.01);
}

#[test]
fn a_driver_that_is_dropped_stops_its_robot() {
    let (_folder, path) = file(TWO_ROBOTS);
    let (mut left, mut right) = (Robot::awake(&path, "left"), Robot::awake(&path, "right"));
    left.bench.command("velocity", &Twist::planar(0.3, 0.0));
    left.idle(0.5);
    right.now = left.now;
    drop(left);
    right.idle(10.0);
    let distance = f64::from(right.laser().ranges[90]);
    assert!(distance > 2.5, "the robot came as near as {distance} m");
}

#[test]
fn a_world_closes_without_robots_and_can_be_opened_again() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.drive(0.25, 0.0, 4.0);
    drop(robot);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    near(robot.truth().pose.x, 2.0, 1e-9);
}

#[test]
fn a_robot_without_a_name_has_the_name_of_its_schema() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "");
    robot.idle(0.05);
    near(robot.truth().pose.x, 2.0, 1e-9);
}

#[track_caller]
fn assert_refused(world: &str, name: &str, expected: &[&str]) {
    let mut bench = Robot::asleep(world, name).bench;
    let problems = bench.inspect().expect("it inspects");
    let reason = bench.awake().expect_err("it cannot enter the world").reason;
    for text in expected {
        assert!(reason.contains(text), "`{text}` is not in: {reason}");
    }
    let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
    assert_eq!(messages, [reason], "an inspection reports the same");
}

#[test]
fn invalid_worlds_and_robots_are_refused_with_a_remedy() {
    assert_refused("", "", &["it has no world", "world = \"worlds/office.toml\""]);
    let (_folder, path) = file(ROOM);
    assert_refused(
        &path.replace("place", "palace"),
        "bench",
        &["palace.toml: there is no such file", "place.toml`?"],
    );
    assert_refused(&path, "bnech", &["no robot `bnech`", "did you mean `bench`?"]);
    let (_folder, path) = file(&ROOM.replace("x = 2,", "x = two,"));
    assert_refused(&path, "bench", &["place.toml:5:"]);
    let (_folder, path) = file(&ROOM.replace("x = 2,", "x = 0.1,"));
    assert_refused(&path, "bench", &["place.toml:5", "starts on `room`"]);
}

#[test]
fn a_robot_has_one_driver() {
    let (_folder, path) = file(ROOM);
    let _first = Robot::awake(&path, "bench");
    let mut second = Robot::asleep(&path, "bench").bench;
    let reason = second.awake().expect_err("it cannot enter the world").reason;
    assert!(
        reason.contains("robot `bench` has a driver already") && reason.contains("robot = "),
        "{reason}"
    );
    assert_eq!(
        second.inspect(),
        Ok(vec![]),
        "an inspection does not consider other drivers"
    );
}

#[test]
#[should_panic(expected = "`wheel_error` is 0.6, and at most 0.5 is allowed")]
fn r8_numbers_out_of_range_are_refused() {
    let (_folder, path) = file(ROOM);
    Robot::asleep(&path, "bench").bench.set("wheel_error", 0.6);
}

#[test]
fn the_head_turns_to_the_commanded_angles_and_stays_there() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    let target = PanTilt {
        pan: 0.6,
        tilt: -0.2,
        pan_velocity: 0.5,
        tilt_velocity: 0.5,
        ..PanTilt::default()
    };
    robot.idle(0.05);
    robot.bench.command("head", &target);
    robot.idle(0.6);
    let head: PanTilt = robot.bench.exported("pan_tilt").expect("it has iterated");
    // Commanded at 0.1 s, measured 0.55 s later.
    near(head.pan, 0.275, 0.03);
    near(head.pan_velocity, 0.5, 1e-9);
    near(head.tilt, -0.2, 1e-9);
    robot.idle(60.0);
    let head: PanTilt = robot.bench.exported("pan_tilt").expect("it has iterated");
    assert_eq!((head.pan, head.tilt, head.pan_velocity), (0.6, -0.2, 0.0));
}

#[test]
fn the_head_of_a_sleeping_robot_does_not_move() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    let target = PanTilt {
        pan: 1.0,
        pan_velocity: 0.5,
        ..PanTilt::default()
    };
    robot.bench.command("head", &target);
    robot.idle(1.0);
    robot.bench.sleep().expect("it sleeps");
    let before: PanTilt = robot.bench.exported("pan_tilt").expect("it has iterated");
    robot.now += Duration::from_secs(5);
    robot.bench.set_now(robot.now);
    robot.bench.awake().expect("it wakes");
    robot.bench.command("head", &PanTilt::default());
    robot.bench.iterate().expect("it senses");
    let after: PanTilt = robot.bench.exported("pan_tilt").expect("it has iterated");
    near(after.pan, before.pan, 1e-9);
}

#[test]
fn a_drive_discharges_the_battery_and_counts_encoder_ticks() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    let full: BatteryState = robot.bench.exported("battery").expect("it has iterated");
    robot.drive(0.25, 0.0, 4.0);
    let battery: BatteryState = robot.bench.exported("battery").expect("it has iterated");
    assert!(
        full.percentage > 0.999 && battery.charge < full.charge,
        "{battery:?}"
    );
    assert!(
        battery.current < 0.0 && battery.voltage > 12.0 && battery.present.get(),
        "{battery:?}"
    );
    let encoders: WheelEncoders = robot.bench.exported("encoders").expect("it has iterated");
    let metres = |ticks: i64| ticks as f64 / encoders.ticks_per_meter;
    near(metres(encoders.left), 1.0, 0.01);
    near(metres(encoders.right), 1.0, 0.01);
}

#[test]
fn the_robot_is_connected_since_it_entered_its_world() {
    let (_folder, path) = file(&format!("name = 'den'\n{ROOM}"));
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(1.0);
    let connection: Connection = robot.bench.exported("connection").expect("it has iterated");
    assert!(connection.is_up());
    assert_eq!(connection.note.as_str(), "den");
    assert_eq!(Duration::from(connection.header.stamp), Duration::ZERO);
}
