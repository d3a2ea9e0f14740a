//! A robot whose wheels err and whose sensors fail, on the bench.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::Start;

mod doubts;

use super::Ekf;
use super::ports::HeadingUse;

/// What the gyro shows at rest, rad/s.
const BIAS: f64 = 0.01;

/// A robot that has wheels and an IMU, 20 times a second.
struct Robot {
    bench: Bench<Ekf>,
    truth: Pose2D,
    wheels: Pose2D,
    /// How much more the wheels turn than the base, rad/s.
    slip: f64,
    now: Duration,
    has_wheels: bool,
    has_imu: bool,
    /// What part of the turn the gyro measures.
    scale: f64,
    bias: f64,
    /// The variance that the compass states.
    compass: Option<f64>,
    /// How far ahead the antenna is, m.
    antenna: f64,
    /// What the gyro repeats.
    frozen: Option<f64>,
    step: u32,
}

impl Robot {
    fn new(bound: &[&str]) -> Self {
        let mut bench = Bench::new();
        for port in ["odom", "imu", "position", "pose"] {
            if !bound.contains(&port) {
                bench.unbind(port);
            }
        }
        bench.awake().expect("it awakes");
        Self {
            bench,
            truth: Pose2D::new(1.0, 2.0, 0.5),
            wheels: Pose2D::new(1.0, 2.0, 0.5),
            slip: 0.0,
            now: Duration::from_secs(10),
            has_wheels: bound.contains(&"odom"),
            has_imu: bound.contains(&"imu"),
            scale: 1.0,
            bias: BIAS,
            compass: None,
            antenna: 0.0,
            frozen: None,
            step: 0,
        }
    }

    fn wheels_and_imu() -> Self {
        Self::new(&["odom", "imu"])
    }

    /// Noise within 0.002 that never repeats.
    fn noise(&self) -> f64 {
        0.002 * (f64::from(self.step) * 1.7).sin()
    }

    fn step(&mut self, vx: f64, rate: f64) {
        self.step += 1;
        self.now += Duration::from_millis(50);
        self.bench.set_now(self.now);
        let moved = |vx: f64, rate: f64| Pose2D::new(vx * 0.05, vx * 0.05 * rate * 0.025, rate * 0.05);
        self.truth = self.truth.transform(&moved(vx, rate));
        let turned = rate + self.slip;
        self.wheels = self.wheels.transform(&moved(vx, turned));
        if self.has_imu {
            let shown = self
                .frozen
                .unwrap_or(self.scale * rate + self.bias + self.noise());
            let mut imu = imu(shown);
            imu.linear_acceleration.z += self.noise();
            if let Some(variance) = self.compass {
                imu.orientation = Quaternion::from_yaw(self.truth.theta);
                imu.orientation_covariance = [variance; 9];
            }
            self.bench.import("imu", &imu);
        }
        if self.has_wheels {
            let twist = Twist::planar(vx, turned);
            self.bench
                .import("odom", &Odometry::planar(self.now, self.wheels, twist));
        }
        self.bench.iterate().expect("the iteration succeeds");
    }

    fn go(&mut self, steps: usize, vx: f64, rate: f64) {
        (0..steps).for_each(|_| self.step(vx, rate));
    }

    /// Goes with a position of the antenna at each step.
    fn go_with_fixes(&mut self, steps: usize, vx: f64, rate: f64) {
        for _ in 0..steps {
            let at = self.truth.transform(&Pose2D::new(self.antenna, 0.0, 0.0));
            self.fix(at.x + self.noise(), at.y, "map");
            self.step(vx, rate);
        }
    }

    /// A localizer says that it is there, as at first.
    fn pose(&mut self, x: f64) {
        let pose = Pose2D::new(x, 2.0, 0.5);
        let mut odometry = Odometry::planar(self.now, pose, Twist::default());
        odometry.header = Header::new(self.now, "map");
        self.bench.import("pose", &odometry);
    }

    fn fix(&mut self, x: f64, y: f64, frame: &str) {
        let fix = PositionFix {
            header: Header::new(self.now, frame),
            x,
            y,
            covariance: [0.01, 0.0, 0.0, 0.01],
        };
        self.bench.import("position", &fix);
    }

