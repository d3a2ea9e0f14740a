//! The driver over TCP and over a pseudo-terminal, connected to a scripted robot, which uses the same
//! library.

mod robot;

use core::f64::consts::FRAC_PI_2;
use std::net::TcpListener;
use std::thread;
use std::time::Instant;

use jde_p2os::*;
use jde_schema::bench::Bench;
use jde_schema::prelude::{
    BatteryState, Bumpers as Pressed, Connection, LaserScan, Odometry, PanTilt, Pose2D, RangeRing, Text,
    Twist, WheelEncoders,
};

use super::Pioneer;
use robot::{Robot, Script};

/// The driver, and the time at which it was made.
struct Driver {
    bench: Bench<Pioneer>,
    start: Instant,
}

impl Driver {
    fn new(port: &str) -> Self {
        let mut driver = Self::asleep(port);
        driver.bench.awake().expect("it is rightly configured");
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
        let done = self.bench.iterate().map_err(|failure| failure.reason);
        thread::yield_now();
        done
    }

    /// Iterates until a condition holds. If it never does, the test times out.
    fn until(&mut self, mut good: impl FnMut(&Bench<Pioneer>) -> bool) {
        while !good(&self.bench) {
            self.step().expect("a driver whose robot fails does not fail");
        }
    }

    fn up(&mut self) {
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

fn hear_sonars(script: &mut Script) {
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
fn a_robot_behind_tcp_is_met_driven_and_sensed() {
    let (robot, address) = Robot::at_tcp("p3dx-sh");
    robot.with(|script| {
        hear_sonars(script);
        script.sip.stall_bumpers = 0b0000_0010_0000_0011;
    });
    let mut driver = Driver::asleep(&address);
    driver.bench.set("start", Pose2D::new(1.0, 2.0, FRAC_PI_2));
    driver.bench.awake().unwrap();
    driver.up();
    // The configuration of the scripted robot has no watchdog.
    let said = |words: &str| driver.bench.log().iter().any(|(_, line)| line.contains(words));
    assert!(said("its watchdog is off"));
    assert_eq!(
        connection(&driver.bench).note.as_str(),
        "AMRISim, Pioneer p3dx-sh"
    );

    driver.drive(Twist::planar(0.25, -0.5), || {
        robot.with(|script| {
            script.heard.contains(&Command::Velocity(250))
                && script.heard.contains(&Command::RotVelocity(-29))
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
fn a_simulators_laser_is_seen_in_metres_from_right_to_left() {
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
}

#[test]
fn a_robot_at_a_serial_line_is_met_and_driven() {
    let (robot, address) = Robot::at_line("amigo");
    let mut driver = Driver::new(&address);
    driver.until(|bench| state(bench) == Connection::CONNECTED);
    driver.drive(Twist::planar(-0.1, 0.0), || {
        robot.with(|script| script.heard.contains(&Command::Velocity(-100)))
    });
}

#[test]
fn what_a_lost_robot_said_is_taken_back_and_it_is_met_again_where_it_was() {
    let (robot, address) = Robot::at_tcp("p3dx-sh");
    robot.with(hear_sonars);
    let mut driver = Driver::new(&address);
    driver.up();
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
        for export in ["odometry", "sonars", "laser", "battery", "bumpers", "encoders"] {
            assert_eq!(driver.bench.exported_at(export), None, "{export}");
        }
        robot.with(|script| {
            (script.mute, script.sip.x) = (false, 7);
        });
        driver.up();
        let odometry: Odometry = driver.bench.exported("odometry").unwrap();
        assert!((odometry.pose2d().x - 0.15).abs() < 1e-9);
    }
}

#[test]
fn without_iterations_the_robot_hears_nothing() {
    let (robot, address) = Robot::at_tcp("p3dx");
    robot.with(hear_sonars);
    let mut driver = Driver::new(&address);
    driver.up();
    driver.drive(Twist::planar(0.3, 0.0), || {
        robot.with(|script| script.heard.contains(&Command::Velocity(300)))
    });
    // After some more reports of the robot, earlier bytes in transit have arrived.
    let sayings = |count: u32| {
        let from = robot.with(|script| script.said);
        while robot.with(|script| script.said) < from + count {
            thread::yield_now();
        }
    };
    sayings(5);
    robot.with(|script| script.heard.clear());
    sayings(50);
    assert_eq!(robot.with(|script| script.heard.clone()), []);
}

#[test]
fn asleep_or_thrown_away_it_leaves_a_robot_that_is_stopped_and_off() {
    let farewell = [
        Command::Velocity(0),
        Command::RotVelocity(0),
        Command::Enable(false),
        Command::Sonar(0),
        Command::Close(Form::One),
    ];
    for thrown_away in [false, true] {
        let (robot, address) = Robot::at_tcp("p3dx");
        robot.with(hear_sonars);
        let mut driver = Driver::new(&address);
        driver.up();
        driver.drive(Twist::planar(0.3, 0.0), || {
            robot.with(|script| script.heard.contains(&Command::Velocity(300)))
        });
        if thrown_away {
            drop(driver);
        } else {
            driver.bench.sleep().unwrap();
            assert_eq!(driver.bench.exported_at("odometry"), None);
            assert_eq!(driver.bench.exported_at("connection"), None);
        }
        while !robot.with(|script| script.heard.ends_with(&farewell)) {
            thread::yield_now();
        }
    }
}

#[test]
fn a_command_for_the_head_reaches_the_camera_and_where_it_looks_is_told() {
    let (robot, address) = Robot::at_tcp("p3dx");
    let mut driver = Driver::asleep(&address);
    driver.bench.set("head_kind", Text::<28>::new("vc-c4-one-way"));
    driver.bench.awake().unwrap();
    let look = PanTilt {
        pan: 0.2,
        tilt: -0.1,
        pan_velocity: 1.0,
        tilt_velocity: 1.0,
        ..PanTilt::default()
    };
    driver.bench.command("head", &look);
    driver.until(|bench| {
        bench
            .exported::<PanTilt>("pan_tilt")
            .is_some_and(|head| (head.pan - 0.2).abs() < HEAD_UNIT && (head.tilt + 0.1).abs() < HEAD_UNIT)
    });
    let told = HeadCommand::PanTilt { pan: -102, tilt: 51 }.to_bytes();
    assert!(robot.with(|script| script.heard.contains(&Command::Tty2(told))));
}

#[test]
fn what_a_person_must_mend_is_said_at_once() {
    let said = |set: &dyn Fn(&mut Bench<Pioneer>)| {
        let mut driver = Driver::asleep("tcp:127.0.0.1:1");
        set(&mut driver.bench);
        let found = driver.bench.inspect().unwrap();
        let reason = driver.bench.awake().unwrap_err().reason;
        let said: Vec<_> = found.iter().map(|problem| &*problem.words).collect();
        assert_eq!(said, [&*reason], "an inspection says the same");
        reason
    };
    assert!(said(&|bench| bench.set("port", Text::<256>::new(""))).contains("port = "));
    assert!(said(&|bench| bench.set("port", Text::<256>::new("udp:x"))).contains("serial:PATH@BAUD"));
    assert!(said(&|bench| bench.set("model", Text::<1024>::new("p9"))).contains("`p3dx`"));
    assert!(said(&|bench| bench.set("model", Text::<1024>::new("none.toml"))).contains("none.toml"));
    assert!(said(&|bench| bench.set("laser_mode", Text::<28>::new("maybe"))).contains("auto, on or off"));
    assert!(said(&|bench| bench.set("head_kind", Text::<28>::new("neck"))).contains("vc-c4"));
    let mut driver = Driver::asleep("tcp:127.0.0.1:1");
    assert_eq!(
        driver.bench.inspect(),
        Ok(vec![]),
        "whether it answers is not tried"
    );
    driver.bench.set_real_time(false);
    assert!(driver.bench.awake().unwrap_err().reason.contains("lockstep"));
}

#[test]
fn a_robot_of_an_unknown_kind_is_an_error_that_says_what_to_do_and_a_file_mends_it() {
    let (_robot, address) = Robot::at_tcp("roomba");
    let mut driver = Driver::new(&address);
    let words = loop {
        if let Err(words) = driver.step() {
            break words;
        }
    };
    assert!(words.contains("`roomba`") && words.contains("`p3at`"), "{words}");
    drop(driver);

    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, include_str!("../../../../crates/p2os/models/p3at.toml")).unwrap();
    let mut driver = Driver::asleep(&address);
    driver
        .bench
        .set("model", Text::<1024>::new(path.to_str().unwrap()));
    driver.bench.awake().unwrap();
    driver.until(|bench| state(bench) == Connection::CONNECTED);
}

#[test]
fn a_robot_that_is_not_there_is_no_error() {
    let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut driver = Driver::new(&format!("tcp:{gone}"));
    driver.until(|bench| connection(bench).attempts >= 2 && state(bench) == Connection::LOST);
    assert_eq!(driver.bench.exported_at("odometry"), None);
}
