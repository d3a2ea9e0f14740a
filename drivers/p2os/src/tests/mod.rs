//! The driver over TCP and over a pseudo-terminal, connected to a scripted robot, which uses the same
//! library.

mod robot;

use core::f64::consts::FRAC_PI_2;
use std::net::TcpListener;
use std::thread;
use std::time::Instant;

use jde_motion::BaseDynamics;
use jde_p2os::*;
use jde_schema::bench::Bench;
use jde_schema::prelude::{
    BatteryState, Bumpers as Pressed, Connection, LaserScan, Odometry, PanTilt, Pose2D, RangeRing, Text,
    Twist, WheelEncoders,
};

use jde_schema::types::Body;

use super::Pioneer;
use robot::{Robot, Script};

/// The driver, and the time at which it was created.
struct Driver {
    bench: Bench<Pioneer>,
    start: Instant,
}

impl Driver {
    fn new(port: &str) -> Self {
        let mut driver = Self::asleep(port);
        driver.bench.awake().expect("its configuration is valid");
        driver
    }

    fn asleep(port: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("port", Text::<256>::new(port));
        Self {
            bench,
            start: Instant::now(),
        }
    }

    fn step(&mut self) -> Result<(), String> {
        self.bench.set_now(self.start.elapsed());
        let result = self.bench.iterate().map_err(|failure| failure.reason);
        thread::yield_now();
        result
    }

    /// Iterates until a condition holds. If it never does, the test times out.
    fn until(&mut self, mut condition: impl FnMut(&Bench<Pioneer>) -> bool) {
        while !condition(&self.bench) {
            self.step().expect("a driver whose robot fails does not fail");
        }
    }

    fn until_connected(&mut self) {
        self.until(|bench| {
            state(bench) == Connection::CONNECTED && bench.exported::<RangeRing>("sonars").is_some()
        });
    }

    fn drive(&mut self, twist: Twist, mut done: impl FnMut() -> bool) {
        while !done() {
            self.bench.command("velocity", &twist);
            self.step().expect("it drives");
        }
    }
}

fn connection(bench: &Bench<Pioneer>) -> Connection {
    bench.exported("connection").unwrap_or_default()
}

fn state(bench: &Bench<Pioneer>) -> u8 {
    connection(bench).state
}

fn report_sonars(script: &mut Script) {
    script.sip.sonars = vec![
        SonarReading {
            index: 0,
            range: 2500,
        },
        SonarReading {
            index: 15,
            range: 5000,
        },
        SonarReading { index: 99, range: 1 },
    ];
}

#[test]
fn a_robot_behind_tcp_is_connected_driven_and_sensed() {
    let (robot, address) = Robot::at_tcp("p3dx-sh");
    robot.with(|script| {
        report_sonars(script);
        script.sip.stall_bumpers = 0b0000_0010_0000_0011;
    });
    let mut driver = Driver::asleep(&address);
    driver.bench.set("start", Pose2D::new(1.0, 2.0, FRAC_PI_2));
    driver.bench.awake().unwrap();
    driver.until_connected();
    // The configuration of the scripted robot has no watchdog.
    let has_logged = |text: &str| driver.bench.log().iter().any(|(_, line)| line.contains(text));
    assert!(has_logged("its watchdog is off"));
    assert_eq!(
        connection(&driver.bench).note.as_str(),
        "AMRISim, Pioneer p3dx-sh"
    );

    driver.drive(Twist::planar(0.25, -0.5), || {
        robot.with(|script| {
            script.received.contains(&Command::Velocity(250))
                && script.received.contains(&Command::RotVelocity(-29))
        })
    });

    let ring: RangeRing = driver.bench.exported("sonars").unwrap();
    assert_eq!(ring.poses.len(), 16);
    assert_eq!((ring.ranges[0], ring.ranges[15]), (2.5, f32::INFINITY));
    assert!(ring.ranges[1].is_nan());
    let pressed: Pressed = driver.bench.exported("bumpers").unwrap();
    assert!(pressed.stalled.get() && pressed.front[0].get() && !pressed.front[1].get());
    // The robot's first rear bumper is the right one, which is the last from left to right.
    assert!(pressed.rear[4].get() && !pressed.rear[0].get());
    let battery: BatteryState = driver.bench.exported("battery").unwrap();
    assert_eq!(battery.voltage, 12.4);
    assert!((battery.percentage - 0.7).abs() < 1e-6 && battery.temperature.is_nan());
    let encoders: WheelEncoders = driver.bench.exported("encoders").unwrap();
    assert_eq!(
        (encoders.left, encoders.right, encoders.ticks_per_meter),
        (0, 0, 128_000.0)
    );

    robot.with(|script| {
        (script.sip.x, script.sip.left_velocity, script.sip.right_velocity) = (100, 200, 300);
    });
    driver.until(|bench| {
        let odometry: Odometry = bench.exported("odometry").unwrap();
        odometry.twist.twist.linear.x == 0.25
    });
    let odometry: Odometry = driver.bench.exported("odometry").unwrap();
    let pose = odometry.pose2d();
    assert!(
        (pose.x - 1.0).abs() < 1e-9 && (pose.y - 2.1).abs() < 1e-9,
        "{pose:?}"
    );
    assert!((odometry.twist.twist.angular.z - 0.28).abs() < 1e-9);
}