    fn odometry(&self) -> Option<Odometry> {
        self.bench.exported("odometry")
    }

    fn words(&self) -> String {
        let state: Text<160> = self.bench.exported("state").expect("a state");
        state.as_str().to_owned()
    }

    #[track_caller]
    fn is_right(&self, most: f64) {
        let odometry = self
            .odometry()
            .unwrap_or_else(|| panic!("none: {}", self.words()));
        let error = self.truth.localize(&odometry.pose2d());
        assert!(
            error.x.hypot(error.y) < most && error.theta.abs() < most,
            "{error:?}: {}",
            self.words()
        );
    }

    #[track_caller]
    fn says(&self, words: &str) {
        assert!(self.words().contains(words), "{} for {words}", self.words());
    }
}

fn imu(rate: f64) -> Imu {
    let mut imu = Imu::default();
    imu.angular_velocity.z = rate;
    imu.linear_acceleration.z = 9.81;
    imu.orientation_covariance[0] = -1.0;
    for at in [0, 4, 8] {
        imu.angular_velocity_covariance[at] = 1e-5;
    }
    imu
}

#[test]
fn the_bias_is_learned_at_standstill_and_wheels_that_slip_turn_nothing() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    let bias: f64 = robot.bench.exported("gyro_bias").expect("a bias");
    assert!((bias - BIAS).abs() < 0.001, "{bias}");
    robot.go(100, 0.3, 0.4);
    robot.is_right(0.06);
    robot.slip = 0.8;
    robot.go(60, 0.3, 0.0);
    robot.says("otherwise than the gyro");
    robot.is_right(0.1);
    assert!(
        robot.wheels.distance_to(&robot.truth) > 0.5,
        "the wheels alone are lost"
    );
    robot.slip = 0.0;
    robot.go(60, 0.0, 0.0);
    robot.is_right(0.1);
    let odometry = robot.odometry().expect("it is exported");
    assert_eq!(odometry.header.frame_id.as_str(), "odom");
    assert!(odometry.pose.covariance[0] > 0.0 && odometry.twist.covariance[35] > 0.0);
}

#[test]
fn the_steps_of_the_pose_serve_in_place_of_the_velocity() {
    let mut robot = Robot::wheels_and_imu();
    robot.bench.set("odom_differential", true);
    robot.go(60, 0.0, 0.0);
    robot.go(100, 0.3, 0.4);
    robot.is_right(0.06);
}

#[test]
fn a_sensor_that_is_silent_is_named_and_the_others_go_on() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.go(40, 0.3, 0.1);
    let before = robot.odometry().expect("both").pose.covariance[35];
    robot.has_imu = false;
    robot.go(60, 0.3, 0.1);
    robot.says("no IMU's values for");
    robot.is_right(0.1);
    assert!(robot.odometry().expect("wheels").pose.covariance[35] > 2.0 * before);
    robot.has_imu = true;
    robot.go(5, 0.3, 0.1);
    assert!(!robot.words().contains("no IMU"), "{}", robot.words());
    robot.has_wheels = false;
    robot.go(30, 0.3, 0.1);
    assert_eq!(robot.odometry(), None);
    robot.says("the speed may be off");
    robot.says("no odometries for");
    robot.has_imu = false;
    robot.go(30, 0.0, 0.0);
    assert_eq!(robot.odometry(), None);
    robot.says("no sensor measures");
}

#[test]
fn an_imu_that_repeats_itself_while_the_wheels_move_is_none() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.frozen = Some(BIAS);
    robot.go(60, 0.3, 0.4);
    robot.says("repeat themselves");
    robot.go(60, 0.3, 0.4);
    let odometry = robot.odometry().expect("the wheels go on");
    assert!(
        (odometry.twist.twist.angular.z - 0.4).abs() < 0.05,
        "{odometry:?}"
    );
}

#[test]
fn stamps_of_another_clock_are_refused_in_words() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    let (now, later) = (robot.now, robot.now + Duration::from_secs(3));
    robot.has_imu = false;
    robot.bench.set_now(later);
    robot.bench.import("imu", &imu(1.0));
    robot.step(0.0, 0.0);
    robot.says("s ahead of the clock");
    robot.bench.set_now(now - Duration::from_secs(2));
    robot.bench.import("imu", &imu(1.0));
    robot.step(0.0, 0.0);
    robot.says("2.1 s old");
    robot.is_right(0.01);
}

