//! The driver on a test bench, with a server for tests behind a real TCP connection.

mod convert;
#[path = "../../../../devices/player/tests/it/server.rs"]
mod server;

use core::f64::consts::FRAC_PI_2;
use std::thread;

use jde_device::emulate::{DriverTest, EmulatedDevice, Emulator, refusal};
use jde_schema::bench::Bench;

use super::*;
use server::{ALL, BASE, LASER, SONARS, Server};

impl Emulator for Server {
    fn connected(&mut self) -> Vec<u8> {
        self.connected()
    }

    fn receive(&mut self, bytes: &[u8], _baud: u32) -> Vec<u8> {
        self.receive(bytes)
    }

    fn poll_output(&mut self) -> Vec<u8> {
        self.data()
    }
}

/// A server of these devices, and its driver, which is awake.
fn start(devices: &[server::Address]) -> (EmulatedDevice<Server>, DriverTest<Robot>) {
    let (server, address) = EmulatedDevice::at_tcp(Server::new(devices), 0);
    let mut driver = DriverTest::with_port(&address);
    driver.awake();
    (server, driver)
}

fn exported<T: Value>(driver: &DriverTest<Robot>, name: &str) -> T {
    driver.bench.exported(name).expect("it is exported")
}

fn drive(driver: &mut DriverTest<Robot>, twist: Twist, mut done: impl FnMut() -> bool) {
    while !done() {
        driver.bench.command("velocity", &twist);
        driver.step();
    }
}

#[test]
fn a_robot_is_connected_sensed_and_driven() {
    let (server, address) = EmulatedDevice::at_tcp(Server::new(&ALL), 0);
    server.with(|server| server.stalled = true);
    let mut driver = DriverTest::<Robot>::with_port(&address);
    driver.bench.set("start", Pose2D::new(5.0, 6.0, FRAC_PI_2));
    driver.awake();
    driver.run_until(|bench| {
        bench
            .exported::<Bumpers>("bumpers")
            .is_some_and(|bumpers| bumpers.any())
    });
    let (state, note) = driver.connection();
    assert_eq!(state, Connection::CONNECTED);
    assert!(
        note.starts_with("Player 3.1.0, position2d:0 (stage), laser ranger:1"),
        "{note}"
    );

    let odometry: Odometry = exported(&driver, "odometry");
    let pose = odometry.pose2d();
    assert!(
        (pose.x, pose.y) == (5.0, 6.0) && (pose.theta - FRAC_PI_2).abs() < 1e-9,
        "{pose:?}"
    );
    let Twist { linear, angular, .. } = odometry.twist.twist;
    assert_eq!((linear.x, linear.y, angular.z), (0.3, 0.0, -0.1));
    server.with(|server| server.pose = [2.0, 2.0, 0.5]);
    driver.run_until(|bench| {
        bench
            .exported::<Odometry>("odometry")
            .is_some_and(|odometry| odometry.pose2d().y > 6.1)
    });
    // One metre to the right of the server's x axis is turned as the start is.
    let pose = exported::<Odometry>(&driver, "odometry").pose2d();
    let turn = FRAC_PI_2 - 0.5;
    assert!(
        (pose.x - 5.0 - turn.cos()).abs() < 1e-9 && (pose.y - 6.0 - turn.sin()).abs() < 1e-9,
        "{pose:?}"
    );

    let scan: Box<LaserScan> = Box::new(exported(&driver, "laser"));
    assert_eq!(
        scan.ranges.as_slice(),
        [1.0, 2.0, f32::INFINITY, f32::NEG_INFINITY, 3.0]
    );
    assert_eq!(
        (scan.angle_min, scan.angle_max, scan.angle_increment),
        (-1.0, 1.0, 0.5)
    );
    assert_eq!((scan.range_min, scan.range_max), (0.05, 8.0));
    let mount = exported::<Body>(&driver, "body").laser("laser");
    assert_eq!(mount, Pose2D::new(0.1, 0.0, 0.0));
    let ring: RangeRing = exported(&driver, "sonars");
    assert_eq!(
        (ring.poses.len(), ring.ranges[..3].to_vec()),
        (4, vec![1.0, 2.0, f32::INFINITY])
    );
    assert!(ring.ranges[3].is_nan());
    assert_eq!(
        (ring.field_of_view, ring.min_range, ring.max_range),
        (2.0, 0.05, 8.0)
    );
    let bumpers: Bumpers = exported(&driver, "bumpers");
    let pressed = |row: &[Flag]| row.iter().map(|flag| flag.get()).collect::<Vec<_>>();
    assert_eq!(
        (pressed(&bumpers.front), pressed(&bumpers.rear)),
        (vec![false, true], vec![true])
    );
    assert!(bumpers.stalled.get());
    let battery: BatteryState = exported(&driver, "battery");
    assert_eq!(
        (battery.voltage, battery.percentage, battery.power_supply_status),
        (12.5, 0.8, 2)
    );
    assert!(battery.current.is_nan() && battery.charge.is_nan());
    let head: PanTilt = exported(&driver, "pan_tilt");
    assert_eq!(
        (head.pan as f32, head.tilt as f32),
        (0.1, -0.2),
        "Player counts the tilt upwards"
    );

    let mut twist = Twist::planar(0.25, -0.5);
    twist.linear.y = 0.1;
    drive(&mut driver, twist, || {
        server.with(|server| server.velocities.contains(&[0.25, 0.1, -0.5]))
    });
    assert!(server.with(|server| server.motors_on));
}