#[test]
fn the_laser_of_a_simulator_is_exported_in_metres_from_right_to_left() {
    let (_robot, address) = Robot::at_tcp("p3dx");
    let mut driver = Driver::new(&address);
    driver.until(|bench| bench.exported::<LaserScan>("laser").is_some());
    let scan: Box<LaserScan> = Box::new(driver.bench.exported("laser").unwrap());
    assert_eq!(scan.ranges.len(), 180);
    assert!((scan.angle_min + core::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert!((scan.angle_increment - 1f32.to_radians()).abs() < 1e-6);
    assert_eq!((scan.ranges[0], scan.ranges[100]), (1.0, 6.0));
    assert_eq!(scan.ranges[140], f32::INFINITY);
    assert!(scan.intensities.is_empty());
    let body: Body = driver.bench.exported("body").unwrap();
    assert_eq!(body.footprint.radius, 0.25);
    assert_eq!(body.laser("laser"), Pose2D::new(0.018, 0.0, 0.0));
}

#[test]
fn the_accelerations_of_the_robots_settings_are_exported_and_what_it_does_not_state_is_unknown() {
    let (_robot, address) = Robot::at_tcp("p3dx");
    let mut driver = Driver::new(&address);
    let stated = BaseDynamics {
        acceleration: 0.3,
        deceleration: 0.6,
        ..BaseDynamics::default()
    };
    driver.until(|bench| bench.exported("dynamics") == Some(stated));
}

#[test]
fn a_robot_at_a_serial_line_is_connected_and_driven() {
    let (robot, address) = Robot::at_line("amigo");
    let mut driver = Driver::new(&address);
    driver.until(|bench| state(bench) == Connection::CONNECTED);
    driver.drive(Twist::planar(-0.1, 0.0), || {
        robot.with(|script| script.received.contains(&Command::Velocity(-100)))
    });
}

#[test]
fn the_exports_of_a_lost_robot_are_retracted_and_its_odometry_continues() {
    let (robot, address) = Robot::at_tcp("p3dx-sh");
    robot.with(report_sonars);
    let mut driver = Driver::new(&address);
    driver.until_connected();
    robot.with(|script| script.sip.x = 150);
    driver.until(|bench| {
        bench
            .exported::<Odometry>("odometry")
            .is_some_and(|odometry| odometry.pose2d().x > 0.1)
    });
    for silence in [false, true] {
        robot.with(|script| (script.hang_up, script.mute) = (!silence, silence));
        driver.until(|bench| state(bench) == Connection::LOST);
        assert!(!connection(&driver.bench).note.is_empty());
        for export in [
            "odometry", "sonars", "laser", "battery", "bumpers", "encoders", "body", "dynamics",
        ] {
            assert_eq!(driver.bench.exported_at(export), None, "{export}");
        }
        robot.with(|script| {
            (script.mute, script.sip.x) = (false, 7);
        });
        driver.until_connected();
        let odometry: Odometry = driver.bench.exported("odometry").unwrap();
        assert!((odometry.pose2d().x - 0.15).abs() < 1e-9);
    }
}

#[test]
fn without_iterations_the_robot_receives_nothing() {
    let (robot, address) = Robot::at_tcp("p3dx");
    robot.with(report_sonars);
    let mut driver = Driver::new(&address);
    driver.until_connected();
    driver.drive(Twist::planar(0.3, 0.0), || {
        robot.with(|script| script.received.contains(&Command::Velocity(300)))
    });
    // After some more reports of the robot, earlier bytes in transit have arrived.
    let wait_reports = |count: u32| {
        let from = robot.with(|script| script.reports);
        while robot.with(|script| script.reports) < from + count {
            thread::yield_now();
        }
    };
    wait_reports(5);
    robot.with(|script| script.received.clear());
    wait_reports(50);
    assert_eq!(robot.with(|script| script.received.clone()), []);
}

#[test]
fn a_driver_that_sleeps_or_is_dropped_stops_the_robot_and_switches_it_off() {
    let last_commands = [
        Command::Velocity(0),
        Command::RotVelocity(0),
        Command::Enable(false),
        Command::Sonar(0),
        Command::Close(Form::One),
    ];
    for dropped in [false, true] {
        let (robot, address) = Robot::at_tcp("p3dx");
        robot.with(report_sonars);
        let mut driver = Driver::new(&address);
        driver.until_connected();
        driver.drive(Twist::planar(0.3, 0.0), || {
            robot.with(|script| script.received.contains(&Command::Velocity(300)))
        });
        if dropped {
            drop(driver);
        } else {
            driver.bench.sleep().unwrap();
            assert_eq!(driver.bench.exported_at("odometry"), None);
            assert_eq!(driver.bench.exported_at("connection"), None);
        }
        while !robot.with(|script| script.received.ends_with(&last_commands)) {
            thread::yield_now();
        }
    }
}

#[test]
fn a_command_of_the_head_reaches_the_camera_and_its_angles_are_exported() {
    let (robot, address) = Robot::at_tcp("p3dx");
    let mut driver = Driver::asleep(&address);
    driver.bench.set("head_kind", Text::<28>::new("vc-c4-one-way"));
    driver.bench.awake().unwrap();
    let target = PanTilt {
        pan: 0.2,
        tilt: -0.1,
        pan_velocity: 1.0,
        tilt_velocity: 1.0,
        ..PanTilt::default()
    };
    driver.bench.command("head", &target);
    driver.until(|bench| {
        bench
            .exported::<PanTilt>("pan_tilt")
            .is_some_and(|head| (head.pan - 0.2).abs() < HEAD_UNIT && (head.tilt + 0.1).abs() < HEAD_UNIT)
    });
    let command = HeadCommand::PanTilt { pan: -102, tilt: 51 }.to_bytes();
    assert!(robot.with(|script| script.received.contains(&Command::Tty2(command))));
}

#[test]
fn invalid_settings_are_errors_at_once() {
    let error = |set: &dyn Fn(&mut Bench<Pioneer>)| {
        let mut driver = Driver::asleep("tcp:127.0.0.1:1");
        set(&mut driver.bench);
        let problems = driver.bench.inspect().unwrap();
        let reason = driver.bench.awake().unwrap_err().reason;
        let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
        assert_eq!(messages, [&*reason], "an inspection reports the same");
        reason
    };
    assert!(error(&|bench| bench.set("port", Text::<256>::new(""))).contains("port = "));
    assert!(error(&|bench| bench.set("port", Text::<256>::new("udp:x"))).contains("serial:PATH@BAUD"));
    assert!(error(&|bench| bench.set("model", Text::<1024>::new("p9"))).contains("`p3dx`"));
    assert!(error(&|bench| bench.set("model", Text::<1024>::new("none.toml"))).contains("none.toml"));
    assert!(error(&|bench| bench.set("laser_mode", Text::<28>::new("maybe"))).contains("auto, on or off"));
    assert!(error(&|bench| bench.set("head_kind", Text::<28>::new("neck"))).contains("vc-c4"));
    let mut driver = Driver::asleep("tcp:127.0.0.1:1");
    assert_eq!(
        driver.bench.inspect(),
        Ok(vec![]),
        "an inspection does not connect"
    );
    driver.bench.set_real_time(false);
    assert!(driver.bench.awake().unwrap_err().reason.contains("lockstep"));
}

#[test]
fn an_unknown_kind_of_robot_is_an_error_that_a_model_file_solves() {
    let (_robot, address) = Robot::at_tcp("roomba");
    let mut driver = Driver::new(&address);
    let error = loop {
        if let Err(error) = driver.step() {
            break error;
        }
    };
    assert!(error.contains("`roomba`") && error.contains("`p3at`"), "{error}");
    drop(driver);

    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, include_str!("../../../../devices/p2os/models/p3at.toml")).unwrap();
    let mut driver = Driver::asleep(&address);
    driver
        .bench
        .set("model", Text::<1024>::new(path.to_str().unwrap()));
    driver.bench.awake().unwrap();
    driver.until(|bench| state(bench) == Connection::CONNECTED);
}

#[test]
fn a_missing_robot_is_not_an_error() {
    let unused = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut driver = Driver::new(&format!("tcp:{unused}"));
    driver.until(|bench| connection(bench).attempts >= 2 && state(bench) == Connection::LOST);
    assert_eq!(driver.bench.exported_at("odometry"), None);
}