#[test]
fn positions_correct_the_drift_late_ones_too_and_a_false_one_moves_nothing() {
    let mut robot = Robot::new(&["odom", "imu", "position"]);
    robot
        .bench
        .set("initial_pose", Start::at(Pose2D::new(1.2, 1.9, 0.5)));
    robot.go(60, 0.0, 0.0);
    for _ in 0..20 {
        // It was measured before the last half second.
        let (now, at) = (robot.now, robot.truth);
        robot.go(10, 0.3, 0.2);
        let later = robot.now;
        robot.now = now;
        robot.bench.set_now(now);
        robot.fix(at.x, at.y, "map");
        robot.now = later;
        robot.go(10, 0.3, 0.2);
    }
    robot.is_right(0.1);
    assert_eq!(robot.odometry().expect("a pose").header.frame_id.as_str(), "map");
    robot.fix(30.0, 30.0, "map");
    robot.step(0.3, 0.2);
    robot.is_right(0.1);
    robot.says("the positions are refused");
    robot.fix(0.0, 0.0, "utm");
    robot.step(0.3, 0.2);
    robot.says("frames \"map\" and \"utm\"");
    // Two outliers are no place, however long there is nothing between them.
    robot.fix(30.0, 30.0, "map");
    robot.go(200, 0.0, 0.0);
    robot.fix(-30.0, 30.0, "map");
    robot.go(2, 0.0, 0.0);
    robot.is_right(0.1);
    // Carried away and turned, positions alone do not say how it stands.
    robot.truth = robot.truth.transform(&Pose2D::new(10.0, 5.0, 2.0));
    robot.go_with_fixes(150, 0.3, 0.2);
    assert_eq!(robot.odometry(), None);
    robot.says("a position says no heading");
}

#[test]
fn a_position_without_a_heading_says_what_is_missing_and_a_compass_gives_it() {
    let mut robot = Robot::new(&["odom", "imu", "position"]);
    robot.step(0.0, 0.0);
    robot.says("no position yet");
    robot.fix(1.0, 2.0, "map");
    robot.step(0.0, 0.0);
    robot.says("a position says no heading");
    assert_eq!(robot.odometry(), None);
    robot.bench.set("imu_heading", HeadingUse::Absolute);
    robot.bench.set("imu_roll", core::f64::consts::PI);
    robot.has_imu = false;
    // Upside down, its axis up is the base's down.
    let mut measured = imu(-BIAS);
    let half = Quaternion {
        x: 1.0,
        y: 0.0,
        z: 0.0,
        w: 0.0,
    };
    measured.orientation = Quaternion::from_yaw(0.5).compose(&half);
    measured.orientation_covariance = [0.001; 9];
    robot.fix(1.0, 2.0, "map");
    for _ in 0..30 {
        robot.bench.import("imu", &measured);
        robot.step(0.0, 0.0);
    }
    robot.is_right(0.1);
}

#[test]
fn numbers_that_are_none_and_jumps_move_nothing() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        robot.frozen = Some(bad);
        robot.step(0.0, 0.0);
        robot.is_right(0.01);
    }
    robot.frozen = None;
    robot.wheels.x += 5.0;
    robot.go(20, 0.1, 0.0);
    robot.is_right(0.05);
}

#[test]
fn it_goes_on_after_a_reload_where_it_was() {
    let mut robot = Robot::wheels_and_imu();
    robot.go(60, 0.0, 0.0);
    robot.go(40, 0.3, 0.2);
    robot.wheels = Pose2D::new(0.0, 0.0, 0.0);
    robot.go(40, 0.3, 0.2);
    let remembered = robot.bench.save().expect("it saves");
    let mut next = Bench::new();
    for port in ["position", "pose"] {
        next.unbind(port);
    }
    next.restore(&remembered).expect("it restores");
    next.awake().expect("it awakes");
    robot.bench = next;
    robot.go(40, 0.3, 0.2);
    robot.is_right(0.1);
    robot.bench.sleep().expect("it sleeps");
    assert_eq!(robot.odometry(), None);
}