#[test]
fn the_exports_of_a_lost_server_are_retracted_and_its_odometry_continues() {
    let (server, mut driver) = start(&ALL);
    for noise in [None, Some(vec![0xFF; 40])] {
        driver.run_until(|bench| bench.exported::<LaserScan>("laser").is_some());
        server.with(|server| match noise.clone() {
            Some(noise) => server.noise = noise,
            None => server.silent = true,
        });
        let reason = driver.wait_lost();
        let expected = if noise.is_some() {
            "which no Player server sends"
        } else {
            "no data of position2d:0"
        };
        assert!(reason.contains(expected), "{reason}");
        for export in [
            "odometry", "sonars", "laser", "battery", "bumpers", "pan_tilt", "body",
        ] {
            assert_eq!(driver.bench.exported_at(export), None, "{export}");
        }
        server.with(|server| {
            server.silent = false;
            server.pose[0] += 1.0;
        });
    }
    driver.run_until(|bench| bench.exported::<Odometry>("odometry").is_some());
    let pose = exported::<Odometry>(&driver, "odometry").pose2d();
    assert!((pose.x.hypot(pose.y) - 2.0).abs() < 1e-9, "{pose:?}");
}

#[test]
fn a_laser_that_is_silent_alone_is_retracted() {
    let (server, mut driver) = start(&[BASE, LASER, SONARS]);
    driver.run_until(|bench| bench.exported_at("laser").is_some() && bench.exported_at("sonars").is_some());
    server.with(|server| server.subscribed.retain(|device| *device != LASER));
    driver.run_until(|bench| bench.exported_at("laser").is_none());
    assert_eq!(driver.connection().0, Connection::CONNECTED);
    assert!(driver.bench.exported_at("sonars").is_some() && driver.bench.exported_at("odometry").is_some());
}

#[test]
fn without_iterations_the_robot_receives_nothing() {
    let (server, mut driver) = start(&[BASE]);
    drive(&mut driver, Twist::planar(0.3, 0.0), || {
        server.with(|server| server.velocities.contains(&[0.3, 0.0, 0.0]))
    });
    // The server sends data only while no input waits: after some of them, earlier commands have arrived.
    let wait = |polls: u32| {
        let from = server.with(|server| server.polls);
        while server.with(|server| server.polls) < from + polls {
            thread::yield_now();
        }
    };
    wait(5);
    server.with(|server| server.velocities.clear());
    wait(200);
    assert_eq!(server.with(|server| server.velocities.clone()), [[0.0; 3]; 0]);
}

#[test]
fn a_driver_that_sleeps_or_is_dropped_stops_the_robot() {
    for dropped in [false, true] {
        let (server, mut driver) = start(&[BASE]);
        drive(&mut driver, Twist::planar(0.3, 0.0), || {
            server.with(|server| server.velocities.contains(&[0.3, 0.0, 0.0]))
        });
        if dropped {
            drop(driver);
        } else {
            driver.bench.sleep().expect("it sleeps");
            assert_eq!(driver.bench.exported_at("odometry"), None);
            assert_eq!(driver.bench.exported_at("connection"), None);
        }
        while !server.with(|server| server.velocities.ends_with(&[[0.0; 3]])) {
            thread::yield_now();
        }
    }
}

#[test]
fn a_command_of_the_head_reaches_the_server() {
    let (server, mut driver) = start(&ALL);
    driver.run_until(|bench| bench.exported::<PanTilt>("pan_tilt").is_some());
    let target = PanTilt {
        pan: 0.5,
        tilt: -0.25,
        pan_velocity: 1.0,
        tilt_velocity: 1.0,
        ..PanTilt::default()
    };
    driver.bench.command("head", &target);
    driver.run_until(|_| server.with(|server| server.heads.contains(&[0.5, 0.25, 0.8, 1.0, 1.0])));
}

#[test]
fn a_server_without_the_named_device_is_a_loss_that_names_those_it_has() {
    let (_server, address) = EmulatedDevice::at_tcp(Server::new(&[BASE, SONARS]), 0);
    let mut driver = DriverTest::<Robot>::with_port(&address);
    driver.bench.set("laser_device", Text::<28>::new("laser:0"));
    driver.awake();
    let reason = driver.wait_lost();
    assert!(
        reason.contains("it has no laser:0; it has position2d:0, ranger:0"),
        "{reason}"
    );
}

#[test]
fn invalid_settings_are_errors_before_the_port_is_opened() {
    let error = |key: &str, text: &str| {
        refusal::<Robot>(|bench| match key {
            "port" => bench.set(key, Text::<256>::new(text)),
            _ => bench.set(key, Text::<28>::new(text)),
        })
    };
    assert!(error("port", "").contains("tcp:HOST:PORT"));
    assert!(error("port", "serial:/dev/ttyUSB0@9600").contains("tcp:HOST:6665"));
    for (key, wrong) in [
        ("laser_device", "sonar:0"),
        ("sonar_device", "ranger"),
        ("bumper_device", "on"),
        ("battery_device", "power:x"),
        ("head_device", "ptz:65536"),
    ] {
        let reason = error(key, wrong);
        assert!(
            reason.starts_with(&format!("{key} = \"{wrong}\": it can be auto, none or ")),
            "{reason}"
        );
    }
    let mut bench = Bench::<Robot>::new();
    assert_eq!(bench.inspect(), Ok(vec![]), "an inspection does not connect");
    bench.set_real_time(false);
    assert!(
        bench
            .awake()
            .expect_err("it needs real time")
            .reason
            .contains("lockstep")
    );
}
